"""What planners for cars share: footprints that turn with the car, tested as the simulator tests them."""

from __future__ import annotations

import math
from collections.abc import Sequence

import attrs
import numpy as np
import numpy.typing as npt

from amorsim.algorithms.cells import place_of
from amorsim.contracts import Plan, Planner
from amorsim.core.errors import PlanError
from amorsim.core.map import Map
from amorsim.core.parameters import parameter
from amorsim.core.shapes import SMALLEST, Shape, pack
from amorsim.kernels.collision.clearance import map_gaps

__all__ = ["Ends", "PosePlanner", "Query"]

Array = npt.NDArray[np.float64]
Pose = tuple[float, float, float]
Ends = tuple[Pose, Pose]

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
        """The plan that says that the start or goal, `name`, is blocked, or None if it is free."""
        x, y, heading = pose
        gap = float(self.gaps(np.array([pose]))[0])
        if gap >= self.clearance:
            return None
        where = f"the {name} ({x:g}, {y:g}, {math.degrees(heading):.3g} degrees)"
        message = (
            f"at {where} the footprint overlaps a wall or the edge of the map"
            if not gap >= 0.0
            else f"at {where} the footprint is {gap:.3g} m from a wall; expected the clearance of {self.clearance:g} m"
        )
        return Plan(status=f"{name}_blocked", message=message)


@attrs.frozen(kw_only=True)
class PosePlanner(Planner):
    """A planner for cars: its paths are of straight lines and arcs, and the footprint turns with the car."""

    radius: float = parameter(1.0, unit="m", gt=0, help="least turning radius")
    clearance: float = parameter(
        0.02, unit="m", ge=1e-4, help="gap to walls at the poses that are tested; between them half of it is kept"
    )

    def query(
        self, world: Map, start: Sequence[float], goal: Sequence[float], footprint: Shape | None
    ) -> tuple[Query, Ends]:
        """The question, as far as it can be asked; a heading that is not given is that of the line from start to goal.

        Raises
        ------
        PlanError
            If start, goal or footprint cannot be meant.
        """
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
