"""A controller that drives straight on, and away from what is near."""

from __future__ import annotations

from collections.abc import Mapping

import attrs
import numpy as np
import numpy.typing as npt

import amorsim as am

__all__ = ["Roamer"]

Array = npt.NDArray[np.float64]


@attrs.frozen(kw_only=True)
class Roamer(am.Controller):
    """Drives straight on, and turns to the left while something is near.

    Parameters
    ----------
    speed
        At which it drives [m/s].
    distance
        To what it sees, at which it turns [m].
    sensor
        Name of the range sensor.
    """

    speed: float = am.parameter(0.3, unit="m/s", gt=0, help="at which it drives")
    distance: float = am.parameter(0.6, unit="m", gt=0, help="to what it sees, at which it turns")
    sensor: str = am.parameter("laser", refers="sensors", help="name of the range sensor")

    def command(
        self,
        robot: am.RobotModel,
        readings: Mapping[str, am.Measurement],
        estimate: am.Estimate,
        clock: am.Clock,
        state: am.State,
        draws: am.Draws,
    ) -> Array:
        """The command `(N, c)` for the drive, whatever drive it is."""
        is_near = readings[self.sensor].measured.min(axis=1, keepdims=True) < self.distance
        ahead, turn = np.where(is_near, 0.0, self.speed), np.where(is_near, 0.8, 0.0)
        twist = np.concatenate((ahead, np.zeros_like(ahead), turn), axis=1)  # [m/s, m/s, rad/s]
        return robot.drive.command_for(twist, np.zeros((robot.rows, len(robot.drive.joints))))
