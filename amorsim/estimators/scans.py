"""The scans of a range sensor as estimators read them: the beams, and where they start."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from amorsim.array_types import Array, Bools
from amorsim.contracts import RobotModel
from amorsim.core.errors import ComponentError
from amorsim.core.poses import compose
from amorsim.estimators.wheels import sensor_of
from amorsim.kernels.kinematics.poses import directions
from amorsim.kernels.mapping.occupancy import Scans

__all__ = ["Beams", "beams_of", "check_laser", "mounts_of", "scans_of"]


class Beams(NamedTuple):
    """The nominal beams of a laser."""

    cos_b: Array  # (B, k), B = 1 or N
    sin_b: Array
    range_max: Array  # (R, 1), R = 1 or N [m]
    mounts: Array  # (N, 3)


def check_laser(who: str, robot: RobotModel, name: str) -> None:
    """Raise a `ComponentError` if the robot has no such sensor, or one without beams of a known longest range."""
    sensor = sensor_of(who, robot, name, "laser", "laser")
    if sensor.bearings() is None or getattr(sensor, "range_max", None) is None or sensor.unit != "m":
        raise ComponentError(
            f"{who} reads scans of the sensor {name!r}, but a {type(sensor).__name__} has no beams of a known longest "
            "range; name the robot's laser in the field 'laser'"
        )


def beams_of(robot: RobotModel, name: str) -> Beams:
    """The nominal beams of a sensor that `check_laser` has let pass."""
    sensor: Any = robot.sensors[name].sensor
    bearings = np.ascontiguousarray(sensor.bearings())
    cos_b, sin_b = np.empty_like(bearings), np.empty_like(bearings)
    directions(bearings, cos_b, sin_b)
    range_max = np.array(sensor.range_max, dtype=np.float64).reshape(-1, 1)
    return Beams(cos_b, sin_b, range_max, mounts_of(robot, name))


def mounts_of(robot: RobotModel, name: str) -> Array:
    """Nominal poses `(N, 3)` of a sensor on its robots."""
    mount = robot.sensors[name].mount
    sides: Any = mount.x, mount.y, mount.heading
    return np.concatenate([np.broadcast_to(side, (robot.rows, 1)) for side in sides], axis=1)


def scans_of(beams: Beams, poses: Array, ranges: Array, fresh: Bools) -> Scans:
    """Scans taken by robots at `poses` `(N, 3)`, as kernels read them."""
    return Scans(
        compose(poses, beams.mounts),
        np.ascontiguousarray(ranges),
        np.ascontiguousarray(fresh),
        beams.cos_b,
        beams.sin_b,
        beams.range_max,
    )
