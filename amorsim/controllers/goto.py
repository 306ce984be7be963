"""Driving to a place."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

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

__all__ = ["GoTo"]


_TURN_FIRST = 0.2  # [rad] a larger error of the bearing is corrected in place


@attrs.frozen(kw_only=True)
class GoTo(Controller):
    """Turns towards a place, drives there by its estimate, and stops. It looks out for nothing on the way.

    Parameters
    ----------
    x, y
        The place in the world [m].
    tolerance
        Distance from the place within which the robot stops [m].
    speed
        Its speed [m/s].
    turn_rate
        Its rate of turns [rad/s].
    """

    x: float = parameter(unit="m", frame="world", help="the place, to the right in the world")
    y: float = parameter(unit="m", frame="world", help="the place, up in the world")
    tolerance: float = parameter(0.02, unit="m", gt=0, help="distance from the place within which it stops")
    speed: float = parameter(0.3, unit="m/s", gt=0, help="at which it drives")
    turn_rate: float = parameter(1.0, unit="rad/s", gt=0, help="at which it turns")

    def goal_points(self) -> Sequence[tuple[str, float, float]]:
        """The place."""
        return [("x", self.x, self.y)]

    def start(self, context: Context) -> State:
        """The limits of the drive, and its motion.

        Raises
        ------
        ComponentError
            For a robot that cannot turn in place.
        """
        needs_turning_in_place(context.robot, "goto")
        return abilities(context.robot)

    def command(
        self,
        robot: RobotModel,
        readings: Mapping[str, Measurement],
        estimate: Estimate,
        clock: Clock,
        state: State,
        draws: Draws,
    ) -> Array:
        """The command `(N, c)` of this step; 0 once the place is reached."""
        course = Course.of(robot, readings, estimate)
        goal = np.full((robot.rows, 3), np.nan)
        goal[:, 0:1] = self.x
        goal[:, 1:2] = self.y
        tolerance = (self.tolerance, _TURN_FIRST, _TURN_FIRST)
        twist, _ = course.head_for(goal, self.speed, self.turn_rate, tolerance, clock.dt, state)
        return course.command(twist)
