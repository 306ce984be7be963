"""Observations that several tasks have: ranges, and places from the robot."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from amorsim.contracts import Observable, RobotModel

__all__ = ["beams_of", "from_robot", "shares_of_range"]

Array = npt.NDArray[np.float64]


def beams_of(robot: RobotModel, sensor: str) -> int:
    """How many ranges a range sensor measures; 0 without one."""
    return robot.sensors[sensor].size if sensor else 0


def shares_of_range(known: Observable, sensor: str) -> Array:
    """The ranges `(N, k)` of a sensor, from 0 to 1 of its longest; no return, and no reading yet, are the longest too.

    Without a sensor `(N, 0)`.
    """
    if not sensor:
        return np.empty((len(known.action), 0))
    model = known.robot.sensors[sensor]
    longest = np.asarray(getattr(model.sensor, "range_max")).reshape(-1, 1)  # noqa: B009 - of range sensors alone
    shares: Array = known.readings[sensor].measured / longest
    np.fmin(shares, 1.0, out=shares)  # also where it is nan
    return np.maximum(shares, 0.0, out=shares)


def from_robot(pose: Array, goal: Array) -> Array:
    """Poses `(N, 3)` in the world from others: x ahead and y to the left [m], cosine and sine of the heading."""
    east, north = (goal[:, :2] - pose[:, :2]).T
    c, s = np.cos(pose[:, 2]), np.sin(pose[:, 2])
    turn = goal[:, 2] - pose[:, 2]
    return np.column_stack((c * east + s * north, c * north - s * east, np.cos(turn), np.sin(turn)))
