"""Shared by all planners on cells: their fields, their statuses, and how cells become a path."""

from __future__ import annotations

import abc
import math
from collections.abc import Callable, Sequence
from typing import ClassVar, NamedTuple

import attrs
import numpy as np

from amorsim.algorithms.cells import Cells, place_of
from amorsim.array_types import Array, Ints32
from amorsim.contracts import Plan
from amorsim.core.maps.map import Map
from amorsim.core.parameters import parameter
from amorsim.core.shapes import Shape
from amorsim.kernels.search.any_angle import is_open_line
from amorsim.kernels.search.frontier import Search, new_search
from amorsim.kernels.search.octile import FOUND, GOING_ON, expand_octile
from amorsim.planners.on_cells import CellPlanner, Place, free_ends, poses_along, why_unreachable

__all__ = ["Found", "GridPlanner", "Place", "found_by", "octile_length", "path_through", "run_octile", "run_search"]


class Found(NamedTuple):
    """The result of a search on cells."""

    status: str
    """``"found"``, ``"unreachable"`` or ``"budget"``."""
    path: Ints32
    """The cells at the corners of the path, from start to goal; empty without one."""
    length: float
    """[cells] from the centre of the first to that of the last; inf without a path."""
    searched: Ints32
    """The cells expanded, in order."""


@attrs.frozen(kw_only=True)
class GridPlanner(CellPlanner):
    """A planner that searches square cells."""

    any_angle: ClassVar[bool] = False
    """Whether the lines of paths may have any direction."""

    budget: int = parameter(100_000_000, ge=0, help="cells expanded at most")

    @abc.abstractmethod
    def search(self, cells: Cells, start: int, goal: int) -> Found:
        """Search for a path between two free cells."""

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
        places = free_ends(cells, *ends)
        if isinstance(places, Plan):
            return places
        found = search(cells, *places)
        searched = cells.places(found.searched)
        if found.status != "found":
            message = (
                f"the budget of {self.budget} cells was used up"
                if found.status == "budget"
                else why_unreachable(cells, *places)
            )
            return Plan(status=found.status, expanded=len(searched), searched=searched, message=message)
        points, length = _from_end_to_end(cells, found, *ends)
        if self.any_angle:
            points, length = _without_needless_centres(cells, points, length)
        return Plan(
            status="found",
            poses=poses_along(points, ends[1][2]),
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


def found_by(status: str, search: Search, start: int, goal: int, length: Callable[[Ints32], float]) -> Found:
    """The result of a search, with the cells of its path by their parents, and their length by `length`."""
    searched = search.order[: search.used[1]]
    if status != "found":
        return Found(status, np.empty(0, np.int32), math.inf, searched)
    path = path_through(search.parent, start, goal)
    return Found(status, path, length(path), searched)


def path_through(parent: Ints32, start: int, goal: int) -> Ints32:
    """The cells from start to goal, by the parent of each."""
    cells = [goal]
    while cells[-1] != start:
        cells.append(int(parent[cells[-1]]))
    return np.array(cells[::-1], np.int32)


def octile_length(path: Ints32, width: int) -> float:
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
