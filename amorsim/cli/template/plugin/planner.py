"""A planner: the straight line, where it is free."""

from __future__ import annotations

import math
from collections.abc import Sequence

import attrs
import numpy as np
import numpy.typing as npt

import amorsim as am

__all__ = ["StraightLine"]


@attrs.frozen(kw_only=True)
class StraightLine(am.Planner):
    """The straight line from start to goal, if the robot's circle can go along it.

    Parameters
    ----------
    step
        Distance between places that are tested [m].
    """

    step: float = am.parameter(0.02, unit="m", gt=0, help="distance between places that are tested")

    def plan(
        self, world: am.Map, start: Sequence[float], goal: Sequence[float], *, footprint: am.Shape | None = None
    ) -> am.Plan:
        """The plan, of two poses."""
        first, last = _place(start, "start"), _place(goal, "goal")
        reach = 0.0 if footprint is None else footprint.reach
        for name, place in (("start", first), ("goal", last)):
            if not _is_free(world, np.array([place[:2]]), reach)[0]:
                return am.Plan(status=f"{name}_blocked", message=f"the {name} is too close to a wall")
        length = math.hypot(last[0] - first[0], last[1] - first[1])
        along = np.linspace(0.0, 1.0, max(2, math.ceil(length / self.step) + 1))[:, None]
        places = np.array(first[:2]) + along * (np.array(last[:2]) - np.array(first[:2]))
        if not _is_free(world, places, reach).all():
            return am.Plan(status="unreachable", message="something is in the straight line", expanded=len(places))
        heading = math.atan2(last[1] - first[1], last[0] - first[0])
        poses = np.array([[*first[:2], heading], [*last[:2], last[2] if len(last) == 3 else heading]])
        return am.Plan(status="found", poses=poses, length=length, cost=length, expanded=len(places), searched=places)


def _place(given: Sequence[float], name: str) -> list[float]:
    """Two or three finite numbers, or a `PlanError`."""
    try:
        numbers = [float(number) for number in given]
    except (TypeError, ValueError):
        numbers = []
    if len(numbers) not in (2, 3) or not all(map(math.isfinite, numbers)):
        raise am.PlanError(f"{name}: expected (x, y) or (x, y, heading), got {given!r}")
    return numbers


def _is_free(world: am.Map, places: npt.NDArray[np.float64], reach: float) -> npt.NDArray[np.bool_]:
    """Whether a circle of that radius [m] about each place `(M, 2)` touches no occupied cell."""
    span = math.ceil(reach / world.resolution) + 1
    offsets = np.arange(-span, span + 1) * world.resolution
    dx, dy = (axis.reshape(-1) for axis in np.meshgrid(offsets, offsets))
    near = np.hypot(dx, dy) <= reach + world.resolution  # the corner of a cell may be nearer than its middle
    around = places[:, None, :] + np.stack((dx[near], dy[near]), axis=1)
    hits = world.occupied(around.reshape(-1, 2)).reshape(len(places), -1)
    return np.asarray(~hits.any(axis=1))
