"""An estimator: odometry, from the wheels' counts and the nominal parameters."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import attrs
import numpy as np
import numpy.typing as npt

import amorsim as am

__all__ = ["WheelOdometry"]

Array = npt.NDArray[np.float64]


@attrs.frozen(kw_only=True)
class WheelOdometry(am.Estimator):
    """Adds up what the wheels did. It does not know how sure it may be: its covariance stays 0.

    Parameters
    ----------
    encoder
        Name of the sensor that counts the joints.
    """

    encoder: str = am.parameter("encoder", refers="sensors", help="name of the sensor that counts the joints")

    def start(self, context: am.Context) -> am.State:
        """The pose given to the robot, and no reading of the joints yet."""
        if self.encoder not in context.robot.sensors:
            raise am.ComponentError(f"the robot has no sensor {self.encoder!r}; name one in the field 'encoder'")
        return {
            "pose": np.array(context.pose, dtype=np.float64),
            "joints": np.full((context.rows, len(context.robot.drive.joints)), np.nan),
        }

    def update(
        self,
        robot: am.RobotModel,
        readings: Mapping[str, am.Measurement],
        command: Array,
        elapsed: Array,
        state: am.State,
        draws: am.Draws,
    ) -> am.Estimate:
        """The estimate after this step's readings: poses `(N, 3)` and covariances `(N, 3, 3)`."""
        encoder: Any = robot.sensors[self.encoder].sensor
        after: Array = encoder.angles(readings[self.encoder].measured)
        before = np.where(np.isnan(state["joints"]), after, state["joints"])  # the first counts are the reference
        moved = robot.drive.displacement(before, after, np.ones((robot.rows, 1)))
        state["joints"], state["pose"] = after, am.compose(state["pose"], moved)
        return am.Estimate(state["pose"], np.zeros((robot.rows, 3, 3)))
