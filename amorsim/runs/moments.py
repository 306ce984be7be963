"""Reading single moments of a run's text files, however large the files are."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import BinaryIO

from amorsim.core.errors import RunError
from amorsim.runs.tables import LONGEST_LINE, check_file, read_header

__all__ = ["Cells", "TimedLines"]

Cells = list[bytes]

BLOCK = 1 << 16  # [bytes] that are read at once
FEW = 4096  # bytes that hold the last lines
FARTHEST = 1 << 23  # [bytes] that `last` looks back


class TimedLines:
    """The lines of a run's text file, found by their time; only some blocks are ever in memory.

    Lines stand in the order of their times, so that a time is found by halving. What follows the last line end is left
    out: the run was killed while it was written. A line without a time, or with another number of cells than the header
    has, is left out too, and `damaged` is called with the error the first time that it is met.

    Parameters
    ----------
    path
        The file.
    name
        Of the file within the folder, without ``.csv``: it sets which columns there must be.
    with_replicas
        Whether the column `replica` must be there.
    damaged
        Called with the error of each line that is damaged.

    Attributes
    ----------
    columns
        The place of each column.

    Raises
    ------
    RunError
        If the file cannot be read, or its header is damaged.
    """

    def __init__(
        self, path: Path, name: str, *, with_replicas: bool = False, damaged: Callable[[RunError], None]
    ) -> None:
        check_file(path)
        header, self._start = read_header(path, name, with_replicas=with_replicas)
        self.path = path
        self.columns: Mapping[str, int] = {column: place for place, column in enumerate(header)}
        self._time = self.columns["time"]
        self._damaged = damaged
        self._met: set[int] = set()  # where damaged lines begin
        try:
            self._file: BinaryIO = path.open("rb", buffering=0)
            self._end = self._last_line_end(self._file.seek(0, 2))
        except OSError as error:
            raise self._unreadable(error) from None
        self._asked = (math.nan, math.nan)  # the last arguments of `at`, and what it returned
        self._found: list[Cells] = []
        self._hint = (-math.inf, self._start)  # all lines before this place are earlier than this time

    def close(self) -> None:
        """Close the file; again if one likes."""
        self._file.close()

    # ---------------------------------------------------------------------------------------------------------- lines

    def at(self, time: float, within: float) -> list[Cells]:
        """The cells of all lines whose time is less than `within` from `time` [s]."""
        if self._asked != (time, within):  # of one moment, each robot's are asked for
            self._found = []
            for _, moment, cells in self._lines(self._first(time - within)):
                if moment >= time + within:
                    break
                self._found.append(cells)
            self._asked = (time, within)
        return self._found

    def last(self, time: float, is_wanted: Callable[[Cells], bool]) -> Cells | None:
        """The last wanted line at or before `time` [s]; None if there is none in the 8 MiB before it."""
        end = self._first(math.nextafter(time, math.inf))
        limit = max(self._start, end - FARTHEST)
        size = FEW  # mostly, one of the last lines is wanted
        while end > limit:
            begin = max(self._start, end - size)
            if begin > self._start:
                begin = self._line_start(begin)
                if begin >= end:  # a line that is longer
                    size *= 2
                    continue
            for line in reversed(list(self._lines(begin, end))):
                if is_wanted(line[2]):
                    return line[2]
            end, size = begin, min(2 * size, BLOCK)
        return None

    @property
    def last_time(self) -> float | None:
        """The time of the last line [s]; None if there is none."""
        end, size = self._end, BLOCK
        while end > self._start:
            begin = max(self._start, end - size)
            begin = begin if begin == self._start else self._line_start(begin)
            lines = list(self._lines(begin, end)) if begin < end else []
            if lines:
                return lines[-1][1]
            if begin == self._start:
                break
            size *= 2
        return None

    # --------------------------------------------------------------------------------------------------------- search

    def _first(self, time: float) -> int:
        """Where the first line of at least `time` begins; the end of the lines if there is none."""
        low, high = self._start, self._end
        if self._hint[0] <= time:  # moments are mostly asked for one after the other
            low = self._hint[1]
            near = low + BLOCK
            if near < high and (self._time_after(near, high) or math.inf) >= time:
                high = near
        # Lines that begin before `low`, which is the start of one, are earlier; those from `high` on are not.
        while high - low > BLOCK:
            middle = (low + high) // 2
            found = self._next(middle, high)
            if found is None or found[1] >= time:
                high = middle
            else:
                low = found[0]
        for place, moment, _ in self._lines(low):
            if moment >= time:
                self._hint = (time, place)
                return place
        return self._end

    def _time_after(self, place: int, end: int) -> float | None:
        found = self._next(place, end)
        return None if found is None else found[1]

    def _next(self, place: int, end: int) -> tuple[int, float] | None:
        """The first line that begins at or after a place and before `end`: where, and its time."""
        begin = self._line_start(place)
        return next(((at, time) for at, time, _ in self._lines(begin, end)), None) if begin < end else None

    def _line_start(self, place: int) -> int:
        """Where the first line begins at or after a place."""
        at = place - 1  # the line end before it may be there
        while at < self._end:
            data = self._read(at, BLOCK)
            found = data.find(b"\n")
            if found >= 0:
                return at + found + 1
            if not data:
                break
            at += len(data)
        return self._end

    def _last_line_end(self, size: int) -> int:
        """Where the last whole line ends."""
        end = size
        while end > self._start:
            begin = max(self._start, end - BLOCK)
            found = self._read(begin, end - begin).rfind(b"\n")
            if found >= 0:
                return begin + found + 1
            end = begin
        return self._start

    # --------------------------------------------------------------------------------------------------------- reading

    def _lines(self, begin: int, end: int | None = None) -> Iterator[tuple[int, float, Cells]]:
        """Where each line begins from a line's start on, its time [s] and its cells; those that begin before `end`."""
        end = self._end if end is None else end
        rest = b""
        place = at = begin
        while place < end:
            data = self._read(at, min(BLOCK, self._end - at))
            if not data:
                return
            at += len(data)
            *lines, rest = (rest + data).split(b"\n")
            if len(rest) > LONGEST_LINE:
                raise RunError(f"{self.path}: is damaged: a line is longer than {LONGEST_LINE} bytes")
            for line in lines:
                if place >= end:
                    return
                cells = line.removesuffix(b"\r").split(b",")
                time = self._time_of(cells, place)
                if time is not None:
                    yield place, time, cells
                place += len(line) + 1

    def _time_of(self, cells: Cells, place: int) -> float | None:
        if len(cells) != len(self.columns):
            problem = f"is damaged: expected {len(self.columns)} cells, got {len(cells)}"
        else:
            try:
                time = float(cells[self._time])
            except ValueError:
                time = math.nan
            if math.isfinite(time):
                return time
            problem = f"time: expected a finite number, got {_shown(cells[self._time])}"
        self._note(place, problem)
        return None

    def numbers(self, cells: Cells, columns: list[int]) -> list[float]:
        """The numbers of a line in some columns; an empty cell is nan, and so is one that is damaged."""
        try:
            return [float(cells[column] or b"nan") for column in columns]
        except ValueError:
            pass
        found = []
        for column in columns:
            try:
                found.append(float(cells[column] or b"nan"))
            except ValueError:
                found.append(math.nan)
                name = list(self.columns)[column]
                time = cells[self._time].decode()
                self._damaged_once(
                    hash((time, column)),
                    f"{self.path}, at {time} s, {name}: expected a number, got {_shown(cells[column])}",
                )
        return found

    def _note(self, place: int, problem: str) -> None:
        if place not in self._met:
            number = 1 + sum(self._read(at, min(BLOCK, place - at)).count(b"\n") for at in range(0, place, BLOCK))
            self._damaged_once(place, f"{self.path}, line {number}, {problem}")

    def _damaged_once(self, key: int, text: str) -> None:
        if key not in self._met:
            self._met.add(key)
            self._damaged(RunError(text))

    def _read(self, place: int, size: int) -> bytes:
        try:
            self._file.seek(place)
            return self._file.read(size)
        except (OSError, ValueError) as error:  # ValueError: closed
            raise self._unreadable(error) from None

    def _unreadable(self, error: Exception) -> RunError:
        return RunError(f"{self.path}: cannot be read ({getattr(error, 'strerror', None) or error})")


def _shown(cell: bytes) -> str:
    return repr(cell[:60].decode(errors="replace"))
