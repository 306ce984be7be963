"""Driving a square, as in the odometry test UMBmark."""

from __future__ import annotations

import math
from collections.abc import Mapping

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
from amorsim.controllers.abilities import Course, abilities, needs_turning_in_place
from amorsim.core.poses import compose

__all__ = ["Square"]


_TURN_FIRST = 0.1  # [rad] a larger error of the bearing is corrected in place


@attrs.frozen(kw_only=True)
class Square(Controller):
    """Drives a square from where it starts, straight ahead first, turns in place at corners, and stops.

    It uses its estimate, so the estimate's drift shows in the robot's true final pose. With the default side and
    speed, and both directions in turn, this is the test of J. Borenstein and L. Feng
    ("Measurement and correction of systematic odometry errors in mobile robots", IEEE Trans. Robotics and
    Automation 12(6), 1996).

    Parameters
    ----------
    side
        Side of the square [m].
    speed
        Its speed [m/s].
    direction
        ``"anticlockwise"``: all turns to the left; or ``"clockwise"``.
    laps
        Number of rounds.
    turn_rate
        Its rate of turns at the corners [rad/s].
    tolerance
        Distance from a corner [m] within which it turns there.
    heading_tolerance
        Largest error of the heading [rad] with which it leaves a corner; along a side it steers.
    """

    side: float = parameter(4.0, unit="m", gt=0, help="length of a side")
    speed: float = parameter(0.2, unit="m/s", gt=0, help="at which it drives")
    direction: str = parameter(
        "anticlockwise", choices=("anticlockwise", "clockwise"), static=True, help="which way round"
    )
    laps: int = parameter(1, ge=1, help="how often it goes round")
    turn_rate: float = parameter(0.7, unit="rad/s", gt=0, help="at which it turns at the corners")
    tolerance: float = parameter(0.002, unit="m", gt=0, help="distance from a corner within which it turns there")
    heading_tolerance: float = parameter(
        0.002, unit="rad", gt=0, help="error of the heading with which it leaves a corner at most"
    )

    def start(self, context: Context) -> State:
        """The corners, as the poses in which it leaves them, and the number reached.

        Raises
        ------
        ComponentError
            For a robot that cannot turn in place.
        """
        needs_turning_in_place(context.robot, "square")
        rows = context.rows
        turn = math.pi / 2.0 if self.direction == "anticlockwise" else -math.pi / 2.0
        leg = np.zeros((rows, 3))
        leg[:, 0:1] = self.side
        leg[:, 2] = turn
        corners = np.empty((rows, 4, 3))
        corner = np.array(context.pose, dtype=np.float64)
        corners[:, 3] = corner
        for i in range(3):
            corner = compose(corner, leg)
            corners[:, i] = corner
        return {
            "corners": corners,
            "reached": np.zeros((rows, 1), dtype=np.int64),
            **abilities(context.robot),
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
        """The command `(N, c)` of this step; 0 once the end is reached."""
        course = Course.of(robot, readings, estimate)
        reached = state["reached"]
        goal = np.take_along_axis(state["corners"], reached[:, :, None] % 4, axis=1)[:, 0]
        tolerance = (self.tolerance, self.heading_tolerance, _TURN_FIRST)
        twist, is_there = course.head_for(goal, self.speed, self.turn_rate, tolerance, clock.dt, state)
        is_on_way = reached < 4 * self.laps
        state["reached"] = reached + (is_on_way & is_there)
        return course.command(np.where(is_on_way, twist, 0.0))
