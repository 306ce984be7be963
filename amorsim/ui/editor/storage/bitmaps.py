"""Bitmap worlds as they are painted: a picture as lines of runs, so that a stroke is a small change of a text.

The first line has the number of rows and of columns; then each row of the picture, the topmost first, is a line of runs
``LENGTHxGREY``. The picture's own file is written when it is saved.
"""

from __future__ import annotations

import io
from collections import deque
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt
from PIL import Image, UnidentifiedImageError

from amorsim.array_types import Bools
from amorsim.core.errors import AmorsimError
from amorsim.core.numbers import is_number
from amorsim.ui.editor.inspectors.walls import WallsError

__all__ = ["CODEC", "SUFFIXES", "cropped", "decode", "encode", "filled", "painted", "pixels_apart", "shape_of"]

CODEC = "bitmap"  # in place of the encoding of a text
SUFFIXES = (".png", ".bmp", ".pgm")
MOST_PIXELS = 25_000_000
MOST_RUNS = 2_000_000
MOST_SPANS = 200_000
_SAVED_AS = {".png": "PNG", ".bmp": "BMP", ".pgm": "PPM"}

Row = npt.NDArray[np.uint8]


def decode(data: bytes, name: str, *, has_threshold: bool) -> str:
    """The runs of a picture.

    Raises
    ------
    WallsError
        If it is none that can be painted on: it has colours, more greys than two without a threshold, or is too large.
    """
    try:
        with Image.open(io.BytesIO(data)) as image:
            if image.width * image.height > MOST_PIXELS:
                raise WallsError(f"{name}: has more than {MOST_PIXELS} pixels, too many to paint on")
            if image.mode not in ("1", "L", "P") or "transparency" in image.info:
                raise WallsError(f"{name}: has colours or transparent parts; save the world as another file to paint")
            levels = np.asarray(image.convert("L"))
    except (UnidentifiedImageError, OSError, ValueError, Image.DecompressionBombError) as error:
        raise WallsError(f"{name}: cannot be read: {error}") from None
    used = np.unique(levels)
    if len(used) > 2 and not has_threshold:
        raise WallsError(f"{name}: has greys; give a threshold to paint on it")
    if int(np.count_nonzero(np.diff(levels.astype(np.int16), axis=1))) > MOST_RUNS:
        raise WallsError(f"{name}: has too much detail to paint on")
    rows, columns = levels.shape
    return "\n".join([f"{rows} {columns}", *(_line(row) for row in levels)]) + "\n"


def encode(text: str, suffix: str) -> bytes:
    """The picture of runs, as a file."""
    rows, columns = shape_of(text)
    levels = np.empty((rows, columns), dtype=np.uint8)
    for number, line in enumerate(text.splitlines()[1:]):
        levels[number] = _row(line)
    image = Image.fromarray(levels)
    has_two = bool(((levels == 0) | (levels == 255)).all())
    data = io.BytesIO()
    (image.convert("1") if has_two and suffix != ".pgm" else image).save(data, format=_SAVED_AS[suffix])
    return data.getvalue()


def shape_of(text: str) -> tuple[int, int]:
    """The number of rows and of columns."""
    rows, columns = text[: text.index("\n")].split()
    return int(rows), int(columns)


def pixels_apart(old: str, new: str) -> list[str]:
    """How two pictures differ, in words; empty if they are the same."""
    before, after = shape_of(old), shape_of(new)
    if before != after:
        return [f"{sign}{rows} rows, {columns} columns" for sign, (rows, columns) in (("-", before), ("+", after))]
    count, at_rows, at_columns = 0, [], []
    for number, (one, other) in enumerate(zip(old.splitlines()[1:], new.splitlines()[1:], strict=True), start=1):
        if one != other:
            places = np.flatnonzero(_row(one) != _row(other)) + 1
            count += len(places)
            at_rows.append(number)
            at_columns += [int(places[0]), int(places[-1])]
    if not count:
        return []
    rows, columns = f"rows {at_rows[0]} to {at_rows[-1]}", f"columns {min(at_columns)} to {max(at_columns)}"
    return [f"{count} pixels differ, in {rows} and {columns}, from the upper left"]


def painted(text: str, spans: Any, *, is_occupied: bool) -> str:
    """The runs with other pixels: spans ``[row, first column, last column + 1]``; parts outside are left out.

    Raises
    ------
    AmorsimError
        If these are not spans.
    """
    if not isinstance(spans, list) or len(spans) > MOST_SPANS:
        raise AmorsimError(f"spans: expected a list of at most {MOST_SPANS}")
    rows, columns = shape_of(text)
    by_row: dict[int, list[tuple[int, int]]] = {}
    for span in spans:
        if not isinstance(span, list) or len(span) != 3 or not all(is_number(part, below=1e9) for part in span):
            raise AmorsimError("spans: expected [row, first column, one after the last]")
        row, first, end = (int(part) for part in span)
        if 0 <= row < rows:
            by_row.setdefault(row, []).append((max(0, first), min(columns, end)))
    lines = text.split("\n")
    grey = 0 if is_occupied else 255
    for number, parts in by_row.items():
        levels = _row(lines[number + 1])
        for first, end in parts:
            levels[first : max(first, end)] = grey
        lines[number + 1] = _line(levels)
    return "\n".join(lines)


def filled(text: str, row: int, column: int, *, is_occupied: bool) -> str:
    """The runs with the area of one grey around a pixel filled; it spreads over edges, not over corners.

    Raises
    ------
    AmorsimError
        If there is no such pixel.
    """
    rows, columns = shape_of(text)
    if not (0 <= row < rows and 0 <= column < columns):
        raise AmorsimError("there is no cell there")
    lines = text.split("\n")
    levels = np.array([_row(line) for line in lines[1 : rows + 1]])
    same = levels == levels[row, column]
    area = _area(same, row, column)
    levels[area] = 0 if is_occupied else 255
    for number in np.flatnonzero(area.any(axis=1)).tolist():
        lines[number + 1] = _line(levels[number])
    return "\n".join(lines)


def _area(same: Bools, row: int, column: int) -> Bools:
    """The pixels that are joined to one over edges, span by span."""
    rows, columns = same.shape
    found = np.zeros_like(same)
    waiting = deque([(row, column)])
    while waiting:
        r, c = waiting.pop()
        if found[r, c]:
            continue
        line = same[r]
        before = np.flatnonzero(~line[:c])
        after = np.flatnonzero(~line[c:])
        first = int(before[-1]) + 1 if before.size else 0
        end = c + int(after[0]) if after.size else columns
        found[r, first:end] = True
        for other in (r - 1, r + 1):
            if 0 <= other < rows:
                free = same[other, first:end] & ~found[other, first:end]
                starts = np.flatnonzero(free & ~np.concatenate(([False], free[:-1])))
                waiting.extend((other, first + int(start)) for start in starts)
    return found


def cropped(text: str, top: int, left: int, end: int, right: int) -> str:
    """The runs of a part: rows from `top` to before `end`, columns from `left` to before `right`.

    Raises
    ------
    AmorsimError
        If nothing would be left.
    """
    rows, columns = shape_of(text)
    top, left, end, right = max(0, top), max(0, left), min(rows, end), min(columns, right)
    if end <= top or right <= left:
        raise AmorsimError("nothing of the world lies in this box")
    lines = text.split("\n")[1 + top : 1 + end]
    return "\n".join([f"{end - top} {right - left}", *(_line(_row(line)[left:right]) for line in lines)]) + "\n"


def _line(levels: Row | Sequence[int]) -> str:
    values = np.asarray(levels)
    starts = np.concatenate(([0], np.flatnonzero(np.diff(values.astype(np.int16))) + 1))
    lengths = np.diff(np.concatenate((starts, [len(values)])))
    return " ".join(f"{length}x{grey}" for length, grey in zip(lengths.tolist(), values[starts].tolist(), strict=True))


def _row(line: str) -> Row:
    runs: Iterable[list[str]] = [run.split("x") for run in line.split(" ")]
    lengths, greys = zip(*runs, strict=True)
    return np.repeat(np.array(greys, dtype=np.uint8), np.array(lengths, dtype=np.int64))
