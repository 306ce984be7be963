"""Caves, made by a cellular automaton."""

from __future__ import annotations

import attrs
import numpy as np

from amorsim.array_types import Bools, Ints
from amorsim.core.errors import MapError
from amorsim.core.parameters import parameter
from amorsim.worlds.cells import CellWorld, Sheet
from amorsim.worlds.passable import open_parts, places_for
from amorsim.worlds.random_numbers import Numbers

__all__ = ["Cave", "neighbours"]

_LEAST = 0.1  # of the area; less is not a cave but a hole
_TRIES = 20
_BORDER = 0.1  # [m]


@attrs.frozen(kw_only=True)
class Cave(CellWorld):
    """A cave: random rock, smoothed by a cellular automaton in which a cell becomes like most cells around it.

    Where hardly anything of it is connected, it is drawn again.
    """

    fill: float = parameter(0.45, ge=0, le=1, help="share of rock at first; from about 0.5 on little is left of a cave")
    grain: float = parameter(0.4, unit="m", gt=0, help="side of the automaton's cells")
    rounds: int = parameter(4, ge=0, le=100, help="how often it smoothes")

    def draw(self, sheet: Sheet, numbers: Numbers) -> None:
        """Draw the cave. Raises `MapError` if hardly anything of it is connected."""
        has_width = 2.0 * self.clearance < min(self.size)  # else it takes long to find that there is no place
        for _ in range(_TRIES if has_width else 0):
            if self._has_room(sheet, numbers):
                return
        least = 2 * self.in_cells(_BORDER) + self.passage
        self.need_size(least, least, f"a cave for a robot with a clearance of {self.clearance:g} m")
        raise MapError(
            f"fill = {self.fill:g} leaves less than {_LEAST:.0%} of the area where a robot with a clearance of "
            f"{self.clearance:g} m gets about; take less fill, a smaller clearance, or a coarser grain"
        )

    def _has_room(self, sheet: Sheet, numbers: Numbers) -> bool:
        """Draw a cave; whether the largest part of it that is connected is large enough."""
        rows, cols = sheet.cells.shape
        grain = self.in_cells(self.grain)
        rock = numbers.many(-(-rows // grain), -(-cols // grain)) < self.fill
        for _ in range(self.rounds):
            around = neighbours(rock, outside=1)
            rock = np.where(around == 4, rock, around > 4)
        sheet.cells[:] = _rounded(np.repeat(np.repeat(rock, grain, axis=0), grain, axis=1)[:rows, :cols], grain)
        sheet.border(self.in_cells(_BORDER))
        _, sizes = open_parts(places_for(sheet.cells, self.clearance, self.resolution))
        return bool(sizes[1:].max(initial=0) >= _LEAST * rows * cols)


def neighbours(cells: Bools, outside: int) -> Ints:
    """How many of the eight cells around each are set; those outside the array count as `outside`."""
    padded = np.pad(cells.astype(np.int64), 1, constant_values=outside)
    across = padded[:, :-2] + padded[:, 1:-1] + padded[:, 2:]
    found: Ints = across[:-2] + across[1:-1] + across[2:] - padded[1:-1, 1:-1]
    return found


def _rounded(rock: Bools, grain: int) -> Bools:
    """Rock where most is rock in a square of about the grain around each cell: this takes the corners off."""
    half = grain // 2
    side = 2 * half + 1
    sums = (
        np.pad(rock.astype(np.int64), ((half + 1, half), (half + 1, half)), mode="edge").cumsum(axis=0).cumsum(axis=1)
    )
    within = sums[side:, side:] - sums[:-side, side:] - sums[side:, :-side] + sums[:-side, :-side]
    smooth: Bools = 2 * within > side * side
    return smooth
