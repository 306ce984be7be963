"""Dead reckoning: the pose from the motion of the wheels."""

from __future__ import annotations

import functools
from collections.abc import Mapping
from typing import Any

import attrs
import numpy as np
import numpy.typing as npt

from amorsim.contracts import (
    Context,
    Draws,
    Drive,
    Estimate,
    Estimator,
    Joint,
    Measurement,
    RobotModel,
    State,
    parameter,
)
from amorsim.core.errors import ComponentError, did_you_mean
from amorsim.kernels.kinematics import odometry

__all__ = ["DeadReckoning"]

Array = npt.NDArray[np.float64]

_NUDGE = 1e-5  # [rad] by which a joint is turned to find the body's motion; the error is of second order in it


@functools.cache
def _rolling(joints: tuple[Joint, ...]) -> npt.NDArray[np.int64]:
    return np.array([i for i, joint in enumerate(joints) if joint.rolls], dtype=np.int64)


@functools.cache
def _whole(rows: int) -> Array:
    return np.ones((rows, 1))


def _jacobian(drive: Drive, before: Array, after: Array, rolling: npt.NDArray[np.int64], radius: Array) -> Array:
    """The body's motion (forward, left, turn) per metre of travel of each rolling joint, `(N, 3, r)`."""
    offered: Any = getattr(drive, "jacobian", None)
    if offered is not None:
        return np.ascontiguousarray(offered(before, after))
    middle = 0.5 * (before + after)
    out = np.empty((len(middle), 3, len(rolling)))
    for j, joint in enumerate(rolling):
        back, ahead = middle.copy(), middle.copy()
        back[:, joint] -= _NUDGE
        ahead[:, joint] += _NUDGE
        one = _whole(len(middle))
        # Both start from the middle and are given in its frame, so the errors of first order cancel.
        moved = drive.displacement(middle, ahead, one) - drive.displacement(middle, back, one)
        out[:, :, j] = moved / (2.0 * _NUDGE * radius[:, j : j + 1])
    return out


@attrs.frozen(kw_only=True)
class DeadReckoning(Estimator):
    """Adds up the nominal drive's displacements between encoder readings, from the pose it was given.

    The covariance grows from 0 by white noise on the travel of each rolling joint, to first order; it does not
    depend on the number of steps. A drive may offer ``jacobian(before, after) -> (N, 3, r)``, the body's motion
    (forward, left, turn) per metre of travel of each rolling joint. Otherwise the Jacobian is found by turning
    each joint a little.

    Parameters
    ----------
    encoder
        Name of the sensor that counts the joints; any with a method ``angles(values) -> joints`` will do.
    wheel_variance
        Variance of the travel of each rolling joint per metre, as the robot assumes it [m^2/m].
    """

    encoder: str = parameter("encoder", refers="sensors", help="name of the sensor that counts the joints")
    wheel_variance: float = parameter(
        0.0,
        unit="m",
        ge=0,
        help="variance of a rolling joint's travel [m^2] per metre of it, as the robot believes",
    )

    def start(self, context: Context) -> State:
        """Pose and covariance, and the joints at the last reading, none yet.

        Raises
        ------
        ComponentError
            If the robot has no such sensor, or one that counts no joints.
        """
        sensors = context.robot.sensors
        if self.encoder not in sensors:
            names = ", ".join(repr(name) for name in sensors) or "none"
            raise ComponentError(
                f"dead reckoning reads the sensor {self.encoder!r}, which the robot does not have; its "
                f"sensors: {names}."
                f"{did_you_mean(self.encoder, sensors)} Name the robot's encoder in the field 'encoder'."
            )
        sensor = sensors[self.encoder].sensor
        if not callable(getattr(sensor, "angles", None)):
            raise ComponentError(
                f"dead reckoning reads the sensor {self.encoder!r}, but a {type(sensor).__name__} counts no "
                "joints: it has no method angles(values). Name the robot's encoder in the field 'encoder'."
            )
        return {
            "pose": np.array(context.pose, dtype=np.float64),
            "covariance": np.zeros((context.rows, 3, 3)),
            "joints": np.full((context.rows, len(context.robot.drive.joints)), np.nan),
        }

    def update(
        self,
        robot: RobotModel,
        readings: Mapping[str, Measurement],
        command: Array,
        elapsed: Array,
        state: State,
        draws: Draws,
    ) -> Estimate:
        """The estimate after this step's reading; an old reading shows the same joints and changes nothing."""
        drive = robot.drive
        encoder: Any = robot.sensors[self.encoder].sensor
        after = encoder.angles(readings[self.encoder].measured)
        before = state["joints"]
        before = np.where(np.isnan(before), after, before)  # the first reading is the reference of all others
        rows = len(after)
        rolling = _rolling(drive.joints)
        radius = drive.rolling_radius()
        pose, covariance = np.empty((rows, 3)), np.empty((rows, 3, 3))
        odometry.reckon(
            state["pose"],
            state["covariance"],
            np.ascontiguousarray(drive.displacement(before, after, _whole(rows))),
            drive.twist(before, after),
            _jacobian(drive, before, after, rolling, radius),
            before,
            after,
            rolling,
            radius,
            self.wheel_variance,
            pose,
            covariance,
        )
        state["pose"], state["covariance"], state["joints"] = pose, covariance, after
        return Estimate(pose, covariance)
