"""Shared by the built-in generators: a sheet of cells, and a world that the robot can drive everywhere in."""

from __future__ import annotations

import abc
import math

import attrs
import numpy as np
from numpy.typing import NDArray

from amorsim.contracts import WorldGenerator
from amorsim.core.draws import Draws
from amorsim.core.errors import MapError
from amorsim.core.maps.map import Map
from amorsim.core.parameters import parameter
from amorsim.worlds.passable import cells_of, nearest, without_pockets
from amorsim.worlds.random_numbers import Numbers

__all__ = ["CellWorld", "Sheet"]

_MOST_CELLS = 100_000_000


class Sheet:
    """Cells to draw on, row 0 lowest, and where the robot is to start, in cells."""

    def __init__(self, rows: int, cols: int, occupied: bool = False) -> None:
        self.cells: NDArray[np.uint8] = np.full((rows, cols), occupied, dtype=np.uint8)
        self.start: tuple[float, float] = (rows / 2, cols / 2)  # row, column
        self.heading = 0.0  # [rad]

    def fill(self, col0: int, row0: int, col1: int, row1: int, value: int = 1) -> None:
        """Set the cells of columns `col0` to `col1` - 1, rows `row0` to `row1` - 1, as far as they are on the sheet."""
        self.cells[max(row0, 0) : max(row1, 0), max(col0, 0) : max(col1, 0)] = value

    def border(self, thick: int) -> None:
        """Put a wall around everything."""
        rows, cols = self.cells.shape
        for box in (
            (0, 0, cols, thick),
            (0, rows - thick, cols, rows),
            (0, 0, thick, rows),
            (cols - thick, 0, cols, rows),
        ):
            self.fill(*box)

    def disc(self, col: float, row: float, radius: float, value: int = 1) -> None:
        """Set the cells whose middle is in a disc."""
        rows, cols = self.cells.shape
        r0, r1 = max(math.floor(row - radius), 0), min(math.ceil(row + radius) + 1, rows)
        c0, c1 = max(math.floor(col - radius), 0), min(math.ceil(col + radius) + 1, cols)
        across, up = np.arange(c0, c1) + 0.5 - col, np.arange(r0, r1) + 0.5 - row
        self.cells[r0:r1, c0:c1][(across**2)[None, :] + (up**2)[:, None] <= radius * radius] = value


@attrs.frozen(kw_only=True)
class CellWorld(WorldGenerator):
    """A world of cells that a robot of a given clearance can reach all of.

    What the robot cannot reach from the largest part is filled in, so nothing remains that only looks free.
    """

    size: tuple[float, float] = parameter((20.0, 15.0), unit="m", gt=0, le=10_000, help="width and height of the world")
    resolution: float = parameter(0.05, unit="m", ge=0.001, le=10, help="side of a cell")
    clearance: float = parameter(
        0.35, unit="m", gt=0, le=100, help="radius of a disc around the robot that gets everywhere"
    )

    @abc.abstractmethod
    def draw(self, sheet: Sheet, numbers: Numbers) -> None:
        """Draw the world on an empty sheet. Raises `MapError` if the parameters admit none."""

    def generate(self, draws: Draws) -> Map:
        """A world; see `WorldGenerator.generate`.

        Raises
        ------
        MapError
            If the parameters admit no world in which the robot gets about.
        """
        width, height = self.size
        if width / self.resolution * (height / self.resolution) > _MOST_CELLS:
            raise MapError(
                f"size ({width:g}, {height:g}) m has more than {_MOST_CELLS:g} cells of {self.resolution:g} m; take a "
                "smaller world, or a coarser resolution"
            )
        sheet = Sheet(self.in_cells(height), self.in_cells(width))
        self.draw(sheet, Numbers(draws))
        cells, places = without_pockets(sheet.cells, self.clearance, self.resolution)
        row, col = nearest(places, *sheet.start)
        return Map.from_array(
            cells,
            resolution=self.resolution,
            start=((col + 0.5) * self.resolution, (row + 0.5) * self.resolution, sheet.heading),
            name=type(self).__name__.lower(),
        )

    def in_cells(self, metres: float) -> int:
        """The number of cells that a length is, to the nearest, at least 1."""
        return cells_of(metres, self.resolution)

    @property
    def passage(self) -> int:
        """The narrowest gap [cells] that the robot passes wherever it lies."""
        return math.ceil(2.0 * self.clearance / self.resolution) + 2

    def need_passage(self, name: str, metres: float) -> int:
        """The cells of a parameter that is the width of a way. Raises `MapError` if the robot does not fit."""
        cells = self.in_cells(metres)
        if cells < self.passage:
            raise MapError(
                f"{name} is {metres:g} m, but a robot with a clearance of {self.clearance:g} m needs "
                f"{self.passage * self.resolution:.3g} m in cells of {self.resolution:g} m; take a larger {name}, or "
                "a smaller clearance"
            )
        return cells

    def need_size(self, width: int, height: int, what: str) -> None:
        """Raise `MapError` if the world has fewer cells than these in width or height."""
        if self.in_cells(self.size[0]) < width or self.in_cells(self.size[1]) < height:
            raise MapError(
                f"size is ({self.size[0]:g}, {self.size[1]:g}) m; {what} needs at least "
                f"({width * self.resolution:.3g}, {height * self.resolution:.3g}) m"
            )
