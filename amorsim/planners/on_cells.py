"""Shared by planners on free cells: the cells, whether start and goal are free, and why there is no path."""

from __future__ import annotations

import math

import attrs
import numpy as np
import numpy.typing as npt

from amorsim.algorithms.cells import Cells, free_cells
from amorsim.array_types import Array
from amorsim.contracts import Plan, Planner
from amorsim.core.errors import PlanError
from amorsim.core.maps.map import Map
from amorsim.core.parameters import parameter
from amorsim.core.shapes import Shape
from amorsim.kernels import elementary
from amorsim.kernels.search.frontier import new_search
from amorsim.kernels.search.octile import FOUND, GOING_ON, expand_octile

__all__ = ["CellPlanner", "Place", "are_joined", "free_ends", "poses_along", "why_unreachable"]

Bytes = npt.NDArray[np.uint8]

Place = tuple[float, float, float | None]
"""x, y [m] and heading [rad] of a start or goal; None for a heading that is not given."""

_AT_A_TIME = 20_000  # cells, some milliseconds, so that Ctrl-C is noticed


@attrs.frozen(kw_only=True)
class CellPlanner(Planner):
    """A planner that keeps to free cells: those that are at least the footprint's reach from every occupied one."""

    cell: float | None = parameter(
        None, unit="m", gt=0, help="side of the cells; without it that of the map's, or up to 0.05 m on fine large maps"
    )
    avoid_unknown: bool = parameter(False, help="whether unknown cells of the map count as occupied")

    def cells_of(self, world: Map, footprint: Shape | None) -> Cells:
        """The cells of a map that a robot with this footprint may be in."""
        if not isinstance(footprint, Shape | None):
            raise PlanError(f"footprint is {footprint!r}; expected a Shape, such as am.Shape.circle(0.25), or None")
        reach = 0.0 if footprint is None else footprint.reach
        return free_cells(world, reach, side=self.cell, avoid_unknown=self.avoid_unknown)


def free_ends(cells: Cells, start: Place, goal: Place) -> tuple[int, int] | Plan:
    """The cells of start and goal, or the plan that names the blocked one."""
    places = []
    for name, (x, y, _) in (("start", start), ("goal", goal)):
        place = cells.cell_at(x, y)
        if place is None:
            return Plan(status=f"{name}_blocked", message=f"the {name} ({x:g}, {y:g}) is outside the map")
        if not cells.free[place]:
            return Plan(status=f"{name}_blocked", message=_why_blocked(cells, name, x, y, place))
        places.append(place)
    return places[0], places[1]


def poses_along(points: Array, heading: float | None) -> Array:
    """The poses (M, 3) of a path of straight lines, with the heading at its goal, if one is given."""
    poses = np.zeros((len(points), 3))
    poses[:, :2] = points
    if len(points) > 1:
        legs = np.diff(points, axis=0)
        poses[:-1, 2] = elementary.arctan2(legs[:, 1], legs[:, 0])
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


def are_joined(free: Bytes, width: int, start: int, goal: int) -> bool:
    """Whether free cells connect two cells by steps that cut no corner."""
    search = new_search(free, start)
    status = GOING_ON
    while status == GOING_ON:
        status = expand_octile(search, width, goal, 1.0, _AT_A_TIME)
    return status == FOUND


def why_unreachable(cells: Cells, start: int, goal: int) -> str:
    """The message why there is no path: whether a smaller footprint would find one, and which."""
    plain = "no free cells lead from start to goal"
    if cells.gaps is None:
        return plain
    # The largest gap with a path, among those that there are: without a path at one, there is none at larger ones.
    steps = np.unique(cells.gaps[(cells.gaps >= 0)])
    steps = steps[steps * cells.side**2 < cells.reach**2]
    low, high = -1, len(steps)
    while high - low > 1:
        middle = (low + high) // 2
        is_passed = are_joined(cells.narrowed(int(steps[middle])), cells.width, start, goal)
        low, high = (middle, high) if is_passed else (low, middle)
    if low < 0:
        return f"{plain}, not even for a point"
    would = math.sqrt(steps[low]) * cells.side
    return f"{plain} for a footprint that reaches {cells.reach:.3g} m; one that reaches {would:.3g} m would pass"
