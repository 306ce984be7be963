"""Fields of cylinders as those of the BARN challenge.

Source: D. Perille, A. Truong, X. Xiao, P. Stone, "Benchmarking metric ground navigation", SSRR 2020, and its generator,
https://github.com/dperille/jackal-map-creation. The rules are those of the publication; the numbers drawn are other
ones, so no world is one of the 300 published.
"""

from __future__ import annotations

import math

import attrs
import numpy as np

from amorsim.array_types import Bools
from amorsim.core.errors import MapError
from amorsim.core.parameters import parameter
from amorsim.worlds.caves import neighbours
from amorsim.worlds.cells import CellWorld, Sheet
from amorsim.worlds.passable import nearest, open_parts, places_for
from amorsim.worlds.random_numbers import Numbers

__all__ = ["Barn"]

_CELL = 0.15  # [m], the diameter of a cylinder


@attrs.frozen(kw_only=True)
class Barn(CellWorld):
    """A field of cylinders of the BARN challenge's kind, to be crossed from bottom to top.

    Cylinders stand on a grid of 0.15 m. A share of its places gets one at first. In each round, a place with more than
    four of eight neighbours gets a cylinder, and one with fewer than two loses it. The field lies between walls at its
    sides and free areas below and above. Where no way leads through, cylinders are taken out along one.
    """

    size: tuple[float, float] = parameter((4.5, 9.5), unit="m", gt=0, le=10_000, help="width and height of the world")
    resolution: float = parameter(0.025, unit="m", ge=0.001, le=0.075, help="side of a cell")
    clearance: float = parameter(
        0.25, unit="m", gt=0, le=100, help="radius of a disc around the robot that gets through"
    )
    fill: float = parameter(0.2, ge=0, le=1, help="share of cylinders at first; 0.15 to 0.3 in the publication")
    rounds: int = parameter(3, ge=0, le=100, help="of smoothing; 2 to 4 in the publication")
    approach: float = parameter(2.5, unit="m", gt=0, help="depth of the free areas below and above the field")

    def draw(self, sheet: Sheet, numbers: Numbers) -> None:
        """Draw the field. Raises `MapError` if there is no place for it."""
        approach = self.need_passage("approach", self.approach)
        rows, cols = sheet.cells.shape
        columns, deep = int(self.size[0] / _CELL), int((self.size[1] - 2.0 * self.approach) / _CELL)
        least = self.passage * self.resolution + 2 * _CELL  # between the walls
        if columns * _CELL < least or deep < 1:
            raise MapError(
                f"size is ({self.size[0]:g}, {self.size[1]:g}) m; a field needs a width of at least "
                f"{least:.3g} m, and a height of {2 * self.approach + _CELL:.3g} m with an "
                f"approach of {self.approach:g} m"
            )
        filled = numbers.many(deep, columns) < self.fill
        # The walls are at the sides: beyond them all counts as filled, beyond the ends as free.
        filled[:, [0, -1]] = True
        for _ in range(self.rounds):
            # A frame of filled places at the sides, of free ones at the ends.
            framed = np.pad(np.pad(filled, ((1, 1), (0, 0))), ((0, 0), (1, 1)), constant_values=True)
            around = neighbours(framed, outside=0)[1:-1, 1:-1]
            filled = (filled | (around > 4)) & ~(around < 2)
        sheet.start = (approach / 2, cols / 2)
        sheet.heading = math.pi / 2
        wall = self.in_cells(0.05)
        self._place(sheet, filled, approach, wall)
        parts, _ = open_parts(places_for(sheet.cells, self.clearance, self.resolution))
        places = (parts > 0).astype(np.uint8)
        below = nearest(places, *sheet.start) if places.any() else (0, 0)
        above = nearest(places, rows - approach / 2, cols / 2) if places.any() else (0, 0)
        if parts[below] == 0 or parts[below] != parts[above]:
            self._place(sheet, self._with_way(filled, numbers), approach, wall)

    def _place(self, sheet: Sheet, filled: Bools, approach: int, wall: int) -> None:
        sheet.cells[:] = 0
        side = _CELL / self.resolution
        for row, col in np.argwhere(filled).tolist():
            sheet.disc((col + 0.5) * side, approach + (row + 0.5) * side, side / 2)
        sheet.border(wall)

    def _with_way(self, filled: Bools, numbers: Numbers) -> Bools:
        """The field without the cylinders on a straight way through it, as wide as the robot needs."""
        columns = filled.shape[1]
        wide = min(math.ceil(self.passage * self.resolution / _CELL) + 1, columns)
        first = numbers.between(0, columns - wide)
        cleared = filled.copy()
        cleared[:, first : first + wide] = False
        return cleared
