"""Wheels wired to sensors."""

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
from amorsim.controllers.abilities import command_along
from amorsim.core.errors import ComponentError, did_you_mean

__all__ = ["Braitenberg"]


# The Khepera's ring, from the left round the front to the right, and the two behind. Things on the left drive the left
# wheel and brake the right one; things straight ahead turn the robot to the right, or it would stop before a wall.
_LEFT = (0.4, 0.8, 1.0, -0.6, -1.2, -0.6, 0.1, 0.1)
_RIGHT = (-0.6, -1.2, -1.6, 0.2, 0.8, 0.4, 0.1, 0.1)


@attrs.frozen(kw_only=True)
class Braitenberg(Controller):
    """A vehicle of V. Braitenberg ("Vehicles", 1984): each wheel's speed is a weighted sum of what sensors feel.

    With activations a from 0 (nothing felt) to 1, the left wheel rolls at speed * (1 + sum of left_i a_i), the right
    wheel likewise. For a sensor that counts light, the activation is the reading over its saturation; for one that
    measures ranges, 1 - range / reach; for one that measures reflectances, the reading. The default weights are our
    own; they avoid obstacles with a ring of eight like the Khepera's.

    A drive that takes wheel speeds gets these. Any other drive gets the velocity that they would give two wheels as far
    apart as its footprint is wide.

    Parameters
    ----------
    sensor
        Name of the sensor.
    left, right
        Weight of each value on the left and the right wheel.
    speed
        Speed of both wheels where nothing is felt [m/s].
    reach
        For a sensor that measures ranges: things nearer than this [m] are felt.
    """

    sensor: str = parameter("infrared", refers="sensors", help="name of the sensor by which it goes")
    left: tuple[float, ...] = parameter(_LEFT, help="weight of each value on the left wheel")
    right: tuple[float, ...] = parameter(_RIGHT, help="weight of each value on the right wheel")
    speed: float = parameter(0.06, unit="m/s", gt=0, help="of both wheels where nothing is felt")
    reach: float = parameter(0.5, unit="m", gt=0, help="range from which on a range sensor feels something")

    def start(self, context: Context) -> State:
        """No state is kept.

        Raises
        ------
        ComponentError
            If the robot has no such sensor, it feels nothing ahead, or the number of weights is not that of its values.
        """
        robot = context.robot
        if self.sensor not in robot.sensors:
            names = ", ".join(repr(name) for name in robot.sensors) or "none"
            raise ComponentError(
                f"braitenberg uses the sensor {self.sensor!r}, which {robot.who(0)} does not have; its sensors: "
                f"{names}.{did_you_mean(self.sensor, robot.sensors)} Name one in the field 'sensor'."
            )
        model = robot.sensors[self.sensor]
        if model.sensor.unit not in ("m", "reflectance") and not hasattr(model.sensor, "saturation"):
            raise ComponentError(
                f"braitenberg uses the sensor {self.sensor!r}, but a {type(model.sensor).__name__} tells neither "
                "ranges, nor reflectances, nor counts up to a saturation."
            )
        for name in ("left", "right"):
            given = np.shape(getattr(self, name))[-1]
            if given != model.size:
                raise ComponentError(
                    f"braitenberg: expected a weight in {name!r} for each of the {model.size} values of the sensor "
                    f"{self.sensor!r}, got {given}."
                )
        return {}

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
        model = robot.sensors[self.sensor]
        sensor: Any = model.sensor
        values = readings[self.sensor].measured
        if sensor.unit == "m":
            felt = 1.0 - values / self.reach
        else:
            felt = values if sensor.unit == "reflectance" else values / sensor.saturation
        felt = np.clip(np.where(np.isnan(felt), 0.0, felt), 0.0, 1.0)
        left, right = np.array(self.left), np.array(self.right)
        speeds = np.ones((robot.rows, 2))
        for i in range(model.size):  # in order, whatever the number of rows
            speeds[:, 0] += left[:, i] * felt[:, i]
            speeds[:, 1] += right[:, i] * felt[:, i]
        speeds *= self.speed
        drive: Any = robot.drive
        if hasattr(drive, "speeds_to_rates"):
            return np.asarray(drive.speeds_to_rates(speeds))
        width = float(np.ptp(robot.shape.outline[:, 1]))
        twist = np.zeros((robot.rows, 3))
        twist[:, 0] = 0.5 * (speeds[:, 0] + speeds[:, 1])
        twist[:, 2] = (speeds[:, 1] - speeds[:, 0]) / width
        return command_along(robot, twist, joints_of(robot, readings))
