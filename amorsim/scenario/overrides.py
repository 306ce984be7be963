"""Settings of the command line, ``robots.rover.controller.speed=0.2``, made in a document."""

from __future__ import annotations

import os
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import attrs

from amorsim.core.errors import DocumentError, Fault
from amorsim.plugins.registry import Registry
from amorsim.scenario.document import Document
from amorsim.scenario.elsewhere import named_files
from amorsim.scenario.faults import Book, Source
from amorsim.scenario.layout import Path_
from amorsim.scenario.toml_values import as_toml, keys_as_toml, parse_value

__all__ = ["overridden", "override"]

_EXPECTED = "expected PATH=VALUE, as in simulation.dt=0.05 or robots.0.controller.speed=0.2"


@attrs.frozen(kw_only=True)
class _Setting:
    """A value for a path in a document, and the text that says so."""

    path: tuple[str, ...]
    value: Any
    text: str

    @property
    def file(self) -> str:
        """What faults name in the place of a file."""
        return f"--set {self.text}"

    @property
    def chooses_model(self) -> bool:
        """Whether it says of which model a robot or a sensor is, so that all others are about what that says."""
        is_of_sensor = len(self.path) == 5 and self.path[2] == "sensors"
        return self.path[0] == "robots" and self.path[-1] == "model" and (len(self.path) == 3 or is_of_sensor)


def overridden(
    source: str | dict[str, Any], path: Path, overrides: Iterable[str], book: Book, registry: Registry
) -> dict[str, Any]:
    """The tables of a document with settings; the book then knows which values came from which, and what is wrong.

    Parameters
    ----------
    source
        The document's text, or its tables where it has none.
    path
        Its file, where relative paths in it start.
    """
    settings = _parsed(overrides, book)
    if isinstance(source, dict):
        if not settings:
            return source
        source = "".join(f"{keys_as_toml((key,))} = {as_toml(value)}\n" for key, value in source.items())
    document = Document(source, path, registry=registry)
    _apply(document, settings, book)
    return document.values


def override(document: Document, overrides: Iterable[str], registry: Registry) -> None:
    """Make settings in a document that is to be saved; files that they name are those that they mean from here.

    Raises
    ------
    ScenarioError
        With what is wrong with the settings.
    """
    book = Book(Source(file="", folder=Path()))
    for made in _apply(document, _parsed(overrides, book), book):
        for named in list(named_files(document.values, registry, Path.cwd())):
            if named.at[: len(made)] == made:
                whole = named.said(os.path.abspath(named.name))  # noqa: PTH100 - a link keeps its name
                document.set(".".join(map(str, named.at)), whole)
    book.raise_if_any()


def _apply(document: Document, settings: Iterable[_Setting], book: Book) -> list[Path_]:
    """Make settings in a document, and note where they were made and what is wrong with them."""
    places = []
    for setting in sorted(settings, key=lambda setting: not setting.chooses_model):
        try:
            made = document._override(setting.path, _whole(setting))
        except DocumentError as error:
            book.add(Fault(file=setting.file, path=error.path, message=error.problem))
        except RecursionError:
            name = ".".join(setting.path)
            book.add(Fault(file=setting.file, path=name, message="tables or lists in one another, too many"))
        else:
            # Relative paths of the command line start where it was typed.
            book.set_source(tuple(map(str, made)), Source(file=setting.file, folder=Path.cwd()))
            places.append(made)
    return places


def _parsed(texts: Iterable[str], book: Book) -> list[_Setting]:
    """What ``PATH=VALUE`` texts say: a value is one of TOML, or else a plain text."""
    if isinstance(texts, str):
        problem = f"expected a list of settings, as [{texts!r}], got a text"
        book.add(Fault(file="", path="overrides", message=problem))
        return []
    found = []
    for text in texts:
        name, equals, value = text.partition("=")
        path = tuple(part.strip() for part in name.split("."))
        if not equals or not all(path):
            book.add(Fault(file=f"--set {text}", path="", message=_EXPECTED))
        else:
            found.append(_Setting(path=path, value=_value(value.strip()), text=text))
    return found


def _value(text: str) -> Any:
    try:
        return parse_value(text)
    except (ValueError, RecursionError):
        return text


def _whole(setting: _Setting) -> Any:
    """The value, a model's file by its whole path: the document looks for it as it would for its own."""
    value = setting.value
    if setting.chooses_model and isinstance(value, str) and value.endswith(".toml"):
        return os.path.abspath(value)  # noqa: PTH100 - a link keeps the name that it was given
    return value
