"""Comparing the text files of two runs, and the arrays of their beliefs, and naming the first difference."""

from __future__ import annotations

import csv
import filecmp
import itertools
import math
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import TextIO

import attrs
import numpy as np

from amorsim.array_types import AnyArray
from amorsim.core.errors import RunError
from amorsim.runs.array_files import read_arrays, sizes_of
from amorsim.runs.tables import LONGEST_LINE, check_file

__all__ = ["TOLERANCE", "Difference", "first_difference"]

TOLERANCE = 2e-6
"""The largest difference of numbers in files on another kind of processor: they are written to 1e-6."""


@attrs.frozen(kw_only=True)
class Difference:
    """Where two runs' files first differ.

    `is_small`: no number of any file differs by more than `TOLERANCE`, relative to its size if that is
    more than 1.
    """

    file: str
    line: int  # 0 in a file of arrays
    time: float  # [s]; inf where no line holds a time
    tick: int | None
    replica: str
    robot: str
    column: str
    old: str
    new: str
    is_small: bool

    def __str__(self) -> str:
        when = "" if self.tick is None else f"at tick {self.tick} ({self.time:g} s), "
        whose = f"replica {self.replica}, " if self.replica else ""
        whose += f"robot {self.robot!r}, " if self.robot else ""
        where = f"{self.file}, line {self.line}" if self.line else self.file
        return f"{when}{whose}in {where}: {self.column} was {self.old} and is {self.new}"


def first_difference(before: Path, after: Path, dt: float) -> Difference | None:
    """The first difference between the results in two runs' folders; None if they are equal to the letter.

    Results are text files and arrays of beliefs. Of differences at one time, commands count as first, then readings,
    because these cause the others.

    Raises
    ------
    RunError
        If a file cannot be read.
    """
    names = sorted({path.relative_to(folder).as_posix() for folder in (before, after) for path in _tables(folder)})
    names.sort(key=_rank)
    found = [_difference(before / name, after / name, name, dt) for name in names]
    found += [_array_difference(before / name, after / name, name, dt) for name in _array_files(before, after)]
    differences = [difference for difference in found if difference is not None]
    if not differences:
        return None
    first = min(differences, key=lambda difference: difference.time)
    return attrs.evolve(first, is_small=all(difference.is_small for difference in differences))


def _tables(folder: Path) -> list[Path]:
    return [path for part in ("", "sensors/", "estimates/", "beliefs/") for path in folder.glob(f"{part}*.csv")]


def _array_files(*folders: Path) -> list[str]:
    found = {path.relative_to(folder).as_posix() for folder in folders for path in folder.glob("beliefs/*/*.npz")}
    return sorted(found, key=lambda name: (name.rpartition("/")[2], name))


def _array_difference(old: Path, new: Path, name: str, dt: float) -> Difference | None:
    """The first difference between two files of arrays, that of the recorder `arrays`."""
    digits = old.stem.partition("-")[0]
    tick = int(digits) if digits.isdecimal() else None

    def of(
        column: str, was: str, now: str, *, is_small: bool = False, replica: str = "", robot: str = ""
    ) -> Difference:
        time = math.inf if tick is None else tick * dt
        return Difference(
            file=name,
            line=0,
            time=time,
            tick=tick,
            replica=replica,
            robot=robot,
            column=column,
            old=was,
            new=now,
            is_small=is_small,
        )

    if not old.exists() or not new.exists():
        return of("the file", *(("there", "not there") if old.exists() else ("not there", "there")))
    try:
        if filecmp.cmp(old, new, shallow=False):
            return None
        made, kept = sizes_of(new), sizes_of(old)
        if made != kept:  # and a file that unfolds to more than there can be is not read
            return of("the file", f"of {_short(', '.join(kept))}", f"of {_short(', '.join(made))}")
        return _first_number(read_arrays(old), read_arrays(new), of)
    except (OSError, RunError) as error:
        return of("the file", f"damaged ({error})", "not")


def _first_number(
    was: Mapping[str, AnyArray], now: Mapping[str, AnyArray], of: Callable[..., Difference]
) -> Difference | None:
    """The first number that differs, and whether all that do are close; of arrays of the same names."""
    first: Difference | None = None
    for key, new in now.items():
        old = was[key]
        if old.shape != new.shape or old.dtype != new.dtype:
            return of(key, f"{old.dtype}{list(old.shape)}", f"{new.dtype}{list(new.shape)}")
        unequal = old != new
        if new.dtype.kind == "f":
            unequal &= ~(np.isnan(old) & np.isnan(new))
        if not unequal.any():
            continue
        place = tuple(int(i[0]) for i in np.nonzero(unequal))
        is_small = all(_is_close(str(a), str(b)) for a, b in zip(old[unequal], new[unequal], strict=True))
        here = of(
            key + "".join(f"_{i}" for i in place[1:]),
            str(old[place]),
            str(new[place]),
            is_small=is_small,
            replica=str(now["replica"][place[0]]) if "replica" in now else "",
            robot=str(now["robot"][place[0]]) if "robot" in now else "",
        )
        first = first or here
        if not is_small:
            return attrs.evolve(first, is_small=False)
    return first


def _rank(name: str) -> int:
    order = ("commands.csv", "events.csv", "sensors/", "poses.csv", "velocities.csv", "estimates/", "beliefs/")
    return next(i for i, start in enumerate((*order, "")) if name.startswith(start))


def _difference(old: Path, new: Path, name: str, dt: float) -> Difference | None:
    if not old.exists() or not new.exists():
        there = ("there", "not there") if old.exists() else ("not there", "there")
        return _whole_file(name, *there)
    for path in (old, new):
        check_file(path)
    try:
        if filecmp.cmp(old, new, shallow=False):
            return None
        with _opened(old) as one, _opened(new) as other:
            return _compare(one, other, name, dt)
    except OSError as error:
        raise RunError(f"{old}: cannot be read ({error.strerror or error})") from None


def _opened(path: Path) -> TextIO:
    # Bytes that are not text are a difference like any other, and shown as such.
    return path.open(encoding="utf-8", errors="backslashreplace", newline="\n")


def _lines(file: TextIO) -> Iterator[str]:
    """The lines of a file; one too long for a run's file comes in parts."""
    return iter(lambda: file.readline(LONGEST_LINE), "")


def _whole_file(name: str, was: str, now: str, line: int = 1) -> Difference:
    return Difference(
        file=name,
        line=line,
        time=float("inf"),
        tick=None,
        replica="",
        robot="",
        column="the file",
        old=was,
        new=now,
        is_small=False,
    )


def _compare(old: TextIO, new: TextIO, name: str, dt: float) -> Difference | None:
    header: list[str] = []
    first: Difference | None = None
    lines = itertools.zip_longest(_lines(old), _lines(new), fillvalue="")
    for number, (was, now) in enumerate(lines, start=1):
        if number == 1:
            header = was.rstrip("\n").split(",")
            if was != now:
                return _whole_file(name, f"headed {_short(was)!r}", f"headed {_short(now)!r}")
        elif was != now:
            here = _line_difference(header, was, now, name, number, dt)
            first = first or here
            if not here.is_small:
                return attrs.evolve(first, is_small=False)
    return first


def _line_difference(header: list[str], was: str, now: str, name: str, number: int, dt: float) -> Difference:
    before, after = _cells(was), _cells(now)
    fields = dict(zip(header, before if was else after, strict=False))
    time = _number(fields.get("time", ""))
    if time is not None and not math.isfinite(time / dt):
        time = None
    column, old, new, is_small = "the line", _short(was) or "not there", _short(now) or "not there", False
    if len(before) == len(after) == len(header):
        unequal = [i for i in range(len(header)) if before[i] != after[i]]
        is_small = all(_is_close(before[i], after[i]) for i in unequal)
        if unequal:
            column, old, new = header[unequal[0]], _short(before[unequal[0]]), _short(after[unequal[0]])
    return Difference(
        file=name,
        line=number,
        time=float("inf") if time is None else time,
        tick=None if time is None else round(time / dt),
        replica=fields.get("replica", ""),
        robot=fields.get("robot", ""),
        column=column,
        old=old,
        new=new,
        is_small=is_small,
    )


def _cells(line: str) -> list[str]:
    try:
        return next(csv.reader([line.rstrip("\n")]), [])
    except csv.Error:  # no line of a run
        return []


def _short(text: str) -> str:
    text = text.strip()
    return text if len(text) <= 200 else f"{text[:197]}..."


def _number(cell: str) -> float | None:
    try:
        return float(cell)
    except ValueError:
        return None


def _is_close(one: str, other: str) -> bool:
    a, b = _number(one), _number(other)
    if a is None or b is None:
        return False
    return a == b or abs(a - b) <= TOLERANCE * max(1.0, abs(a), abs(b))
