"""Shared by planners with random samples: their fields, their statuses, and how places become a path."""

from __future__ import annotations

import abc
import math
from collections.abc import Sequence
from typing import NamedTuple

import attrs
import numpy as np

from amorsim.algorithms.cells import Cells, place_of
from amorsim.array_types import Array
from amorsim.contracts import Plan
from amorsim.core.maps.cell_lines import placed
from amorsim.core.maps.map import Map
from amorsim.core.parameters import parameter
from amorsim.core.shapes import Shape
from amorsim.kernels.search.any_angle import is_open_line
from amorsim.planners.on_cells import CellPlanner, are_joined, free_ends, poses_along, why_unreachable

__all__ = ["Grown", "SamplingPlanner"]


class Grown(NamedTuple):
    """The result of sampling, in cells from the map's lower left corner."""

    path: Array | None
    """(M, 2) from start to goal; None if the budget was used up before."""
    places: Array
    """(K, 2) taken up, in order."""
    links: Array
    """(E, 4) lines between them."""


@attrs.frozen(kw_only=True)
class SamplingPlanner(CellPlanner):
    """A planner that joins random places by straight lines through free cells.

    Samples cannot show that there is no path. So it first looks whether free cells lead from start to goal.
    """

    budget: int = parameter(20_000, ge=0, help="samples drawn at most")
    seed: int = parameter(0, ge=0, help="of the samples; the same one gives the same plan")
    shorten: bool = parameter(False, help="whether corners are left out where a straight line is free")

    @abc.abstractmethod
    def grow(self, cells: Cells, start: Array, goal: Array) -> Grown:
        """Look for a path between two different places (2,) [cells]."""

    def plan(
        self, world: Map, start: Sequence[float], goal: Sequence[float], *, footprint: Shape | None = None
    ) -> Plan:
        """The plan for a robot with this footprint; see `amorsim.Planner.plan`."""
        first, last = place_of(start, "start"), place_of(goal, "goal")
        cells = self.cells_of(world, footprint)
        ends = free_ends(cells, first, last)
        if isinstance(ends, Plan):
            return ends
        if not are_joined(cells.free, cells.width, *ends):
            return Plan(status="unreachable", message=why_unreachable(cells, *ends))
        places = np.array([cells.in_cells(*place[:2]) for place in (first, last)])
        if first[:2] == last[:2]:
            return Plan(status="found", poses=poses_along(np.array([last[:2]]), last[2]), length=0.0, cost=0.0)
        if self.budget == 0:
            return Plan(status="budget", message=self._used_up())
        inner = np.array([_inner(cells, place) for place in places])
        same = inner[0].tolist() == inner[1].tolist()
        grown = Grown(inner[:1], inner[:1], np.empty((0, 4))) if same else self.grow(cells, *inner)
        searched, links = _in_world(cells, grown.places), _in_world(cells, grown.links.reshape(-1, 2)).reshape(-1, 4)
        if grown.path is None:
            return Plan(
                status="budget",
                expanded=len(searched),
                searched=searched,
                links=links,
                message=self._used_up(),
            )
        path = self._shortened(cells, grown.path) if self.shorten else grown.path
        points = _in_world(cells, path)
        # Start and goal as they were given, not as they are after turning them into cells and back.
        ends_given = np.array([first[:2], last[:2]])
        keeps = [bool((place == kept).all()) for place, kept in zip(places, inner, strict=True)]
        points = np.concatenate((ends_given[:1], points[1 if keeps[0] else 0 :]))
        points = np.concatenate((points[: -1 if keeps[1] and len(points) > 1 else None], ends_given[1:]))
        length = math.fsum(np.hypot(*np.diff(points, axis=0).T).tolist())
        return Plan(
            status="found",
            poses=poses_along(points, last[2]),
            length=length,
            cost=length,
            expanded=len(searched),
            searched=searched,
            links=links,
        )

    def _used_up(self) -> str:
        return f"the budget of {self.budget} samples was used up; free cells do lead from start to goal"

    def _shortened(self, cells: Cells, path: Array) -> Array:
        """The path without the corners that a straight line may leave out, each time the farthest that is seen."""
        kept = [0]
        while kept[-1] < len(path) - 1:
            for other in range(len(path) - 1, kept[-1], -1):
                line = (*path[kept[-1]].tolist(), *path[other].tolist())
                if other == kept[-1] + 1 or is_open_line(cells.free, cells.width, *line):
                    kept.append(other)
                    break
        return path[kept]


def _inner(cells: Cells, place: Array) -> Array:
    """The place, or its cell's centre if the place is on a border to a blocked cell."""
    centre = np.floor(place) + 0.5
    is_seen = is_open_line(cells.free, cells.width, *place.tolist(), *centre.tolist())
    return place if is_seen else centre


def _in_world(cells: Cells, places: Array) -> Array:
    return placed(cells.origin, places * cells.side)
