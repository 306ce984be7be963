"""Origins and directions of the values of range sensors, in the robot's frame."""

from __future__ import annotations

from typing import Any

import numpy as np

from amorsim.array_types import Array
from amorsim.contracts import Mount, RobotModel, SensorModel
from amorsim.core.errors import ComponentError, did_you_mean
from amorsim.core.poses import compose
from amorsim.kernels.kinematics import poses

__all__ = ["beams_of", "range_sensor", "turned_beams", "with_directions"]


def range_sensor(robot: RobotModel, name: str, who: str) -> SensorModel:
    """A robot's range sensor by name, for the controller `who`; `ComponentError` if it has no such sensor."""
    seeing = [
        other
        for other, model in robot.sensors.items()
        if model.sensor.unit == "m" and model.sensor.bearings() is not None
    ]
    known = ", ".join(repr(other) for other in seeing) or "none"
    if name not in robot.sensors:
        raise ComponentError(
            f"{who} uses the sensor {name!r}, which the robot does not have; its range sensors: {known}."
            f"{did_you_mean(name, seeing)} Name one of them in the field 'sensor'."
        )
    model = robot.sensors[name]
    if name not in seeing:
        kind = type(model.sensor).__name__
        lacks = "has no bearings" if model.sensor.bearings() is None else f"tells {model.sensor.unit!r}, no ranges"
        raise ComponentError(
            f"{who} uses the sensor {name!r}, but a {kind} {lacks}; the robot's range sensors: "
            f"{known}. Name one of them in the field 'sensor'."
        )
    return model


def beams_of(model: SensorModel, rows: int) -> Array:
    """Origin and direction of each value: poses in the robot's frame, cosine and sine of their headings.

    `(N, 5, k)`: x, y [m], heading [rad], and the two.
    """
    bearings = model.sensor.bearings()
    assert bearings is not None
    k = bearings.shape[1]
    on_mount = np.zeros((rows, k, 3))
    on_mount[:, :, 2] = bearings
    elements: Any = getattr(model.sensor, "elements", None)
    if isinstance(elements, Mount):  # a ring: a table of arrays (N, k)
        on_mount[:, :, 0] = elements.x
        on_mount[:, :, 1] = elements.y
    mount = np.empty((rows, k, 3))
    for column, value in enumerate((model.mount.x, model.mount.y, model.mount.heading)):
        mount[:, :, column] = value
    return with_directions(compose(mount.reshape(-1, 3), on_mount.reshape(-1, 3)).reshape(rows, k, 3))


def turned_beams(robot: RobotModel, beams: Array, joints: Array) -> Array:
    """The same beams in a frame with the heading in which the drive goes ahead."""
    course = robot.drive.heading_offset(joints)
    if course is None:
        return beams
    rows, _, k = beams.shape
    back = np.zeros((rows, k, 3))
    back[:, :, 2] = -course
    return with_directions(
        compose(back.reshape(-1, 3), np.swapaxes(beams[:, :3], 1, 2).reshape(-1, 3)).reshape(rows, k, 3)
    )


def with_directions(beams: Array) -> Array:
    """Beams `(N, 5, k)` as `beams_of` gives them, from their poses `(N, k, 3)`."""
    rows, k, _ = beams.shape
    headings = np.ascontiguousarray(beams[:, :, 2])
    cosine, sine = np.empty((rows, k)), np.empty((rows, k))
    poses.directions(headings, cosine, sine)
    return np.stack((beams[:, :, 0], beams[:, :, 1], headings, cosine, sine), axis=1)
