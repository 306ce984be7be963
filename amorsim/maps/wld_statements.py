"""The content of a line world: its statements, and the walls, size and start that they describe.

A statement a line, lengths in mm, angles in degrees; ``;`` and ``#`` begin a comment::

    width W                     size of the world, from its lower left corner
    height H
    origin X Y                  the lower left corner, where it is not (0, 0)
    position X Y TH             where the robot starts, in the current frame; TH anticlockwise
    push X Y TH                 enter a frame, placed in the current one; TH clockwise by default
    pop                         leave it
    X1 Y1 X2 Y2                 a wall, in the current frame
    X1 Y1 X2 Y2 T H             the same with a thickness and a height (EyeSim)
    X1 Y1 X2 Y2 T H C           the same with a colour, one number
    X1 Y1 X2 Y2 T H R G B       the same with a colour, three numbers
    floor W H                   size, where there is no width and height (EyeSim)
    floor_texture FILE          left out of the map
    WALL (ID) X Y TH LENGTH     a wall centred on X Y (Saphira's artifacts; TH anticlockwise)
    CORRIDOR (ID) X Y TH LENGTH WIDTH    the two walls of a corridor centred on X Y
    DOOR ..., JUNCTION ...      left out of the map: they block nothing
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from typing import NamedTuple

import attrs
import numpy as np

from amorsim.array_types import Array
from amorsim.core.errors import MapError, did_you_mean

__all__ = ["PUSH_SIGNS", "LineWorld", "WallLine", "begins_a_world", "direction", "parse_world"]

PUSH_SIGNS = {"clockwise": -1.0, "anticlockwise": 1.0}
# Farther out, a double no longer resolves a thousandth of a 1 mm cell.
_FARTHEST_MM = 1e12
# The numbers after the four coordinates of a wall, by their count.
_WALL_COUNTS = {4: "", 6: " T H", 7: " T H C", 9: " T H R G B"}
_LINE_END = re.compile(r"\r\n|\r|\n")
_COMMENT = re.compile(r"[;#].*", re.DOTALL)
_NUMBER = re.compile(r"[+-]?([0-9]+\.?[0-9]*|\.[0-9]+)([eE][+-]?[0-9]+)?")
_NOT_FINITE = re.compile(r"[+-]?(nan|inf|infinity)", re.IGNORECASE)

_Place = tuple[float, float, float]
"""Where a frame is in the world: x [mm], y [mm], heading [deg, anticlockwise]."""


class WallLine(NamedTuple):
    """Where a wall is written: the line, counted from 1, its frame, and whether it is four numbers and not a word's."""

    line: int
    frame: _Place
    is_plain: bool


@attrs.frozen(kw_only=True, eq=False)
class LineWorld:
    """The content of a line world, in SI units.

    `segments` are the walls, (M, 4) world metres ``x1 y1 x2 y2``; `extent` is the smallest
    ``(xmin, ymin, xmax, ymax)`` [m] that holds them and the size given; `start` is the robot's
    ``(x, y, heading)`` [m, m, rad] or None; `warnings` list the lines left out, and why. `lines` are where each
    wall is written, and `outside` is the last line after which no frame is open.
    """

    segments: Array
    extent: tuple[float, float, float, float]
    start: tuple[float, float, float] | None
    warnings: tuple[str, ...]
    lines: tuple[WallLine, ...]
    outside: int


def begins_a_world(text: str) -> bool:
    """Whether the first statement of a text is one of a line world."""
    for line in _LINE_END.split(text):
        words = _words(line)
        if words:
            is_wall = len(words) in _WALL_COUNTS and all(_NUMBER.fullmatch(word) for word in words)
            return is_wall or words[0].lower() in _STATEMENTS
    return False


def parse_world(text: str, *, push_sign: str = "clockwise") -> LineWorld:
    """The walls, extent and start that the text of a line world describes.

    Lines that are not statements are skipped with a warning. Frames may be open at the end.

    Parameters
    ----------
    text
        The file, with any of the three usual line ends.
    push_sign
        ``"clockwise"`` or ``"anticlockwise"``: which way the angle of a ``push`` counts. Worlds drawn for
        Saphira and EyeSim fit together only clockwise.

    Raises
    ------
    MapError
        If a number is not finite or out of all bounds, or if there is neither a wall nor a size.
    """
    if push_sign not in PUSH_SIGNS:
        expected = " or ".join(repr(sign) for sign in PUSH_SIGNS)
        hint = did_you_mean(push_sign, PUSH_SIGNS)
        raise MapError(f"push_sign: expected {expected}, got {push_sign!r}.{hint}")
    reader = _Reader(PUSH_SIGNS[push_sign])
    for number, line in enumerate(_LINE_END.split(text), start=1):
        reader.read(number, line)
    return reader.finish()


class _LineError(Exception):
    """Why a line is left out."""


class _Reader:
    """The content read so far; one method per statement."""

    def __init__(self, push_sign: float) -> None:
        self._push_sign = push_sign
        self._line = 0
        self._frame: _Place = (0.0, 0.0, 0.0)
        self._outer: list[_Place] = []
        self._walls: list[tuple[float, float, float, float]] = []
        self._sizes: dict[str, float] = {}
        self._floor: tuple[float, float] | None = None
        self._origin: tuple[float, float] | None = None
        self._start: _Place | None = None
        self._warnings: list[str] = []
        self._lines: list[WallLine] = []
        self._outside = 0

    def read(self, number: int, line: str) -> None:
        """Take in one line."""
        self._line = number
        words = _words(line)
        if not words:
            self._outside = self._outside if self._outer else number
            return
        try:
            word = words[0].lower()
            if word in _STATEMENTS:
                _STATEMENTS[word](self, words[1:])
            elif _is_numeric(word):
                self._read_wall(words)
            else:
                raise _LineError(f"{words[0]!r} is not a statement.{did_you_mean(word, _STATEMENTS)}")
        except _LineError as complaint:
            self._warn(f"left out {' '.join(words)!r}: {complaint}")
        if not self._outer:
            self._outside = number

    def finish(self) -> LineWorld:
        """The world read so far, in metres."""
        segments = np.array(self._walls, np.float64).reshape(-1, 4) / 1000
        # Nested pushes can exceed the bounds, even if each single number keeps them.
        if np.any(np.abs(segments) > _FARTHEST_MM / 1000):
            raise MapError(f"a wall ends farther out than {_FARTHEST_MM / 1e6:g} km")
        extent = self._extent(segments)
        start = None
        if self._start is not None:
            x, y, degrees = self._start
            start = (x / 1000, y / 1000, math.radians(180 - (180 - degrees) % 360))
            if not (extent[0] <= start[0] <= extent[2] and extent[1] <= start[1] <= extent[3]):
                self._warnings.append(f"the position ({start[0]:g} m, {start[1]:g} m) is outside the world")
        return LineWorld(
            segments=segments,
            extent=extent,
            start=start,
            warnings=tuple(self._warnings),
            lines=tuple(self._lines),
            outside=self._outside,
        )

    def _extent(self, segments: Array) -> tuple[float, float, float, float]:
        xs, ys = segments[:, 0::2].ravel(), segments[:, 1::2].ravel()
        left, bottom = self._origin or (0.0, 0.0)
        floor_width, floor_height = self._floor or (None, None)
        spans = []
        for values, low, size in (
            (xs, left, self._sizes.get("width", floor_width)),
            (ys, bottom, self._sizes.get("height", floor_height)),
        ):
            ends = values if size is None else np.append(values, (low / 1000, (low + size) / 1000))
            if ends.size == 0:
                raise MapError("it has no wall, and no width and height either" + self._first_warning())
            spans.append((float(ends.min()), float(ends.max())))
        (xmin, xmax), (ymin, ymax) = spans
        return xmin, ymin, xmax, ymax

    def _first_warning(self) -> str:
        if not self._warnings:
            return ""
        count = len(self._warnings)
        return f" ({count} line{'s' if count > 1 else ''} could not be read; {self._warnings[0]})"

    def _warn(self, problem: str) -> None:
        self._warnings.append(f"line {self._line}: {problem}")

    def _numbers(self, words: list[str], names: str) -> list[float]:
        """One finite number for each name; raises an error otherwise."""
        values = []
        for word in words:
            if not _is_numeric(word):
                raise _LineError(f"{word!r} is not a number")
            value = float(word)
            if not abs(value) <= _FARTHEST_MM:
                raise MapError(
                    f"line {self._line}: {word!r} in {' '.join(words)!r} is not a finite number of at most "
                    f"{_FARTHEST_MM:g}"
                )
            values.append(value)
        if len(values) != len(names.split()):
            raise _LineError(f"expected {names}, got {len(values)} number{'' if len(values) == 1 else 's'}")
        return values

    def _placed(self, x: float, y: float, frame: _Place | None = None) -> tuple[float, float]:
        """World position [mm] of a point of a frame (the current one if none is given)."""
        left, bottom, degrees = self._frame if frame is None else frame
        cosine, sine = direction(degrees)
        return left + x * cosine - y * sine, bottom + x * sine + y * cosine

    def _add_wall(self, x1: float, y1: float, x2: float, y2: float, frame: _Place | None = None) -> None:
        self._walls.append((*self._placed(x1, y1, frame), *self._placed(x2, y2, frame)))
        self._lines.append(WallLine(self._line, self._frame, frame is None))

    def _read_wall(self, words: list[str]) -> None:
        if len(words) not in _WALL_COUNTS and all(map(_is_numeric, words)):
            raise _LineError(f"a wall has 4, 6, 7 or 9 numbers, not {len(words)}")
        names = "X1 Y1 X2 Y2" + _WALL_COUNTS.get(len(words), "")
        x1, y1, x2, y2 = self._numbers(words, names)[:4]
        self._add_wall(x1, y1, x2, y2)

    def _read_width(self, words: list[str]) -> None:
        self._read_size("width", words)

    def _read_height(self, words: list[str]) -> None:
        self._read_size("height", words)

    def _read_size(self, which: str, words: list[str]) -> None:
        (size,) = self._numbers(words, which.upper())
        if size <= 0:
            raise _LineError(f"a {which} is more than 0")
        if which in self._sizes:
            self._warn(f"a second {which}, {size:g}, replaces {self._sizes[which]:g}")
        self._sizes[which] = size

    def _read_origin(self, words: list[str]) -> None:
        x, y = self._numbers(words, "X Y")
        if self._origin is not None:
            self._warn("a second origin replaces the first")
        self._origin = x, y

    def _read_position(self, words: list[str]) -> None:
        x, y, degrees = self._numbers(words, "X Y TH")
        if self._start is not None:
            self._warn("a second position replaces the first")
        self._start = (*self._placed(x, y), self._frame[2] + degrees)

    def _read_push(self, words: list[str]) -> None:
        x, y, degrees = self._numbers(words, "X Y TH")
        self._outer.append(self._frame)
        self._frame = (*self._placed(x, y), self._frame[2] + self._push_sign * degrees)

    def _read_pop(self, words: list[str]) -> None:
        if not self._outer:
            raise _LineError("there is no push to undo")
        self._frame = self._outer.pop()
        if words:
            self._warn(f"nothing follows a pop; left out {' '.join(words)!r}")

    def _read_floor(self, words: list[str]) -> None:
        width, height = self._numbers(words, "W H")
        if width <= 0 or height <= 0:
            raise _LineError("a floor's sides are more than 0")
        self._floor = width, height

    def _read_artifact_wall(self, words: list[str]) -> None:
        x, y, degrees, length = self._numbers(_without_id(words, 4), "X Y TH LENGTH")
        frame = (*self._placed(x, y), self._frame[2] + degrees)
        self._add_wall(-length / 2, 0.0, length / 2, 0.0, frame)

    def _read_corridor(self, words: list[str]) -> None:
        x, y, degrees, length, width = self._numbers(_without_id(words, 5), "X Y TH LENGTH WIDTH")
        frame = (*self._placed(x, y), self._frame[2] + degrees)
        for side in (-width / 2, width / 2):
            self._add_wall(-length / 2, side, length / 2, side, frame)

    def _pass_over(self, words: list[str]) -> None:
        """Do nothing: the statement is not about anything that blocks a robot."""


_STATEMENTS: dict[str, Callable[[_Reader, list[str]], None]] = {
    "corridor": _Reader._read_corridor,
    "door": _Reader._pass_over,
    "floor": _Reader._read_floor,
    "floor_texture": _Reader._pass_over,
    "height": _Reader._read_height,
    "junction": _Reader._pass_over,
    "origin": _Reader._read_origin,
    "pop": _Reader._read_pop,
    "position": _Reader._read_position,
    "push": _Reader._read_push,
    "wall": _Reader._read_artifact_wall,
    "width": _Reader._read_width,
}


def _words(line: str) -> list[str]:
    return _COMMENT.sub("", line).split()


def _is_numeric(word: str) -> bool:
    """Whether a word is meant as a number, finite or not."""
    return bool(_NUMBER.fullmatch(word) or _NOT_FINITE.fullmatch(word))


def _without_id(words: list[str], count: int) -> list[str]:
    """The words after an artifact's name; the name is in brackets or is the one extra word."""
    named = bool(words) and (words[0].startswith("(") or len(words) == count + 1)
    return words[1:] if named else words


def direction(degrees: float) -> tuple[float, float]:
    """Cosine and sine, exact at right angles: a wall turned by 90° stays on its line of cells."""
    turn = degrees % 360
    if turn % 90 == 0:
        return ((1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0))[int(turn // 90) % 4]
    return math.cos(math.radians(turn)), math.sin(math.radians(turn))
