"""What a nominal drive can do, as far as it says so."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from amorsim.contracts import RobotModel

__all__ = ["at_rest", "twist_limits"]

Array = npt.NDArray[np.float64]


def at_rest(robot: RobotModel) -> Array:
    """Joints `(N, j)` of a drive that points straight ahead: all at 0."""
    return np.zeros((robot.rows, len(robot.drive.joints)))


def twist_limits(robot: RobotModel) -> Array:
    """Fastest speed [m/s] and turn [rad/s], and how fast each may change [m/s^2, rad/s^2], `(N, 4)`.

    From the drive's `rate_max` and `acceleration_max`; inf where it has none.
    """
    joints = at_rest(robot)
    out = np.full((robot.rows, 4), np.inf)
    for column, axis in ((0, 0), (1, 2)):
        twist = np.zeros((robot.rows, 3))
        twist[:, axis] = 1.0
        rates = np.abs(robot.drive.command_for(twist, joints)).max(axis=1)
        for offset, name in ((0, "rate_max"), (2, "acceleration_max")):
            limit = getattr(robot.drive, name, None)
            if limit is not None:
                out[:, column + offset] = limit[:, 0] / rates
    return out
