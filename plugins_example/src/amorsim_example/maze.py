"""A map loader: a maze drawn with characters."""

from __future__ import annotations

import math
from pathlib import Path
from typing import ClassVar

import attrs
import numpy as np

import amorsim as am

__all__ = ["Maze"]

_HEADINGS = {">": 0.0, "^": math.pi / 2, "<": math.pi, "v": -math.pi / 2}
_KNOWN = f"'#', ' ', '.' or one of {' '.join(_HEADINGS)}"


@attrs.frozen(kw_only=True)
class Maze(am.MapLoader):
    """Reads a text in which every character is a square of the floor, and the first line is the far end.

    ``#`` is wall, a blank or ``.`` is free, and ``> ^ < v`` is where a robot starts, and which way it looks. Lines
    may be of different lengths; what they lack is free. The lower left corner is the world's origin.

    Parameters
    ----------
    resolution
        Side of a square [m].
    """

    extensions: ClassVar[tuple[str, ...]] = (".maze",)

    resolution: float = am.parameter(0.5, unit="m", gt=0, help="side of the square that a character stands for")

    def load(self, path: Path) -> am.Map:
        """The map in a file.

        Raises
        ------
        MapError
            If it cannot be read as text, has nothing in it, or has a character that means nothing or two starts;
            the line is named.
        """
        try:
            lines = path.read_text(encoding="utf-8").splitlines()
        except (OSError, UnicodeDecodeError) as error:
            raise am.MapError(f"{path}: cannot be read as text: {error}") from error
        width = max((len(line) for line in lines), default=0)
        if width == 0:
            raise am.MapError(f"{path}: the maze is empty; expected lines of {_KNOWN}")
        cells = np.zeros((len(lines), width), dtype=np.uint8)
        start = None
        for row, line in enumerate(reversed(lines)):
            for column, character in enumerate(line):
                where = f"{path}, line {len(lines) - row}, character {column + 1}"
                if character == "#":
                    cells[row, column] = 1
                elif character in _HEADINGS:
                    if start is not None:
                        raise am.MapError(f"{where}: a second start, {character!r}; expected one at the most")
                    start = (
                        (column + 0.5) * self.resolution,
                        (row + 0.5) * self.resolution,
                        _HEADINGS[character],
                    )
                elif character not in " .":
                    raise am.MapError(f"{where}: expected {_KNOWN}, got {character!r}")
        return am.Map.from_array(cells, resolution=self.resolution, start=start, name=path.name)
