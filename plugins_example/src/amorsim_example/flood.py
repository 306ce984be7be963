"""A planner: breadth-first search over the cells of a map."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Sequence

import attrs
import numpy as np
import numpy.typing as npt

import amorsim as am

__all__ = ["Flood"]

Bools = npt.NDArray[np.bool_]
Cell = tuple[int, int]  # row, column


@attrs.frozen(kw_only=True)
class Flood(am.Planner):
    """A path with the fewest steps to the four neighbours of cells: searches all around the start, ring by ring.

    Parameters
    ----------
    budget
        Cells that it may expand.
    """

    budget: int = am.parameter(1_000_000, gt=0, help="cells that it may expand")

    def plan(
        self, world: am.Map, start: Sequence[float], goal: Sequence[float], *, footprint: am.Shape | None = None
    ) -> am.Plan:
        """The plan, from start to goal, with one corner in each cell."""
        first, last = _place(start, "start"), _place(goal, "goal")
        free = _free(world.to_array() > 0, 0.0 if footprint is None else footprint.reach / world.resolution)
        ends = []
        for name, place in (("start", first), ("goal", last)):
            x, y = _in_cells(place, world)
            rows, columns = free.shape
            if not (0.0 <= y < rows and 0.0 <= x < columns):
                return am.Plan(status=f"{name}_blocked", message=f"the {name} is outside the map")
            cell = int(y), int(x)
            if not free[cell]:
                return am.Plan(status=f"{name}_blocked", message=f"the {name} is too close to a wall")
            ends.append(cell)
        status, cells, searched = self._search(free, ends[0], ends[1])
        places = _centres(searched, world)
        if status != "found":
            why = "the budget is used up" if status == "budget" else "no free cells lead from start to goal"
            return am.Plan(status=status, message=why, expanded=len(searched), searched=places)
        # In the place of the first and the last centre, the start and the goal themselves.
        points = np.array([first[:2], *_centres(cells[1:-1], world), last[:2]])
        legs = np.diff(points, axis=0)
        headings = np.arctan2(legs[:, 1], legs[:, 0])
        end = last[2] if len(last) == 3 else headings[-1]
        length = float(np.hypot(legs[:, 0], legs[:, 1]).sum())
        return am.Plan(
            status="found",
            poses=np.column_stack((points, [*headings, end])),
            length=length,
            cost=length,
            expanded=len(searched),
            searched=places,
        )

    def _search(self, free: Bools, start: Cell, goal: Cell) -> tuple[str, list[Cell], list[Cell]]:
        """The status, the cells of the path, and those that were expanded, in order."""
        came_from: dict[Cell, Cell] = {start: start}
        waiting = deque([start])
        expanded: list[Cell] = []
        while waiting:
            cell = waiting.popleft()
            if cell == goal:
                return "found", _back(came_from, goal), expanded
            if len(expanded) == self.budget:
                return "budget", [], expanded
            expanded.append(cell)
            for row, column in ((0, 1), (1, 0), (0, -1), (-1, 0)):
                near = cell[0] + row, cell[1] + column
                inside = 0 <= near[0] < free.shape[0] and 0 <= near[1] < free.shape[1]
                if inside and free[near] and near not in came_from:
                    came_from[near] = cell
                    waiting.append(near)
        return "unreachable", [], expanded


def _place(given: Sequence[float], name: str) -> list[float]:
    """Two or three finite numbers, or a `PlanError`: never another exception, and never a plan."""
    try:
        numbers = [float(number) for number in given]
    except (TypeError, ValueError):
        numbers = []
    if len(numbers) not in (2, 3) or not all(map(math.isfinite, numbers)):
        raise am.PlanError(f"{name}: expected (x, y) or (x, y, heading), got {given!r}")
    return numbers


def _free(occupied: Bools, reach: float) -> Bools:
    """Cells of which every point is at least `reach` [cells] from occupied cells and from the map's edge."""
    margin = math.ceil(reach) + 1
    walls = np.pad(occupied, margin, constant_values=True)
    rows, columns = occupied.shape
    blocked = occupied.copy()
    for row in range(-margin, margin + 1):
        for column in range(-margin, margin + 1):
            if math.hypot(max(abs(row) - 1, 0), max(abs(column) - 1, 0)) < reach:
                y, x = margin + row, margin + column
                blocked |= walls[y : y + rows, x : x + columns]
    return ~blocked


def _back(came_from: dict[Cell, Cell], goal: Cell) -> list[Cell]:
    """The cells from the start to the goal; the start is its own predecessor."""
    cells = [goal]
    while came_from[cells[-1]] != cells[-1]:
        cells.append(came_from[cells[-1]])
    return cells[::-1]


def _in_cells(place: Sequence[float], world: am.Map) -> tuple[float, float]:
    """A place of the world from the map's lower left corner, along its columns and rows [cells]."""
    x0, y0, heading = world.origin
    x, y = (place[0] - x0) / world.resolution, (place[1] - y0) / world.resolution
    c, s = math.cos(heading), math.sin(heading)
    return c * x + s * y, c * y - s * x


def _centres(cells: Sequence[Cell], world: am.Map) -> npt.NDArray[np.float64]:
    """The middles of cells (M, 2) [m] in the world."""
    row, column = (np.array(cells, dtype=np.float64).reshape(-1, 2).T + 0.5) * world.resolution
    x0, y0, heading = world.origin
    c, s = math.cos(heading), math.sin(heading)
    return np.column_stack((x0 + c * column - s * row, y0 + s * column + c * row))
