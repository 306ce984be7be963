"""Forests: discs at random."""

from __future__ import annotations

import math

import attrs

from amorsim.core.errors import MapError
from amorsim.core.parameters import parameter
from amorsim.worlds.cells import CellWorld, Sheet
from amorsim.worlds.passable import open_parts, places_for
from amorsim.worlds.random_numbers import Numbers

__all__ = ["Forest"]

_TRIES = 50  # for each tree
_HOPE, _MANY = 1.5, 50  # how many more trunks than expected may still find a place: by a factor, and more
_LEAST = 0.5  # of the places where the robot fits, that must be connected


@attrs.frozen(kw_only=True)
class Forest(CellWorld):
    """A forest: round trunks at random places that do not overlap, in a fence, with a glade in the middle."""

    density: float = parameter(0.3, unit="1/m^2", ge=0, le=1000, help="trunks per area")
    least_radius: float = parameter(0.1, unit="m", gt=0, help="radius of the thinnest trunks")
    largest_radius: float = parameter(0.3, unit="m", gt=0, help="radius of the thickest trunks")

    def draw(self, sheet: Sheet, numbers: Numbers) -> None:
        """Draw the forest. Raises `MapError` if the trunks do not fit in, or part it."""
        if self.least_radius > self.largest_radius:
            raise MapError(
                f"least_radius is {self.least_radius:g} m, above largest_radius, {self.largest_radius:g} m; swap them"
            )
        rows, cols = sheet.cells.shape
        fence = self.in_cells(0.1)
        self.need_size(2 * fence + self.passage, 2 * fence + self.passage, "a forest with a glade")
        sheet.border(fence)
        count = math.floor(self.density * rows * cols * self.resolution**2 + 0.5)
        low, high = self.least_radius / self.resolution, self.largest_radius / self.resolution
        if count > _most_discs(rows, cols, low):
            raise MapError(
                f"density = {self.density:g} per m^2 is too high: {count} trunks with a radius of at least "
                f"{self.least_radius:g} m cannot lie side by side in it; take a lower density, or thinner trunks"
            )
        trunks: dict[tuple[int, int], list[tuple[float, float, float]]] = {}
        side = 2.0 * high + 1.0  # of the squares by which trunks near a place are found
        glade = self.passage / 2
        placed = before = 0
        for number in range(_TRIES * count):
            if placed == count:
                break
            if number % count == 0 and number:
                # Places get fewer: as many as in this round will hardly be found in any of those to come.
                if _HOPE * (placed - before) * (_TRIES - number // count) + _MANY < count - placed:
                    break
                before = placed
            row, col = numbers.uniform() * rows, numbers.uniform() * cols
            radius = low + numbers.uniform() * (high - low)
            square = (int(row / side), int(col / side))
            near = [
                each for r in (-1, 0, 1) for c in (-1, 0, 1) for each in trunks.get((square[0] + r, square[1] + c), ())
            ]
            near.append((rows / 2, cols / 2, glade))
            if all((row - y) ** 2 + (col - x) ** 2 > (radius + r) ** 2 for y, x, r in near):
                trunks.setdefault(square, []).append((row, col, radius))
                sheet.disc(col, row, radius)
                placed += 1
        if placed < count:
            raise MapError(
                f"density = {self.density:g} per m^2 is too high: {placed} of {count} trunks found a place that no "
                "other has; take a lower density, or thinner trunks"
            )
        _, sizes = open_parts(places_for(sheet.cells, self.clearance, self.resolution))
        if sizes[1:].max(initial=0) < _LEAST * max(sizes[1:].sum(), 1):
            raise MapError(
                f"density = {self.density:g} per m^2 is too high for a robot with a clearance of {self.clearance:g} m: "
                "the trunks part the forest into pieces; take a lower density, thinner trunks, or a smaller clearance"
            )


def _most_discs(rows: int, cols: int, radius: float) -> float:
    """The largest number of discs without overlap whose middles are in a rectangle; all lengths in cells.

    Source: H. Groemer, "Über die Einlagerung von Kreisen in einen konvexen Bereich", Math. Z. 73 (1960).
    """
    apart = 2.0 * radius
    return 2.0 / math.sqrt(3.0) * rows * cols / apart**2 + (rows + cols) / apart + 1.0
