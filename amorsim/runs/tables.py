"""Reading a run's text files: columns as arrays, or line by line; errors name file, line and column."""

from __future__ import annotations

import csv
import itertools
import math
import stat
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import attrs
import numpy as np

from amorsim.array_types import AnyArray
from amorsim.core.errors import RunError
from amorsim.core.unknown_names import no_such

__all__ = ["LARGEST", "LONGEST_LINE", "Line", "check_file", "last_line", "read_columns", "read_header", "read_lines"]

LARGEST = 1e100  # in size, except commands: no other number of a run is larger
LONGEST_LINE = 1 << 26  # [bytes]
_BLOCK = 1 << 24  # [bytes] that are read at once
_TAIL = 1 << 16  # [bytes] in which a last line of poses lies

_TEXTS = {"robot", "obstacle", "part", "other_part", "kind", "other", "path", "value"}
_WHOLES = {"replica", "tick"}
_POSE = ("x", "y", "heading")
_TWIST = ("forward", "left", "turn")


@attrs.frozen
class _Kind:
    """The format of one kind of file: its required columns, and those with finite numbers only."""

    finite: tuple[str, ...]
    others: tuple[str, ...]


_KINDS = {
    "poses": _Kind(("time", *(f"{kind}_{key}" for kind in ("true", "estimated") for key in _POSE)), ("robot",)),
    "velocities": _Kind(("time", *(f"{kind}_{key}" for kind in ("true", "estimated") for key in _TWIST)), ("robot",)),
    "commands": _Kind(("time",), ("robot",)),
    "events": _Kind(("time",), ("robot", "kind", "other", "x", "y", "speed", "path", "value", "tick")),
    "obstacles": _Kind(("time", *_POSE), ("obstacle",)),
    "parts": _Kind(("time", *_POSE), ("part",)),
    "sensors": _Kind(("time", "stamp"), ("robot",)),
    "beliefs": _Kind(("time",), ("robot",)),
    "estimates": _Kind(("time", *_POSE), ("robot", "xx", "xy", "xh", "yy", "yh", "hh")),
}


class Line(NamedTuple):
    """One line of a run's text file, by column."""

    path: Path
    number: int  # the header is 1
    cells: dict[str, str]

    def text(self, column: str) -> str:
        """The text in a column."""
        if column not in self.cells:
            raise _missing(self.path, column, list(self.cells))
        return self.cells[column]

    def real(self, column: str) -> float:
        """The finite number in a column."""
        text = self.text(column)
        try:
            value = float(text)
        except ValueError:
            value = math.nan
        if not math.isfinite(value):
            raise self.damaged(column, f"expected a finite number, got {_shown(text)}")
        return value

    def whole(self, column: str) -> int:
        """The whole number >= 0 in a column."""
        text = self.text(column)
        if not _is_whole(text):
            raise self.damaged(column, f"expected a whole number >= 0, got {_shown(text)}")
        return int(text)

    def damaged(self, column: str, problem: str) -> RunError:
        """The error for a damaged column of this line."""
        return RunError(f"{self.path}, line {self.number}, {column}: {problem}")


def check_file(path: Path, largest: float = math.inf) -> None:
    """Raise an error unless `path` is a regular file of at most `largest` bytes; a pipe would be read for ever.

    Raises
    ------
    RunError
        If it is not there, cannot be looked at, or is something else.
    """
    try:
        about = path.stat()
    except (OSError, ValueError) as error:
        raise RunError(f"{path}: cannot be read ({getattr(error, 'strerror', None) or error})") from None
    if not stat.S_ISREG(about.st_mode):
        what = "it is a folder" if stat.S_ISDIR(about.st_mode) else "it is not a regular file"
        raise RunError(f"{path}: cannot be read ({what})")
    if about.st_size > largest:
        raise RunError(f"{path}: cannot be read (it has {about.st_size:.3g} bytes; expected at most {largest:.3g})")


def read_lines(path: Path) -> Iterator[Line]:
    """The whole lines of a text file of a run after its header, one by one.

    What follows the last line end is left out: the run was killed while it was written.

    Raises
    ------
    RunError
        If the file cannot be read or a line is damaged.
    """
    blocks = _blocks(path)
    header = _header(path, blocks, "")
    for first, lines in blocks:
        for number, line in enumerate(lines, start=first):
            yield Line(path, number, dict(zip(header, _cells(path, number, line, len(header)), strict=True)))


def last_line(path: Path) -> Line | None:
    """The last whole line of a run's text file, without reading the lines before; None if it has only a header.

    Raises
    ------
    RunError
        If the file cannot be read or the line is damaged. The line's number is counted.
    """
    with _opened(path) as file:
        # Damage between the two counts as a difference and is found by the comparison.
        first = _decoded(path, 1, file.readline(_TAIL)).rstrip("\r\n")
        header = _header(path, iter([(1, [first])]), "")
        file.seek(0, 2)
        size = file.tell()
        file.seek(max(0, size - _TAIL))
        tail = file.read().split(b"\n")[:-1]
        if len(tail) < 2 and size > _TAIL:
            raise RunError(f"{path}: is damaged: its last line is longer than {_TAIL} bytes")
        if len(tail) < 2:
            return None
        file.seek(0)
        number = sum(block.count(b"\n") for block in iter(lambda: file.read(_BLOCK), b""))
    text = _decoded(path, number, tail[-1]).removesuffix("\r")
    return Line(path, number, dict(zip(header, _cells(path, number, text, len(header)), strict=True)))


def read_header(path: Path, name: str, *, with_replicas: bool = False) -> tuple[list[str], int]:
    """The names of the columns of a text file of a run, and where its first line after them begins [bytes].

    Parameters and errors are those of `read_columns`.
    """
    with _opened(path) as file:
        line = file.readline(LONGEST_LINE)
    text = _decoded(path, 1, line).rstrip("\r\n")
    return _header(path, iter([(1, [text])]), name, with_replicas), len(line)


def read_columns(path: Path, name: str, *, with_replicas: bool = False) -> dict[str, AnyArray]:
    """The columns of a text file of a run: texts as objects, `replica` and `tick` whole, all others floats.

    An empty cell is nan. Of a file that is not one of amorsim's own, columns that are not numbers are texts.

    Parameters
    ----------
    name
        Of the file within the folder, without ``.csv``, such as ``"poses"`` or ``"sensors/laser"``: it sets which
        columns there must be.
    with_replicas
        Whether the column `replica` must be there, in amorsim's own files.

    Raises
    ------
    RunError
        If it cannot be read or is damaged; it names the line and the column.
    """
    kind = _KINDS.get(name.partition("/")[0])
    blocks = _blocks(path)
    header = _header(path, blocks, name, with_replicas)
    found: list[list[AnyArray]] = [[] for _ in header]
    texts: dict[str, str] = {}  # each once, however many lines have it
    for first, lines in blocks:
        cells = _split(path, first, lines, len(header))
        for place, column in enumerate(header):
            here = cells[place :: len(header)]
            found[place].append(_converted(path, first, column, here, kind, name, texts))
    return {column: _joined(parts, column, kind) for column, parts in zip(header, found, strict=True)}


# ------------------------------------------------------------------------------------------------------------- lines


def _opened(path: Path) -> Any:
    check_file(path)
    try:
        return path.open("rb")
    except OSError as error:
        raise RunError(f"{path}: cannot be read ({error.strerror or error})") from None


def _blocks(path: Path) -> Iterator[tuple[int, list[str]]]:
    """The complete lines of a file, many at a time, with the number of the first; the header comes by itself."""
    with _opened(path) as file:
        rest, number = b"", 1
        while True:
            try:
                more = file.read(_BLOCK)
            except OSError as error:
                raise RunError(f"{path}: cannot be read ({error.strerror or error})") from None
            if not more:
                return
            whole, found, last = more.rpartition(b"\n")
            if not found:
                rest += more
                if len(rest) > LONGEST_LINE:
                    raise RunError(f"{path}, line {number}: is damaged: it is longer than {LONGEST_LINE} bytes")
                continue
            lines = [line.removesuffix("\r") for line in _decoded(path, number, rest + whole).split("\n")]
            rest = last
            if number == 1:
                yield 1, lines[:1]
                number, lines = 2, lines[1:]
            if lines:
                yield number, lines
            number += len(lines)


def _decoded(path: Path, number: int, data: bytes) -> str:
    try:
        return data.decode("utf-8")
    except UnicodeDecodeError as error:
        line = number + data.count(b"\n", 0, error.start)
        raise RunError(f"{path}, line {line}: is damaged: byte {data[error.start]:#04x} is not UTF-8") from None


def _header(path: Path, blocks: Iterator[tuple[int, list[str]]], name: str, with_replicas: bool = False) -> list[str]:
    """The names of the columns; raises if one that this kind of file requires is missing."""
    _, lines = next(blocks, (1, [""]))
    header = lines[0].removeprefix("\N{BOM}").split(",")
    for column in header:
        if header.count(column) > 1:
            raise RunError(f"{path}, line 1: is damaged: there are {header.count(column)} columns {_shown(column)}")
    kind = _KINDS.get(name.partition("/")[0])
    needed = [] if kind is None else [*kind.finite, *kind.others]
    for column in ["replica"] * (with_replicas and kind is not None) + needed:
        if column not in header:
            raise _missing(path, column, header)
    for column in header if name.startswith(("sensors/", "velocities")) else ():
        channel, _, rest = column.partition("_")
        other = {"true": "measured", "measured": "true"}.get(channel)
        if other and column not in needed and f"{other}_{rest}" not in header:
            raise _missing(path, f"{other}_{rest}", header)
    if name.startswith("sensors/"):
        values = sum(column.startswith("true_") for column in header)
        for i in range(values):
            if f"true_{i}" not in header:
                raise _missing(path, f"true_{i}", header)
    return header


def _missing(path: Path, column: str, header: Sequence[str]) -> RunError:
    return RunError(f"{path}, line 1: is damaged: {no_such('column', column, [name[:40] for name in header])}")


def _cells(path: Path, number: int, line: str, count: int) -> list[str]:
    try:
        cells = next(csv.reader([line]), []) if '"' in line else line.split(",")
    except csv.Error as error:
        raise RunError(f"{path}, line {number}: is damaged: {error}") from None
    if len(cells) != count:
        raise RunError(f"{path}, line {number}: is damaged: expected {count} cells, got {len(cells)}")
    return cells


def _split(path: Path, first: int, lines: list[str], count: int) -> list[str]:
    """The cells of lines, one line after the other."""
    if not any('"' in line for line in lines) and all(line.count(",") == count - 1 for line in lines):
        return ",".join(lines).split(",")
    rows = (_cells(path, number, line, count) for number, line in enumerate(lines, start=first))
    return list(itertools.chain.from_iterable(rows))


# ----------------------------------------------------------------------------------------------------------- columns


def _converted(
    path: Path, first: int, column: str, cells: list[str], kind: _Kind | None, name: str, texts: dict[str, str]
) -> AnyArray:
    """The cells of one column as an array; `first` is the number of their first line."""

    def damaged(place: int, expected: str) -> RunError:
        return Line(path, first + place, {}).damaged(column, f"expected {expected}, got {_shown(cells[place])}")

    if column in _TEXTS:
        return _texts(cells, texts)
    if column in _WHOLES:
        for place, cell in enumerate(cells):
            if not _is_whole(cell):
                raise damaged(place, "a whole number >= 0")
        return np.array(list(map(int, cells)), dtype=np.int64)
    try:
        values = np.array([float(cell) if cell else math.nan for cell in cells])
    except ValueError:
        if kind is None:
            return _texts(cells, texts)
        raise damaged(next(i for i, cell in enumerate(cells) if not _is_number(cell)), "a number") from None
    if kind is not None and column in kind.finite:
        bad = np.flatnonzero(~(np.abs(values) <= LARGEST))
        if len(bad):
            raise damaged(int(bad[0]), f"a finite number, of at most {LARGEST:g} in size")
    elif kind is not None and name != "commands":
        bad = np.flatnonzero(np.isfinite(values) & (np.abs(values) > LARGEST))
        if len(bad):
            raise damaged(int(bad[0]), f"a number of at most {LARGEST:g} in size")
    return values


def _joined(parts: list[AnyArray], column: str, kind: _Kind | None) -> AnyArray:
    if not parts:
        return np.empty(0, dtype=object if column in _TEXTS else np.int64 if column in _WHOLES else np.float64)
    if kind is None and len({part.dtype for part in parts}) > 1:  # numbers first, and then something else
        parts = [np.array(list(map(str, part.tolist())), dtype=object) for part in parts]
    return parts[0] if len(parts) == 1 else np.concatenate(parts)


def _texts(cells: list[str], known: dict[str, str]) -> AnyArray:
    found = np.empty(len(cells), dtype=object)
    found[:] = [known.setdefault(cell, cell) for cell in cells]
    return found


def _is_whole(text: str) -> bool:
    return text.isascii() and text.isdigit() and len(text) <= 18  # fits into 64 bits


def _is_number(text: str) -> bool:
    try:
        float(text or "nan")
    except ValueError:
        return False
    return True


def _shown(text: str) -> str:
    return repr(text if len(text) <= 60 else text[:60] + "...")
