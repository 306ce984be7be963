"""What all planners on cells have in common: their fields, their statuses, and how cells become a path."""

from __future__ import annotations

import abc
import math
from collections.abc import Callable, Sequence
from typing import ClassVar, NamedTuple

import attrs
import numpy as np
import numpy.typing as npt

from amorsim.algorithms.cells import Cells, free_cells, place_of
from amorsim.contracts import Plan, Planner
from amorsim.core.errors import PlanError
from amorsim.core.map import Map
from amorsim.core.parameters import parameter
from amorsim.core.shapes import Shape
from amorsim.kernels.search.any_angle import is_open_line
from amorsim.kernels.search.frontier import Search, new_search
from amorsim.kernels.search.octile import FOUND, GOING_ON, expand_octile

__all__ = ["Found", "GridPlanner", "Place", "found_by", "octile_length", "path_through", "run_octile", "run_search"]

Array = npt.NDArray[np.float64]
Numbers = npt.NDArray[np.int32]


Place = tuple[float, float, float | None]
"""x, y [m] and heading [rad] of a start or goal; None for a heading that is not given."""


class Found(NamedTuple):
    """What a search on cells found."""

    status: str
    """``"found"``, ``"unreachable"`` or ``"budget"``."""
    path: Numbers
    """The cells at the corners of the path, from start to goal; empty without one."""
    length: float
    """[cells] from the centre of the first to that of the last; inf without a path."""
    searched: Numbers
    """The cells expanded, in order."""


@attrs.frozen(kw_only=True)
class GridPlanner(Planner):
    """A planner on square cells. A cell is free if all of it keeps the footprint's reach from every occupied cell."""

    any_angle: ClassVar[bool] = False
    """Whether the lines of paths may have any direction."""

    cell: float | None = parameter(None, unit="m", gt=0, help="side of the cells; without it that of the map's")
    budget: int = parameter(100_000_000, ge=0, help="cells expanded at most")
    avoid_unknown: bool = parameter(False, help="whether unknown cells of the map count as occupied")

    @abc.abstractmethod
    def search(self, cells: Cells, start: int, goal: int) -> Found:
        """Search for a path between two free cells."""

    def cells_of(self, world: Map, footprint: Shape | None) -> Cells:
        """The cells of a map that a robot with this footprint may be in."""
        if not isinstance(footprint, Shape | None):
            raise PlanError(f"footprint is {footprint!r}; expected a Shape, such as am.Shape.circle(0.25), or None")
        reach = 0.0 if footprint is None else footprint.reach
        return free_cells(world, reach, side=self.cell, avoid_unknown=self.avoid_unknown)

    def plan(
        self, world: Map, start: Sequence[float], goal: Sequence[float], *, footprint: Shape | None = None
    ) -> Plan:
        """The plan for a robot with this footprint; see `amorsim.Planner.plan`.

        The path leads from the start to the centre of its cell, through centres of cells, and from the centre of the
        goal's cell to the goal; within one cell it is a straight line. `Plan.cost` is the length between the centres.
        """
        ends = place_of(start, "start"), place_of(goal, "goal")
        return self.plan_on(self.cells_of(world, footprint), *ends, self.search)

    def plan_on(self, cells: Cells, start: Place, goal: Place, search: Callable[[Cells, int, int], Found]) -> Plan:
        """The plan on these cells, by a search between two free ones."""
        ends = (start, goal)
        places = []
        for name, (x, y, _) in zip(("start", "goal"), ends, strict=True):
            place = cells.cell_at(x, y)
            if place is None:
                return Plan(status=f"{name}_blocked", message=f"the {name} ({x:g}, {y:g}) is outside the map")
            if not cells.free[place]:
                return Plan(status=f"{name}_blocked", message=_why_blocked(cells, name, x, y, place))
            places.append(place)
        found = search(cells, *places)
        searched = cells.places(found.searched)
        if found.status != "found":
            message = (
                f"the budget of {self.budget} cells was used up"
                if found.status == "budget"
                else _why_unreachable(cells, *places)
            )
            return Plan(status=found.status, expanded=len(searched), searched=searched, message=message)
        points, length = _from_end_to_end(cells, found, *ends)
        if self.any_angle:
            points, length = _without_needless_centres(cells, points, length)
        return Plan(
            status="found",
            poses=_poses(points, ends[1][2]),
            length=length,
            cost=found.length * cells.side,
            expanded=len(searched),
            searched=searched,
        )


def run_search(
    cells: Cells, start: int, budget: int, expand: Callable[[Search, int], int], at_a_time: int = 20_000
) -> tuple[str, Search]:
    """Run a search kernel, some cells at a time, so that Ctrl-C is noticed; ``expand(search, most)`` calls it.

    So many cells should take some milliseconds.
    """
    search = new_search(cells.free, start)
    status = GOING_ON
    left = budget
    while status == GOING_ON and left > 0:
        most = min(left, at_a_time)
        status = expand(search, most)
        left -= most
    return {GOING_ON: "budget", FOUND: "found"}.get(status, "unreachable"), search


def run_octile(cells: Cells, start: int, goal: int, budget: int, weight: float) -> tuple[str, Search]:
    """Search for a shortest path over eight neighbours, with `weight` times the octile distance to the goal."""
    return run_search(cells, start, budget, lambda search, most: expand_octile(search, cells.width, goal, weight, most))


def found_by(status: str, search: Search, start: int, goal: int, length: Callable[[Numbers], float]) -> Found:
    """What a search found, with the cells of its path by their parents, and the length that `length` tells of them."""
    searched = search.order[: search.used[1]]
    if status != "found":
        return Found(status, np.empty(0, np.int32), math.inf, searched)
    path = path_through(search.parent, start, goal)
    return Found(status, path, length(path), searched)


def path_through(parent: Numbers, start: int, goal: int) -> Numbers:
    """The cells from start to goal, by the parent of each."""
    cells = [goal]
    while cells[-1] != start:
        cells.append(int(parent[cells[-1]]))
    return np.array(cells[::-1], np.int32)


def octile_length(path: Numbers, width: int) -> float:
    """Length [cells] of a path of straight and diagonal lines.

    Both kinds are counted before anything is rounded, so all shortest paths between two cells get the same bits.
    """
    up = np.abs(np.diff(path // width))
    across = np.abs(np.diff(path % width))
    diagonal = int(np.minimum(up, across).sum())
    return int(np.maximum(up, across).sum()) - diagonal + math.sqrt(2.0) * diagonal


def _from_end_to_end(cells: Cells, found: Found, start: Place, goal: Place) -> tuple[Array, float]:
    """The points of a path with its start and goal, and its length [m]."""
    ends = np.array([start[:2], goal[:2]])
    if len(found.path) == 1:  # both in one cell
        return (ends, math.dist(*ends)) if (ends[0] != ends[1]).any() else (ends[:1], 0.0)
    centres = cells.places(found.path)
    first, last = math.dist(ends[0], centres[0]), math.dist(ends[1], centres[-1])
    # The centre of a cell is in it, and so is the line to it. An end that is a centre but for rounding replaces it.
    same = 1e-9 * cells.side
    between = centres[1 if first <= same else 0 : -1 if last <= same else None]
    points = np.concatenate([ends[:1], between, ends[1:]])
    return points, found.length * cells.side + (first if first > same else 0.0) + (last if last > same else 0.0)


def _without_needless_centres(cells: Cells, points: Array, length: float) -> tuple[Array, float]:
    """A path without the centres of the cells of start and goal, where a straight line does, and its length [m]."""
    kept = points
    for end in (0, -1):
        after = 2 if end == 0 else -3
        if len(kept) > 2 and is_open_line(
            cells.free, cells.width, *cells.in_cells(*kept[end].tolist()), *cells.in_cells(*kept[after].tolist())
        ):
            kept = np.delete(kept, 1 if end == 0 else -2, axis=0)
    if len(kept) == len(points):
        return points, length
    return kept, math.fsum(np.hypot(*np.diff(kept, axis=0).T).tolist())


def _poses(points: Array, heading: float | None) -> Array:
    poses = np.zeros((len(points), 3))
    poses[:, :2] = points
    if len(points) > 1:
        legs = np.diff(points, axis=0)
        poses[:-1, 2] = np.arctan2(legs[:, 1], legs[:, 0])
        poses[-1, 2] = poses[-2, 2]
    if heading is not None:
        poses[-1, 2] = heading
    return poses


def _why_blocked(cells: Cells, name: str, x: float, y: float, place: int) -> str:
    where = f"the {name} ({x:g}, {y:g})"
    if cells.gaps is None or cells.gaps[place // cells.width - 1, place % cells.width - 1] < 0:
        return f"{where} is in an occupied cell"
    return (
        f"{where} is in a cell {cells.gap(place):.3g} m from an occupied one, and the footprint reaches "
        f"{cells.reach:.3g} m"
    )


def _why_unreachable(cells: Cells, start: int, goal: int) -> str:
    """Whether a smaller footprint would find a path, and which."""
    plain = "no free cells lead from start to goal"
    if cells.gaps is None:
        return plain
    # The largest gap with a path, among those that there are: without a path at one, there is none at larger ones.
    steps = np.unique(cells.gaps[(cells.gaps >= 0)])
    steps = steps[steps * cells.side**2 < cells.reach**2]
    low, high = -1, len(steps)
    while high - low > 1:
        middle = (low + high) // 2
        there = attrs.evolve(cells, free=cells.narrowed(int(steps[middle])))
        status, _ = run_octile(there, start, goal, len(there.free), 1.0)
        low, high = (middle, high) if status == "found" else (low, middle)
    if low < 0:
        return f"{plain}, not even for a point"
    would = math.sqrt(steps[low]) * cells.side
    return f"{plain} for a footprint that reaches {cells.reach:.3g} m; one that reaches {would:.3g} m would pass"
