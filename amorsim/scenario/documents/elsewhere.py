"""The names of files in a document that is saved elsewhere: relative to there, or of copies."""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

from amorsim.core.errors import MapError, PluginError, RunError
from amorsim.plugins.registry import Registry
from amorsim.scenario.documents.field_at import field_at
from amorsim.scenario.files.copied_files import Copies
from amorsim.scenario.files.maps import MapFile, find_loader
from amorsim.scenario.programs.controller_files import is_controller_file
from amorsim.scenario.reading.faults import FaultCollector, Node
from amorsim.scenario.reading.fields import read_component
from amorsim.scenario.toml.layout import Path_, copied_tables, found_at

__all__ = ["NamedFile", "copied", "named_files", "near", "renamed"]


class NamedFile(NamedTuple):
    """A name of a file in a document: the path of the value, what kind of file it is, and the rest of the value."""

    at: Path_
    kind: str  # "map", "model", "program" or "data"
    name: str
    rest: str = ""  # of a program: ":" and what is meant in it

    def spelled(self, name: str) -> str:
        """The value for another name of the file."""
        return name + self.rest


def named_files(values: dict[str, Any], registry: Registry, folder: Path) -> Iterator[NamedFile]:
    """All files that a document names."""
    for at, text in _texts(values, ()):
        last = at[-1]
        if last == "map" and (at == ("world", "map") or "knowledge" in at):
            yield NamedFile(at, "map", text)
        elif last == "model" and text.endswith(".toml"):
            yield NamedFile(at, "model", text)
        elif last == "use" and is_controller_file(text):
            file, colon, name = text.rpartition(":")
            yield NamedFile(at, "program", file, colon + name)
        elif (field := field_at(values, at, registry, folder)) is not None and field.file and text:
            yield NamedFile(at, "data", text)


def _texts(value: Any, path: Path_) -> Iterator[tuple[Path_, str]]:
    if isinstance(value, str):
        yield path, value
    inner = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    for key, item in inner:
        yield from _texts(item, (*path, key))


def near(file: Path, folder: Path) -> str:
    """The name of a file from a folder.

    Raises
    ------
    RunError
        If there is none but an absolute one, as for another drive of Windows.
    """
    try:
        return Path(os.path.relpath(file, folder)).as_posix()
    except ValueError:
        raise RunError(f"{file}: no relative path leads there from {folder}; copy the files") from None


def renamed(values: dict[str, Any], registry: Registry, here: Path, folder: Path) -> dict[str, Any]:
    """Tables that name the same files from another folder.

    Parameters
    ----------
    values
        Tables of a scenario, by their lists: ``{"robots": [...]}``.
    here, folder
        Where their names of files start, and where those of the result do.

    Raises
    ------
    RunError
        If no relative path leads from there to one of the files.
    """
    found: dict[str, Any] = copied_tables(values)
    for named in named_files(values, registry, here):
        holder = found_at(found, named.at[:-1])
        file = Path(os.path.abspath(here / named.name))  # noqa: PTH100 - a link keeps the name that it was given
        holder[named.at[-1]] = named.spelled(near(file, folder))
    return found


def copied(named: NamedFile, file: Path, values: dict[str, Any], copies: Copies, registry: Registry) -> str:
    """The name of a file's copy; the copy is made with all that the file needs. Not for models.

    Raises
    ------
    RunError
        If it cannot be copied.
    """
    if named.kind == "map":
        return copies.of_map(_map_file(file, found_at(values, named.at[:-1]), registry))
    if named.kind == "program":
        component = {"use": f"{file}{named.rest}"}
        copies.of_program(component)
        return component["use"].removesuffix(named.rest)
    return copies.of(str(file))


def _map_file(file: Path, table: dict[str, Any], registry: Registry) -> MapFile:
    use = table.get("use")
    try:
        _, cls = find_loader(file, use if isinstance(use, str) else None, registry)
    except (MapError, PluginError) as error:
        raise RunError(f"{file}: cannot be copied: {error}") from error
    loader = read_component(cls, Node(table, (), FaultCollector.silent()), beside=("map", "use", "landmarks"))
    if loader is None:
        raise RunError(f"{file}: cannot be copied: its options are at fault; see `faults`")
    return MapFile(path=file, loader=loader)
