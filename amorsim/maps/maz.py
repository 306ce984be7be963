"""Mazes of EyeSim (``.maz``): walls between square cells, drawn with letters.

Columns are counted from 1: odd ones hold the walls between cells, even ones the cells::

     _ _ _
    |   | |
    | |_  |
    |S|___|
    360

``|`` is a wall, and so is ``_``, at the lower side of its cell. The first line holds the upper sides of the first row.
A letter is where the robot starts, facing up (U, or S for start), down (D), left (L) or right (R); a capital one has a
wall below it, as ``_``, and a small one has none. The last line is the side of a cell [mm], 360 if there is none.
"""

from __future__ import annotations

import math
import re
from pathlib import Path
from typing import ClassVar

import attrs

from amorsim.contracts import MapLoader
from amorsim.core.errors import MapError
from amorsim.core.files.reading import read_bytes, reason
from amorsim.core.maps.map import Map
from amorsim.core.parameters import parameter

__all__ = ["Maz"]

_MOST_BYTES = 5_000_000
_CELL = 360.0  # [mm]
_LARGEST = 1e6  # [mm]
_HEADINGS = {"s": 90.0, "u": 90.0, "d": 270.0, "l": 180.0, "r": 0.0}  # [deg]
_NUMBER = re.compile(r"[0-9]+(\.[0-9]+)?")
_LINE_END = re.compile(r"\r\n|\r|\n")

Wall = tuple[float, float, float, float]


@attrs.frozen(kw_only=True)
class Maz(MapLoader):
    """Mazes of EyeSim (``.maz``): thin walls between square cells; the lower left corner is at (0, 0)."""

    extensions: ClassVar[tuple[str, ...]] = (".maz",)

    resolution: float = parameter(0.001, unit="m", gt=0, help="side of a cell of the map, not of the maze")
    cell: float | None = parameter(None, unit="m", gt=0, help="side of a cell of the maze, in place of the file's")

    @classmethod
    def sniff(cls, head: bytes) -> bool:
        """Whether the first lines hold nothing but walls and the letters of a start."""
        lines = [line for line in head.decode("latin-1").splitlines()[:3] if line.strip()]
        return (
            len(lines) == 3
            and re.fullmatch(r"[ _|.+]*", lines[0]) is not None
            and all(re.fullmatch(r"[ _|.+sudlrSUDLR]*\|[ _|.+sudlrSUDLR]*", line) for line in lines[1:])
        )

    def load(self, path: Path) -> Map:
        """The map of a maze.

        Raises
        ------
        MapError
            If the file cannot be read, has no wall, a letter of no maze, or a wall where a cell is; with the line.
        """
        try:
            return self._load(path)
        except MapError as error:
            raise MapError(f"{path}: {error}") from error

    def _load(self, path: Path) -> Map:
        try:
            text = read_bytes(path, _MOST_BYTES).decode("utf-8-sig")
        except UnicodeDecodeError as error:
            raise MapError(f"byte {error.start} is not UTF-8: this is not a maze") from error
        except (OSError, ValueError) as error:
            raise MapError(f"cannot be read: {reason(error)}") from error
        lines = [line.rstrip() for line in _LINE_END.split(text.rstrip("\x1a").rstrip())]
        side = _CELL
        if lines and _NUMBER.fullmatch(lines[-1].strip()):
            side = float(lines.pop().strip())  # float() takes fewer characters for white space
            if not 0.0 < side <= _LARGEST:
                raise MapError(
                    f"line {len(lines) + 1}: a cell is {side:g} mm; expected above 0, and {_LARGEST:g} at most"
                )
        while lines and not lines[-1]:
            lines.pop()
        metres = side / 1000 if self.cell is None else self.cell
        walls: list[Wall] = []
        starts: list[tuple[float, float, float]] = []
        rows = len(lines) - 1
        for number, line in enumerate(lines, start=1):
            _read(line, number, rows + 1 - number, walls, starts)
        if not walls:
            raise MapError("it has no wall")
        remarks = [f"it has {len(starts)} starts; the robot is at the first"] if len(starts) > 1 else []
        start = None
        if starts:
            x, y, heading = starts[0]
            start = (x * metres, y * metres, heading)
        return Map.from_segments(
            [[end * metres for end in wall] for wall in _joined(walls)],
            resolution=self.resolution,
            extent=(0.0, 0.0, max(len(line) // 2 for line in lines) * metres, rows * metres),
            start=start,
            warnings=remarks,
            name=path.stem,
        )


def _read(line: str, number: int, below: int, walls: list[Wall], starts: list[tuple[float, float, float]]) -> None:
    """Read a line of cells whose lower sides are `below` cells up."""
    for place, letter in enumerate(line, start=1):
        # Columns 2 n + 1 are the walls left of cell n, columns 2 n + 2 the cell itself.
        column, is_cell = divmod(place - 1, 2)
        where = f"line {number}, column {place}"
        if letter in " .+" or (letter == "_" and not is_cell):
            continue  # in odd columns too, some mazes draw their lower sides through
        if letter == "|" and not is_cell and number > 1:
            walls.append((column, below, column, below + 1))
        elif letter == "_":
            walls.append((column, below, column + 1, below))
        elif letter.lower() in _HEADINGS and is_cell and number > 1:
            starts.append((column + 0.5, below + 0.5, math.radians((_HEADINGS[letter.lower()] + 180) % 360 - 180)))
            if letter.isupper():
                walls.append((column, below, column + 1, below))
        elif letter in "|_" or letter.lower() in _HEADINGS:
            raise MapError(f"{where}: {letter!r} cannot be here: '|' is in odd columns, '_' and a start in even ones")
        else:
            raise MapError(f"{where}: {letter!r} is none of a maze's: '|', '_', a blank, S, U, D, L or R")


def _joined(walls: list[Wall]) -> list[Wall]:
    """The walls, those that go on straight as one."""
    joined: list[Wall] = []
    flat = sorted({wall for wall in walls if wall[1] == wall[3]}, key=lambda wall: (wall[1], wall[0]))
    upright = sorted({wall for wall in walls if wall[0] == wall[2]})
    for x0, y0, x1, y1 in (*flat, *upright):
        if joined and joined[-1][2:] == (x0, y0) and (joined[-1][0] == x1 or joined[-1][1] == y1):
            joined[-1] = (*joined[-1][:2], x1, y1)
        else:
            joined.append((x0, y0, x1, y1))
    return joined
