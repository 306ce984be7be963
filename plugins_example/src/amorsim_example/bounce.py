"""A controller with memory: straight on, and away from what is near."""

from __future__ import annotations

from collections.abc import Mapping

import attrs
import numpy as np
import numpy.typing as npt

import amorsim as am

__all__ = ["Bounce"]

Array = npt.NDArray[np.float64]


@attrs.frozen(kw_only=True)
class Bounce(am.Controller):
    """Drives straight on, and turns away from what is near, to one side until the way is free.

    Parameters
    ----------
    speed
        At which it drives [m/s].
    distance
        To what is ahead, at which it turns away [m].
    sensor
        Name of the range sensor; the second half of its values looks to the left.
    """

    speed: float = am.parameter(0.3, unit="m/s", gt=0, help="at which it drives")
    distance: float = am.parameter(0.7, unit="m", gt=0, help="to what is ahead, at which it turns away")
    sensor: str = am.parameter("laser", refers="sensors", help="name of the range sensor")

    def start(self, context: am.Context) -> am.State:
        """The side it turns to `(N, 1)`: 1 left, -1 right, 0 while it drives."""
        return {"side": np.zeros((context.rows, 1))}

    def command(
        self,
        robot: am.RobotModel,
        readings: Mapping[str, am.Measurement],
        estimate: am.Estimate,
        clock: am.Clock,
        state: am.State,
        draws: am.Draws,
    ) -> Array:
        """The command `(N, c)`."""
        ranges = readings[self.sensor].measured  # (N, k) [m]
        half, quarter = ranges.shape[1] // 2, ranges.shape[1] // 4
        near = ranges[:, quarter:-quarter].min(axis=1, keepdims=True) < self.distance
        right = ranges[:, :half].min(axis=1, keepdims=True)
        left = ranges[:, half:].min(axis=1, keepdims=True)
        side = np.where(state["side"] == 0.0, np.where(right < left, 1.0, -1.0), state["side"])
        state["side"] = np.where(near, side, 0.0)
        ahead = np.where(near, 0.0, self.speed)
        twist = np.concatenate((ahead, np.zeros_like(ahead), 0.8 * state["side"]), axis=1)
        return robot.drive.command_for(twist, np.zeros((robot.rows, len(robot.drive.joints))))
