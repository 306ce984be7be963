"""Following walls."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import attrs
import numpy as np

from amorsim.array_types import Array
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
from amorsim.contracts.joints import joints_of
from amorsim.controllers.abilities import command_along, curvature_max, twist_limits
from amorsim.controllers.beams import beams_of, range_sensor, turned_beams
from amorsim.core.errors import ComponentError
from amorsim.kernels.behaviours.free_space import Sight
from amorsim.kernels.behaviours.wall_following import follow_wall

__all__ = ["FollowWall"]


_ARC_SAMPLES = 7  # points that stand for the arc on which a cone's return lies
_MARGIN = 0.05  # [m] that it keeps free on both sides of the footprint as it drives


@attrs.frozen(kw_only=True)
class FollowWall(Controller):
    """Drives along a wall, which it keeps at one side; straight on, until it meets one.

    It steers by the nearest point that it sees on that side, from a little beyond straight ahead to behind abeam: that
    point should be abeam, at `distance`. It thus turns away from a wall ahead, and follows a wall around its end.

    A drive that cannot turn in place needs a `distance` of at least its smallest turning radius, and rooms to match.

    Parameters
    ----------
    side
        Side on which it keeps the wall: ``"left"`` or ``"right"``.
    distance
        Distance from the robot's base point to the wall [m].
    speed, turn_rate
        Top speed [m/s] and turning rate [rad/s].
    sensor
        Name of the range sensor that it uses, a scanner or a ring.
    """

    side: str = parameter("left", choices=("left", "right"), static=True, help="on which the wall is to be")
    distance: float = parameter(0.6, unit="m", gt=0, help="from the robot's base point to the wall")
    speed: float = parameter(0.3, unit="m/s", gt=0, help="fastest that it drives")
    turn_rate: float = parameter(1.0, unit="rad/s", gt=0, help="fastest that it turns")
    sensor: str = parameter("laser", refers="sensors", help="name of the range sensor by which it goes")

    def start(self, context: Context) -> State:
        """The robot's knowledge of its sensor and its drive.

        Raises
        ------
        ComponentError
            If it has no such range sensor, is too wide for the distance, or cannot curve so sharply.
        """
        robot = context.robot
        model = range_sensor(robot, self.sensor, "follow_wall")
        curvature = np.array(curvature_max(robot))
        least = np.maximum(1.0 / curvature, float(np.abs(robot.shape.outline[:, 1]).max()))
        short = np.flatnonzero((np.asarray(self.distance) < least)[:, 0])
        if len(short):
            row = int(short[0])
            raise ComponentError(
                f"follow_wall: {robot.who(row)} cannot keep a wall at {float(np.asarray(self.distance)[row, 0]):g} m: "
                f"its width and its smallest curve ask for {float(least[row, 0]):.3g} m. Make 'distance' larger."
            )
        half_angle: Any = getattr(model.sensor, "half_angle", 0.0)
        return {
            "beams": beams_of(model, context.rows),
            "half_angle": np.array(np.broadcast_to(half_angle, (context.rows, 1)), dtype=np.float64),
            "limits": twist_limits(robot),
            "curvature": curvature,
            "memory": np.zeros((context.rows, 1)),
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
        """The command `(N, c)` of this step."""
        joints = joints_of(robot, readings)
        is_cone = hasattr(robot.sensors[self.sensor].sensor, "half_angle")
        twist = np.empty((robot.rows, 3))
        follow_wall(
            Sight(
                readings[self.sensor].measured,
                turned_beams(robot, state["beams"], joints),
                state["half_angle"],
                _ARC_SAMPLES if is_cone else 1,
            ),
            float(np.abs(robot.shape.outline[:, 1]).max()) + _MARGIN,
            1.0 if self.side == "left" else -1.0,
            self.distance,
            self.speed,
            self.turn_rate,
            state["limits"],
            state["curvature"],
            state["memory"],
            twist,
        )
        return command_along(robot, twist, joints)
