"""Pure pursuit: driving along waypoints."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import attrs
import numpy as np
import numpy.typing as npt

from amorsim.contracts import (
    Clock,
    Context,
    Controller,
    Draws,
    Estimate,
    Measurement,
    RobotModel,
    State,
    parameter,
)
from amorsim.controllers.driving import command_along, curvature_max, heading_poses, joints_of, twist_limits
from amorsim.core.errors import ComponentError
from amorsim.core.parameters import ParameterError
from amorsim.kernels.pursuing import pursue

__all__ = ["Pursuit"]

Array = npt.NDArray[np.float64]

_LEAST = 1e-6  # [m] between waypoints


@attrs.frozen(kw_only=True)
class Pursuit(Controller):
    """Drives along straight lines from where it starts through waypoints, by its estimate, and stops at the last.

    Pure pursuit (R. C. Coulter, "Implementation of the pure pursuit path tracking algorithm", CMU-RI-TR-92-01, 1992):
    it steers for the place on the path that lies `lookahead` ahead, along the circle that leads there from its heading.
    So it cuts corners, the more the farther it looks. It looks out for nothing on the way.

    Any drive will do. One that turns in place does so before a place that is far off its heading; one that cannot takes
    the sharpest curve it can, and needs room for it.

    Parameters
    ----------
    waypoints
        Places in the world [m], one at least.
    loop
        Whether it goes on from the last waypoint to the first, for ever.
    speed
        At which it drives [m/s]; slower in curves that ask for more than `turn_rate`.
    lookahead
        How far ahead on the path it looks [m].
    tolerance
        How near to the last waypoint it stops [m], measured along the path.
    turn_rate
        Fastest that it turns [rad/s].
    """

    waypoints: tuple[tuple[float, float], ...] = parameter(unit="m", static=True, help="places in the world, in order")
    loop: bool = parameter(False, static=True, help="whether it goes round for ever")
    speed: float = parameter(0.3, unit="m/s", gt=0, help="at which it drives")
    lookahead: float = parameter(0.5, unit="m", gt=0, help="how far ahead on the path it looks")
    tolerance: float = parameter(0.02, unit="m", gt=0, help="how near to the last waypoint it stops")
    turn_rate: float = parameter(1.0, unit="rad/s", gt=0, help="fastest that it turns")

    def __attrs_post_init__(self) -> None:
        if not self.waypoints:
            raise ParameterError("waypoints", "expected one waypoint at least, got none")

    def makes_for(self) -> Sequence[tuple[str, float, float]]:
        """The waypoints."""
        return [(f"waypoints.{i}", x, y) for i, (x, y) in enumerate(self.waypoints)]

    def start(self, context: Context) -> State:
        """The paths from where the robots stand, and what they know of their drives.

        Raises
        ------
        ComponentError
            If a loop has less than two places that differ, or a robot stands on the only waypoint.
        """
        rows = context.rows
        places = [np.array(self.waypoints[0])]
        for place in self.waypoints[1:]:
            if np.hypot(*(place - places[-1])) > _LEAST:
                places.append(np.array(place))
        if self.loop:
            if np.hypot(*(places[0] - places[-1])) > _LEAST:
                places.append(places[0])
            if len(places) < 3:
                raise ComponentError(f"pursuit: a loop needs two waypoints that differ, got {self.waypoints}")
        path = np.empty((rows, len(places) + 1, 2))
        path[:, 0] = context.pose[:, :2]
        path[:, 1:] = places
        # Who stands on the first waypoint sets out from a little before it.
        steps = path[:, 1:] - path[:, :-1]
        lengths = np.sqrt(steps[:, :, 0] ** 2 + steps[:, :, 1] ** 2)
        there = lengths[:, 0] <= _LEAST
        path[there, 0, 0] -= 2.0 * _LEAST
        lengths[there, 0] = 2.0 * _LEAST
        along = np.zeros((rows, len(places) + 1))
        for i in range(len(places)):
            along[:, i + 1] = along[:, i] + lengths[:, i]
        return {
            "path": path,
            "along": along,
            "progress": np.zeros((rows, 1)),
            "moving": np.zeros((rows, 2)),
            "limits": twist_limits(context.robot),
            "curvature": np.array(curvature_max(context.robot)),
        }

    def command(
        self,
        robot: RobotModel,
        readings: Mapping[str, Measurement],
        estimate: Estimate,
        clock: Clock,
        state: State,
        draws: Draws,
    ) -> Array:
        """The command `(N, c)` of this step; at the end, to stand still."""
        joints = joints_of(robot, readings)
        twist = np.empty((robot.rows, 3))
        pursue(
            heading_poses(robot, estimate.pose, joints),
            state["path"],
            state["along"],
            self.loop,
            self.lookahead,
            self.speed,
            self.turn_rate,
            self.tolerance,
            state["limits"],
            state["curvature"],
            clock.dt,
            state["progress"],
            state["moving"],
            twist,
        )
        return command_along(robot, twist, joints)
