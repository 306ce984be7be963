"""D* Lite: a shortest path that is kept up while the map changes and the robot moves."""

from __future__ import annotations

import math
from collections.abc import Sequence

import attrs
import numpy as np

from amorsim.algorithms.cells import Cells, place_of
from amorsim.contracts import Plan
from amorsim.core.errors import PlanError
from amorsim.core.maps.map import Map
from amorsim.core.shapes import Shape
from amorsim.kernels.search.octile import FOUND, GOING_ON, octile_distance
from amorsim.kernels.search.replan import Replan, follow, new_replan, repair, update_around
from amorsim.planners.grid_planner import Found, GridPlanner, octile_length
from amorsim.planners.on_cells import Place

__all__ = ["DStarLite", "Replanner"]

_AT_A_TIME = 5_000


@attrs.frozen(kw_only=True)
class DStarLite(GridPlanner):
    """The shortest path over the eight neighbours of cells, kept up while the map changes, by D* Lite.

    A single `plan` finds what `AStar` finds, in more time. `replanner` keeps the search: after a change it expands only
    what the change concerns.
    """

    def search(self, cells: Cells, start: int, goal: int) -> Found:
        """Search for a path between two free cells."""
        return _repaired(new_replan(cells.free, cells.width, start, goal), cells, start, goal, self.budget)

    def replanner(self, goal: Sequence[float], *, footprint: Shape | None = None) -> Replanner:
        """A planner to one goal again and again; raises `PlanError` if that is not two or three finite numbers."""
        return Replanner(self, place_of(goal, "goal"), footprint)


class Replanner:
    """Plans to one goal on a map that changes, for a robot that moves; made by `DStarLite.replanner`."""

    def __init__(self, planner: DStarLite, goal: Place, footprint: Shape | None) -> None:
        self._planner = planner
        self._goal = goal
        self._footprint = footprint
        self._search: Replan | None = None
        self._width = 0
        self._start = 0

    def plan(self, world: Map, start: Sequence[float]) -> Plan:
        """The result of `DStarLite.plan` for this map and start, as quickly as the changes since the last call allow.

        `Plan.expanded` and `Plan.searched` are of this call alone. A cell may be expanded more than once.

        Raises
        ------
        PlanError
            As `Planner.plan`, or if the map has another place, size or cells than the first one.
        """
        cells = self._planner.cells_of(world, self._footprint)
        return self._planner.plan_on(cells, place_of(start, "start"), self._goal, self._replan)

    def _replan(self, cells: Cells, start: int, goal: int) -> Found:
        search = self._search
        if search is None:
            search = self._search = new_replan(cells.free, cells.width, start, goal)
            self._width = cells.width
        elif len(cells.free) != len(search.free) or cells.width != self._width:
            raise PlanError(
                f"the map has {cells.rows} x {cells.cols} cells; expected as many as in the first call, "
                f"{len(search.free) // self._width - 2} x {self._width - 2}; make another replanner"
            )
        else:
            search.moved[0] += octile_distance(self._width, self._start, start)
            changed = np.flatnonzero(search.free != cells.free)
            search.free[changed] = cells.free[changed]
            for cell in changed.tolist():
                update_around(search, self._width, start, goal, cell)
        self._start = start
        return _repaired(search, cells, start, goal, self._planner.budget)


def _repaired(search: Replan, cells: Cells, start: int, goal: int, budget: int) -> Found:
    pieces = []
    status = GOING_ON
    left = budget
    while status == GOING_ON:  # some cells at a time, so that Ctrl-C is noticed
        order = np.empty(min(left, _AT_A_TIME), np.int32)
        status = repair(search, cells.width, start, goal, order)
        pieces.append(order[: search.used[1]])
        left -= int(search.used[1])
        if left == 0:
            break
    searched = np.concatenate(pieces)
    if status != FOUND:
        return Found("budget" if status == GOING_ON else "unreachable", np.empty(0, np.int32), math.inf, searched)
    path = np.empty(int(search.cost[start]) + 2, np.int32)
    path = path[: follow(search, cells.width, start, goal, path)]
    assert path[-1] == goal
    return Found("found", path, octile_length(path, cells.width), searched)
