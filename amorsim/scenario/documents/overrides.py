"""Settings of the command line, ``robots.rover.controller.speed=0.2``, made in a document."""

from __future__ import annotations

import os
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from amorsim.core.errors import DocumentError, Fault
from amorsim.plugins.registry import Registry
from amorsim.scenario.documents.document import Document
from amorsim.scenario.documents.elsewhere import named_files
from amorsim.scenario.documents.settings import Setting, parse_settings
from amorsim.scenario.reading.faults import FaultCollector, Source
from amorsim.scenario.toml.layout import Path_
from amorsim.scenario.toml.literals import as_toml, keys_as_toml

__all__ = ["overridden", "override"]


def overridden(
    source: str | dict[str, Any], path: Path, overrides: Iterable[str], book: FaultCollector, registry: Registry
) -> dict[str, Any]:
    """The tables of a document with settings applied; notes where each value came from, and all faults.

    Parameters
    ----------
    source
        The document's text, or its tables where it has none.
    path
        Its file, where relative paths in it start.
    """
    settings = parse_settings(overrides, book)
    if isinstance(source, dict):
        if not settings:
            return source
        source = "".join(f"{keys_as_toml((key,))} = {as_toml(value)}\n" for key, value in source.items())
    document = Document(source, path, registry=registry)
    _apply(document, settings, book)
    return document.values


def override(document: Document, overrides: Iterable[str], registry: Registry) -> None:
    """Apply settings to a document that is to be saved; file names in them are relative to the current folder.

    Raises
    ------
    ScenarioError
        With what is wrong with the settings.
    """
    book = FaultCollector(Source(file="", folder=Path()))
    for made in _apply(document, parse_settings(overrides, book), book):
        for named in list(named_files(document.values, registry, Path.cwd())):
            if named.at[: len(made)] == made:
                whole = named.spelled(os.path.abspath(named.name))  # noqa: PTH100 - a link keeps its name
                document.set(".".join(map(str, named.at)), whole)
    book.raise_if_any()


def _apply(document: Document, settings: Iterable[Setting], book: FaultCollector) -> list[Path_]:
    """Apply settings to a document, and note where they were made and what is wrong with them."""
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


def _whole(setting: Setting) -> Any:
    """The value, a model's file by its whole path: the document looks for it as it would for its own."""
    value = setting.value
    if setting.chooses_model and isinstance(value, str) and value.endswith(".toml"):
        return os.path.abspath(value)  # noqa: PTH100 - a link keeps the name that it was given
    return value
