"""Scenarios in other programs' files, read by scenario loaders into the tables of a scenario's own file."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from amorsim.contracts import ScenarioDocument, ScenarioLoader
from amorsim.core.error_text import RAISED, error_in_words
from amorsim.core.errors import Fault, PluginError, ScenarioError
from amorsim.core.files.reading import check_readable
from amorsim.plugins.registry import Registry
from amorsim.scenario.documents.settings import Setting, parse_settings
from amorsim.scenario.reading.faults import FaultCollector, Node, Source
from amorsim.scenario.reading.fields import read_component

__all__ = ["find_scenario_loader", "loaders_of_extension", "read_foreign", "split_options"]

_HEAD = 4096
_MOST_BYTES = 10**9
_OPTION = "loader."


def find_scenario_loader(path: Path, registry: Registry) -> tuple[str, type[ScenarioLoader]] | None:
    """Name and class of the loader that reads a file as a scenario: by its extension, and its first bytes; or None."""
    extension = path.suffix.lower()
    if extension in ("", ".toml"):
        return None
    head: bytes | None = None
    for name, cls in _loaders_of(extension, registry):
        if head is None:
            try:
                check_readable(path, _MOST_BYTES)
                with path.open("rb") as file:
                    head = file.read(_HEAD)
            except (OSError, ValueError):  # which the reader of scenarios reports, or that of maps
                return None
        try:
            is_its = cls.sniff(head)
        except RAISED as error:
            registry.report(f"scenario loader {name!r}: {cls.__name__}.sniff() raised {error_in_words(error)}")
            continue
        if is_its:
            return name, cls
    return None


def loaders_of_extension(path: Path, registry: Registry) -> list[str]:
    """The names of the loaders that read files of a file's extension, if they know their first bytes."""
    return [name for name, _ in _loaders_of(path.suffix.lower(), registry)]


def _loaders_of(extension: str, registry: Registry) -> Iterator[tuple[str, type[ScenarioLoader]]]:
    for entry in registry.entries("scenario_loader"):
        try:
            cls: type[ScenarioLoader] = registry.get("scenario_loader", entry.name)
        except PluginError as error:
            registry.report(str(error))
            continue
        if extension in cls.extensions:
            yield entry.name, cls


def split_options(overrides: Iterable[str]) -> tuple[list[str], list[str]]:
    """Settings for a scenario loader, ``loader.KEY=VALUE``, and those for the scenario."""
    texts = [overrides] if isinstance(overrides, str) else list(overrides)
    options = [text for text in texts if text.strip().startswith(_OPTION)]
    return options, [text for text in texts if text not in options]


def read_foreign(path: Path, name: str, cls: type[ScenarioLoader], options: Sequence[str] = ()) -> ScenarioDocument:
    """The content of a file, by the loader of that name, with settings ``loader.KEY=VALUE``.

    Raises
    ------
    ScenarioError
        With the faults of the file, or of the settings.
    """
    book = FaultCollector(Source(file="", folder=path.parent))
    settings = parse_settings(options, book)
    loader = read_component(cls, _options(settings, book))
    book.raise_if_any()
    try:
        document = loader.read(path)
    except ScenarioError:
        raise
    except RAISED as error:  # a third party's loader
        problem = f"the scenario loader {name!r} failed with {error_in_words(error)}"
        raise ScenarioError([Fault(file=str(path), path="", message=problem)]) from error
    if not isinstance(document, ScenarioDocument):
        problem = f"the scenario loader {name!r} gave {document!r}; expected a ScenarioDocument"
        raise ScenarioError([Fault(file=str(path), path="", message=problem)])
    for field, is_right, expected in _FIELDS:
        if not is_right(value := getattr(document, field)):
            problem = f"the scenario loader {name!r} gave {field} = {repr(value)[:200]}; expected {expected}"
            raise ScenarioError([Fault(file=str(path), path="", message=problem)])
    return document


def _is_table(value: Any) -> bool:
    return isinstance(value, dict) and all(isinstance(key, str) for key in value)


def _are_remarks(value: Any) -> bool:
    return isinstance(value, (tuple, list)) and all(isinstance(each, str) for each in value)


def _are_lines(value: Any) -> bool:
    return isinstance(value, Mapping) and all(isinstance(each, int) for each in value.values())


_FIELDS: tuple[tuple[str, Callable[[Any], bool], str], ...] = (
    ("tables", _is_table, 'a table, {"format": 1, "world": ..., "robots": ...}'),
    ("remarks", _are_remarks, "a tuple of texts"),
    ("lines", _are_lines, "whole numbers by paths such as robots.0"),
)


def _options(settings: Sequence[Setting], book: FaultCollector) -> Node:
    """The settings as the table of a component, each from its text."""
    table = {}
    for setting in settings:
        table[".".join(setting.path[1:])] = setting.value
        book.set_source(("loader", *setting.path[1:]), Source(file=setting.file, folder=Path.cwd(), depth=0))
    return Node(table, ("loader",), book)
