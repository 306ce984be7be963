"""An estimator: odometry whose heading a compass keeps from drifting away."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import attrs
import numpy as np
import numpy.typing as npt

import amorsim as am

__all__ = ["CompassOdometry"]

Array = npt.NDArray[np.float64]


@attrs.frozen(kw_only=True)
class CompassOdometry(am.Estimator):
    """Adds up what the wheels did, and puts the pose right by a compass: an extended Kalman filter.

    The odometry is smooth, but its heading drifts away; the compass is noisy, but does not drift. Each counts by its
    variance. As errors of the place come from errors of the heading, the place gains too.

    A reading that arrives late (a compass with a latency) is not used: it tells a heading of the past.

    Parameters
    ----------
    encoder
        Name of the sensor that counts the joints; any with a method ``angles(values) -> joints`` will do.
    compass
        Name of the sensor that tells the heading.
    compass_std
        Standard deviation of the compass that the robot reckons with [rad].
    way_variance
        Variance of the length of the way, per metre of it, that the robot reckons with [m^2/m].
    heading_variance
        Variance of the heading that a metre of the wheels adds, as the robot reckons with [rad^2/m].
    """

    encoder: str = am.parameter("encoder", refers="sensors", help="name of the sensor that counts the joints")
    compass: str = am.parameter("compass", refers="sensors", help="name of the sensor that tells the heading")
    compass_std: float = am.parameter(unit="rad", gt=0, help="standard deviation of the compass, as believed")
    way_variance: float = am.parameter(
        0.0, unit="m", ge=0, help="variance of the way's length [m^2] per metre of it, as believed"
    )
    heading_variance: float = am.parameter(
        0.0, unit="rad^2/m", ge=0, help="variance of the heading that a metre of the wheels adds, as believed"
    )

    def start(self, context: am.Context) -> am.State:
        """The pose given to the robot, certain, and no reading of the joints yet.

        Raises
        ------
        ComponentError
            If the robot lacks one of the two sensors, or the first counts no joints.
        """
        sensors = context.robot.sensors
        for field, name in (("encoder", self.encoder), ("compass", self.compass)):
            if name not in sensors:
                raise am.ComponentError(
                    f"compass_odometry: the robot has no sensor {name!r}; it has: {', '.join(sensors) or 'none'}; "
                    f"name one of them in the field {field!r}"
                )
        if not hasattr(sensors[self.encoder].sensor, "angles"):
            raise am.ComponentError(
                f"compass_odometry: the sensor {self.encoder!r} counts no joints, it has no method angles(values)"
            )
        return {
            "pose": np.array(context.pose, dtype=np.float64),
            "covariance": np.zeros((context.rows, 3, 3)),
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
        pose, covariance = self._roll(robot, readings[self.encoder].measured, state)
        pose, covariance = self._turn(robot, readings[self.compass], pose, covariance)
        state["pose"], state["covariance"] = pose, covariance
        return am.Estimate(pose, covariance)

    def _roll(self, robot: am.RobotModel, counts: Array, state: am.State) -> tuple[Array, Array]:
        """Pose and covariance after what the wheels did since the last counts."""
        encoder: Any = robot.sensors[self.encoder].sensor
        after: Array = encoder.angles(counts)
        before = np.where(np.isnan(state["joints"]), after, state["joints"])  # the first counts are the reference
        state["joints"] = after
        pose = am.compose(state["pose"], robot.drive.displacement(before, after, np.ones((robot.rows, 1))))

        # Errors so far, carried along: F P F', with F the derivative of the new pose by the old one. An error of the
        # heading sends the robot sideways. In elementwise products, as matrices' (@) would not have the same bits
        # for any number of rows.
        moved = pose - state["pose"]
        moved[:, 2] = 0.0
        aside = np.stack((-moved[:, 1], moved[:, 0], moved[:, 2]), axis=1)[:, :, None]
        old = state["covariance"]
        cross = aside * old[:, 2:3, :]
        covariance = old + (cross + cross.transpose(0, 2, 1)) + _square(aside) * old[:, 2:3, 2:3]
        # Errors that this step adds: in the way's length, and in the heading.
        length = np.sqrt(moved[:, 0:1] ** 2 + moved[:, 1:2] ** 2)
        ahead = (moved / np.sqrt(np.where(length > 0.0, length, 1.0)))[:, :, None]
        rolls = [joint.rolls for joint in robot.drive.joints]
        rolled = np.max(np.abs((after - before)[:, rolls]) * robot.drive.rolling_radius(), axis=1, keepdims=True)
        covariance += np.reshape(self.way_variance, (-1, 1, 1)) * _square(ahead)
        covariance[:, 2:3, 2] += self.heading_variance * rolled
        return pose, covariance

    def _turn(
        self, robot: am.RobotModel, reading: am.Measurement, pose: Array, covariance: Array
    ) -> tuple[Array, Array]:
        """Pose and covariance after a look at the compass, of those rows that have a new reading."""
        mount: Any = robot.sensors[self.compass].mount
        error = am.wrap_angle(reading.measured - mount.heading - pose[:, 2:3])
        column = covariance[:, :, 2]
        total = column[:, 2:3] + self.compass_std**2
        seen = reading.fresh & (reading.age == 0.0) & np.isfinite(error)
        pose = np.where(seen, pose + column / total * np.where(seen, error, 0.0), pose)
        pose[:, 2:3] = am.wrap_angle(pose[:, 2:3])
        less = _square(column[:, :, None]) / total[:, :, None]
        return pose, np.where(seen[:, :, None], covariance - less, covariance)


def _square(columns: Array) -> Array:
    """Columns `(N, 3, 1)` times their own transposes, `(N, 3, 3)`."""
    return columns * columns.transpose(0, 2, 1)
