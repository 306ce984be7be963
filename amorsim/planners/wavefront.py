"""Wavefront: the distance of every cell to a goal, and paths that descend it."""

from __future__ import annotations

import math
from collections.abc import Sequence

import attrs
import numpy as np

from amorsim.algorithms.cells import Cells, place_of
from amorsim.array_types import Array
from amorsim.core.errors import PlanError
from amorsim.core.maps.map import Map
from amorsim.core.shapes import Shape
from amorsim.kernels.search.field import Wave, descend, new_wave, spread
from amorsim.kernels.search.octile import GOING_ON
from amorsim.planners.grid_planner import Found, GridPlanner, octile_length

__all__ = ["Field", "Wavefront"]

_AT_A_TIME = 100_000


@attrs.frozen(kw_only=True, eq=False)
class Field:
    """The length of the shortest path to a goal from every cell of a map."""

    to_go: Array
    """(rows, cols) [m], row 0 lowest; inf where no path leads to the goal, and in cells that are not free."""
    side: float
    """Side of a cell [m]."""


@attrs.frozen(kw_only=True)
class Wavefront(GridPlanner):
    """The shortest path over the eight neighbours of cells, down the field of distances to the goal.

    It finds paths as short as those of `AStar`. One field serves any number of starts: see `field`.
    """

    def search(self, cells: Cells, start: int, goal: int) -> Found:
        """Search for a path between two free cells."""
        wave, is_whole = _spread(cells, goal, self.budget)
        searched = wave.order[: wave.used[4]]
        if not is_whole or wave.waits[start] < 0:
            return Found("unreachable" if is_whole else "budget", np.empty(0, np.int32), math.inf, searched)
        path = np.empty(int(wave.to_go[start]) + 2, np.int32)
        path = path[: descend(cells.free, wave.to_go, cells.width, start, path)]
        return Found("found", path, octile_length(path, cells.width), searched)

    def field(self, world: Map, goal: Sequence[float], *, footprint: Shape | None = None) -> Field:
        """The length of the shortest path to `goal` from every cell.

        Raises
        ------
        PlanError
            If the goal is not two or three finite numbers or is not in a free cell, or if the budget is used up.
        """
        x, y, _ = place_of(goal, "goal")
        cells = self.cells_of(world, footprint)
        place = cells.cell_at(x, y)
        if place is None or not cells.free[place]:
            raise PlanError(f"the goal ({x:g}, {y:g}) is not in a free cell, so no field leads to it")
        wave, is_whole = _spread(cells, place, self.budget)
        if not is_whole:
            raise PlanError(
                f"the budget of {self.budget} cells was used up before the field was whole; set a larger one"
            )
        to_go = wave.to_go.reshape(-1, cells.width)[1:-1, 1:-1] * cells.side
        return Field(to_go=to_go, side=cells.side)


def _spread(cells: Cells, goal: int, budget: int) -> tuple[Wave, bool]:
    """A wave from a goal, and whether it came to its end within the budget."""
    wave = new_wave(cells.free, goal)
    status = GOING_ON
    left = budget
    while status == GOING_ON and left > 0:  # some cells at a time, so that Ctrl-C is noticed
        most = min(left, _AT_A_TIME)
        status = spread(wave, cells.width, most)
        left -= most
    return wave, status != GOING_ON
