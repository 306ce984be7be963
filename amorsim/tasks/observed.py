"""Observations that several tasks have: ranges, and places from the robot."""

from __future__ import annotations

from typing import Any

import numpy as np

from amorsim.array_types import Array
from amorsim.contracts import Observable, RobotModel
from amorsim.core.errors import ComponentError, did_you_mean
from amorsim.kernels.sensing.readings import shares_of_range

__all__ = ["beams_of", "from_robot", "sensor_of", "with_ranges"]


def sensor_of(who: str, robot: RobotModel, name: str, kind: str) -> Any:
    """A sensor of the robot that a task observes; `kind` is a component that would do.

    Raises
    ------
    ComponentError
        If the robot has no sensor of that name.
    """
    if name not in robot.sensors:
        has = ", ".join(map(repr, robot.sensors)) or "none"
        raise ComponentError(
            f"{who} observes the sensor {name!r}, which the robot does not have; its sensors: {has}."
            f"{did_you_mean(name, robot.sensors)} Give it a {kind!r}, or name another one"
        )
    return robot.sensors[name].sensor


def beams_of(who: str, robot: RobotModel, sensor: str) -> int:
    """How many ranges a range sensor measures; 0 without one.

    Raises
    ------
    ComponentError
        If the robot has no sensor of that name, or it is not a range sensor.
    """
    if not sensor:
        return 0
    if not hasattr(sensor_of(who, robot, sensor, "laser"), "range_max"):
        raise ComponentError(f"{who} observes the ranges of {sensor!r}, which has none; name a range sensor")
    return robot.sensors[sensor].size


def with_ranges(first: int, known: Observable, sensor: str) -> Array:
    """Observations `(N, first + beams)`: columns to fill, and after them the ranges of a sensor, if there is one.

    Ranges are from 0 to 1 of the sensor's longest; no return, and no reading yet, are the longest too.
    """
    model = known.robot.sensors[sensor] if sensor else None
    found = np.empty((len(known.action), first + (model.size if model else 0)))
    if model:
        range_max = getattr(model.sensor, "range_max")  # noqa: B009 - of range sensors alone
        longest = np.array(range_max, dtype=np.float64).reshape(-1, 1)
        shares_of_range(known.readings[sensor].measured, longest, first, found)
    return found


def from_robot(pose: Array, goal: Array) -> Array:
    """Poses `(N, 3)` in the world from others: x ahead and y to the left [m], cosine and sine of the heading."""
    east, north = (goal[:, :2] - pose[:, :2]).T
    c, s = np.cos(pose[:, 2]), np.sin(pose[:, 2])
    turn = goal[:, 2] - pose[:, 2]
    return np.column_stack((c * east + s * north, c * north - s * east, np.cos(turn), np.sin(turn)))
