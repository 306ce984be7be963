"""Shared by planners for cars: footprints that turn with the car, tested as the simulator tests them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import ClassVar

import attrs
import numpy as np
import shapely

from amorsim.algorithms.cells import check_map, free_cells, place_of
from amorsim.array_types import Array
from amorsim.contracts import Plan, Planner
from amorsim.core.errors import PlanError
from amorsim.core.maps.map import Map
from amorsim.core.parameters import parameter
from amorsim.core.shapes import SMALLEST, Shape, pack
from amorsim.kernels.collision.clearance import map_gaps
from amorsim.planners.on_cells import are_joined, why_unreachable

__all__ = ["Ends", "PosePlanner", "Query"]

Pose = tuple[float, float, float]
Ends = tuple[Pose, Pose]

_MOST_CELLS = 1_000_000
_POINT = Shape.circle(SMALLEST)


@attrs.frozen(kw_only=True, eq=False)
class Query:
    """A map and a footprint on it."""

    world: Map
    shape: Shape
    clearance: float

    def gaps(self, poses: Array) -> Array:
        """Gaps [m] (M,) of the footprint to the walls, at most the clearance; below 0 where they overlap.

        The simulator finds contacts by the same test.
        """
        count = len(poses)
        gaps, where = np.empty(count), np.empty((count, 2))
        body, caps = np.zeros(count, np.int64), np.full(count, self.clearance)
        bodies = pack([self.shape])
        map_gaps(self.world.grid, *self.world.origin, bodies, body, np.ascontiguousarray(poses), caps, gaps, where)
        return gaps

    def blocked(self, name: str, pose: Pose) -> Plan | None:
        """The plan for a blocked start or goal, `name`; None if it is free."""
        x, y, heading = pose
        gap = float(self.gaps(np.array([pose]))[0])
        if gap >= self.clearance:
            return None
        if not self._is_inside(x, y):
            return Plan(status=f"{name}_blocked", message=f"the {name} ({x:g}, {y:g}) is outside the map")
        where = f"the {name} ({x:g}, {y:g}, {math.degrees(heading):.3g} degrees)"
        message = (
            f"at {where} the footprint overlaps a wall or the edge of the map"
            if not gap >= 0.0
            else f"at {where} the footprint is {gap:.3g} m from a wall; expected the clearance of {self.clearance:g} m"
        )
        return Plan(status=f"{name}_blocked", message=message)

    def _is_inside(self, x: float, y: float) -> bool:
        """Whether a place is within the map, with its walls."""
        origin_x, origin_y, yaw = self.world.origin
        c, s = math.cos(yaw), math.sin(yaw)
        across, up = c * (x - origin_x) + s * (y - origin_y), c * (y - origin_y) - s * (x - origin_x)
        width, height = self.world.size
        return 0.0 <= across <= width and 0.0 <= up <= height

    @property
    def inner(self) -> float:
        """Radius [m] of the largest disc about the base point within the footprint; 0 if that does not hold it."""
        outline = shapely.Polygon(self.shape.outline)
        centre = shapely.Point(0.0, 0.0)
        return float(outline.exterior.distance(centre)) if outline.contains(centre) else 0.0

    def narrow_place(self, ends: Ends, *, is_proven: bool = False) -> str:
        """The disc that would pass between start and goal, if one within the footprint does not; else empty.

        By cells of the map, so a disc that is larger by a cell may pass as well. With `is_proven`, it is known that the
        disc does not pass.
        """
        width, height = self.world.size
        side = max(self.world.resolution, math.sqrt(width * height / _MOST_CELLS))
        cells = free_cells(self.world, self.inner, side=side)
        first, last = (cells.cell_at(*pose[:2]) for pose in ends)
        assert first is not None  # or they would be blocked
        assert last is not None
        if not is_proven:
            are_free = cells.free[first] and cells.free[last]
            if not are_free or are_joined(cells.free, cells.width, first, last):
                return ""
        why = why_unreachable(cells, first, last)
        return f"for the largest disc about the base point within the footprint, {why}"


@attrs.frozen(kw_only=True)
class PosePlanner(Planner):
    """A planner for cars: its paths are of straight lines and arcs, and the footprint turns with the car."""

    plans_headings: ClassVar[bool] = True

    radius: float = parameter(1.0, unit="m", gt=0, help="least turning radius")
    clearance: float = parameter(
        0.02, unit="m", ge=1e-4, help="gap to walls at the poses that are tested; between them half of it is kept"
    )

    def query(
        self, world: Map, start: Sequence[float], goal: Sequence[float], footprint: Shape | None
    ) -> tuple[Query, Ends]:
        """The query, as far as it is valid; a missing heading is that of the line from start to goal.

        Raises
        ------
        PlanError
            If map, start, goal or footprint cannot be meant.
        """
        check_map(world)
        first, last = place_of(start, "start"), place_of(goal, "goal")
        if not isinstance(footprint, Shape | None):
            raise PlanError(f"footprint is {footprint!r}; expected a Shape, such as am.Shape.circle(0.25), or None")
        straight = math.atan2(last[1] - first[1], last[0] - first[0])
        ends = tuple((x, y, straight if heading is None else heading) for x, y, heading in (first, last))
        query = Query(world=world, shape=_POINT if footprint is None else footprint, clearance=self.clearance)
        return query, (ends[0], ends[1])

    def spacing(self, reach: float, least: float = math.inf) -> float:
        """The spacing [m] of poses on a curve with which no point that far from the base point moves by more than the
        clearance between two of them; at most `least`.
        """
        return min(self.clearance / (1.0 + reach / self.radius), least)
