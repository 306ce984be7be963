"""The lines in the files where faults are."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any, NamedTuple

import attrs

from amorsim.core.errors import Fault
from amorsim.core.files.reading import read_bytes
from amorsim.scenario.toml.layout import Layout, Path_
from amorsim.scenario.toml.names_in_lists import index_of
from amorsim.scenario.toml.parse import Written, line_numbers, line_of, read_written

__all__ = ["line_at", "with_lines"]


def with_lines(
    faults: Iterable[Fault], known: Mapping[str, Written] | None = None, lines: Mapping[str, int] | None = None
) -> list[Fault]:
    """The faults, each with its line, where its file is one of TOML; files that are `known` are not read again.

    Of another program's file, `lines` are those of a path, or below it.
    """
    files: dict[str, _Said | None] = {name: _said(written) for name, written in (known or {}).items()}
    found = []
    for fault in faults:
        if fault.line is None and fault.file not in files:
            files[fault.file] = _read(fault.file)
        source = files.get(fault.file)
        if fault.line is None and source is not None:
            path = _numbered(source.written.values, fault.path.split(".")) if fault.path else ()
            fault = attrs.evolve(fault, line=line_of(source.written.statements, source.layout, path, source.numbers))
        elif fault.line is None and lines and not fault.file.startswith("--set"):
            parts = fault.path.split(".")
            paths = (".".join(parts[:length]) for length in range(len(parts), 0, -1))
            fault = attrs.evolve(fault, line=next((lines[path] for path in paths if path in lines), None))
        found.append(fault)
    return found


def line_at(file: str, path: str) -> int | None:
    """The line of a file for a path, or for the nearest thing above it."""
    (fault,) = with_lines([Fault(file=file, path=path, message="")])
    return fault.line


class _Said(NamedTuple):
    """The content of a file, and where it is: laid out once for all its faults."""

    written: Written
    layout: Layout
    numbers: list[int]  # of the statements' lines


def _said(written: Written) -> _Said:
    return _Said(written, Layout(written.statements), line_numbers(written.statements))


def _read(file: str) -> _Said | None:
    if not file.endswith(".toml"):
        return None
    try:
        written = read_written(read_bytes(Path(file)).decode().removeprefix("\N{BOM}"))
    except (OSError, ValueError):
        return None
    return _said(written)


def _numbered(values: Any, parts: list[str]) -> Path_:
    """A path with numbers where lists are."""
    path: Path_ = ()
    for part in parts:
        if isinstance(values, list):
            # A number is one: faults have numbers, and names would be sought for each of them.
            is_number = part.isdecimal() and int(part[:9]) < len(values)
            index = int(part) if is_number else index_of(values, part)
            if isinstance(index, str):
                break
            path, values = (*path, index), values[index]
        else:
            path, values = (*path, part), values.get(part) if isinstance(values, dict) else None
    return path
