"""The others around a robot, as it knows them: from what they send, or from the marks that they carry."""

from __future__ import annotations

from typing import Any

import numpy as np

from amorsim.array_types import Array
from amorsim.contracts import Context, Measurement, RobotModel, State
from amorsim.controllers.abilities import Course
from amorsim.core.errors import ComponentError, did_you_mean
from amorsim.kernels import elementary

__all__ = ["know_others", "start_others"]


_SENT = ["range", "x", "y", "vx", "vy", "radius"]  # columns of a 'neighbours'
_SEEN = ["range", "bearing", "id"]  # columns of a 'fiducial'
_SETTLES = 0.3  # [s] time constant of a velocity that is estimated from places


def start_others(context: Context, sensor: str, who: str) -> State:
    """State of the controller `who` that knows others by a sensor: ``"others"`` `(N, M, 5)`, nan for none.

    Raises
    ------
    ComponentError
        If the robot has no such sensor.
    """
    robot = context.robot
    known = {name: one for name, one in robot.sensors.items() if list(one.sensor.columns()) in (_SENT, _SEEN)}
    if sensor not in known:
        raise ComponentError(
            f"{who} uses the sensor {sensor!r}, which is no 'neighbours' or 'fiducial' of {robot.who(0)}; it has: "
            f"{', '.join(map(repr, known)) or 'none'}.{did_you_mean(sensor, list(known))} Give it one, and name it in "
            "the field 'sensor'."
        )
    columns = list(known[sensor].sensor.columns())
    shape = context.rows, known[sensor].size // len(columns)
    state: State = {"others": np.full((*shape, 5), np.nan)}
    if columns == _SEEN:
        state |= {
            "mark": np.full(shape, -1.0),  # identity, -1 for none
            "mark_at": np.full((*shape, 2), np.nan),  # [m] in the world
            "mark_speed": np.full((*shape, 2), np.nan),  # [m/s] in the world, nan if it was seen only once
            "mark_time": np.full((context.rows, 1), -np.inf),  # [s] of the reading
        }
    return state


def know_others(
    robot: RobotModel, reading: Measurement, sensor: str, course: Course, radius: Array, time: Array, state: State
) -> Array:
    """The others around each robot `(N, M, 5)`: x, y [m], vx, vy [m/s] and radius [m], inf where there is none.

    They are as of now, in the frame in which the drive goes ahead. Marks give neither velocity nor radius: the
    velocity comes from the places of the same mark in two readings, and the radius is taken to be `radius` `(N, 1)`
    [m]. A mark without an identity counts as standing.
    """
    if "mark" in state:
        _track(robot, reading, sensor, course, time, state)
        others = _marks_ahead(course.poses, radius, time, state)
    else:
        others = _sent(robot, reading, sensor, course)
    state["others"] = np.where(np.isfinite(others[:, :, :1]), others, np.nan)
    return others


def _sent(robot: RobotModel, reading: Measurement, sensor: str, course: Course) -> Array:
    """The states that others sent, extrapolated to the present."""
    others = np.ascontiguousarray(reading.measured.reshape(robot.rows, -1, len(_SENT))[:, :, 1:])
    others[:, :, 0] += others[:, :, 2] * reading.age
    others[:, :, 1] += others[:, :, 3] * reading.age
    x, y, turn = _mount(robot, sensor, course)
    if x.any() or y.any() or turn.any():
        there = np.isfinite(others[:, :, 0]) & np.isfinite(others[:, :, 1])
        places, speeds = np.where(there[:, :, None], others[:, :, :2], 0.0), others[:, :, 2:4]
        others[:, :, :2] = np.where(there[:, :, None], _turned(places, turn) + np.stack((x, y), axis=2), np.inf)
        others[:, :, 2:4] = _turned(speeds, turn)
    return others


def _mount(robot: RobotModel, sensor: str, course: Course) -> tuple[Array, Array, Array]:
    """The mount of a sensor, x, y [m] and heading [rad], each `(N, 1)`, in the frame of the drive's course."""
    none = np.zeros((robot.rows, 1))
    mount: Any = robot.sensors[sensor].mount
    x, y, heading = none + mount.x, none + mount.y, none + mount.heading
    offset = robot.drive.heading_offset(course.joints)
    if offset is None:
        return x, y, heading
    place = _turned(np.stack((x, y), axis=2), -offset)
    return place[:, :, 0], place[:, :, 1], heading - offset


def _turned(vectors: Array, angle: Array) -> Array:
    """Vectors `(N, M, 2)` turned by angles `(N, 1)` [rad]."""
    c, s = np.cos(angle), np.sin(angle)
    x, y = vectors[:, :, 0], vectors[:, :, 1]
    return np.stack((c * x - s * y, s * x + c * y), axis=2)


def _track(robot: RobotModel, reading: Measurement, sensor: str, course: Course, time: Array, state: State) -> None:
    """Take a fresh reading of marks: where they are in the world, and how fast those are that were seen before."""
    fresh = reading.fresh & (time - reading.age > state["mark_time"])
    if not fresh.any():
        return
    table = reading.measured.reshape(robot.rows, -1, len(_SEEN))
    there = np.isfinite(table[:, :, 0]) & np.isfinite(table[:, :, 1])
    ranges, bearings = np.where(there, table[:, :, 0], 0.0), np.where(there, table[:, :, 1], 0.0)
    x, y, turn = _mount(robot, sensor, course)
    places = np.stack((x + ranges * np.cos(turn + bearings), y + ranges * np.sin(turn + bearings)), axis=2)
    # As seen from where the robot was when it took the reading.
    poses, moving = course.poses, state["moving"]
    heading = poses[:, 2:] - moving[:, 1:] * reading.age
    back = moving[:, :1] * reading.age
    at = _turned(places, heading) + np.stack(
        (poses[:, :1] - back * np.cos(heading), poses[:, 1:2] - back * np.sin(heading)), axis=2
    )
    at = np.where(there[:, :, None], at, np.nan)
    mark = np.where(there, table[:, :, 2], -1.0)
    # The slot that each mark had in the reading before, if it has an identity.
    same = (mark[:, :, None] == state["mark"][:, None, :]) & (mark > 0.0)[:, :, None]
    before = same.argmax(axis=2)[:, :, None]
    again = same.any(axis=2)[:, :, None]
    since = (time - reading.age - state["mark_time"])[:, :, None]
    with np.errstate(invalid="ignore", divide="ignore"):
        found = (at - np.take_along_axis(state["mark_at"], before, axis=1)) / since
        had = np.take_along_axis(state["mark_speed"], before, axis=1)
        speed = np.where(np.isfinite(had), had + (1.0 - elementary.exp(-since / _SETTLES)) * (found - had), found)
    fresh_marks = fresh[:, :, None]
    state["mark_speed"] = np.where(fresh_marks, np.where(again, speed, np.nan), state["mark_speed"])
    state["mark_at"] = np.where(fresh_marks, at, state["mark_at"])
    state["mark"] = np.where(fresh, mark, state["mark"])
    state["mark_time"] = np.where(fresh, time - reading.age, state["mark_time"])


def _marks_ahead(poses: Array, radius: Array, time: Array, state: State) -> Array:
    """The marks extrapolated from when they were seen, in the frame of the drive's course."""
    speed = np.where(np.isfinite(state["mark_speed"]), state["mark_speed"], 0.0)
    there = np.isfinite(state["mark_at"][:, :, :1])
    since = np.where(np.isfinite(state["mark_time"]), time - state["mark_time"], 0.0)[:, :, None]
    places = np.where(there, state["mark_at"], 0.0) + speed * since - poses[:, None, :2]
    others = np.empty((*there.shape[:2], 5))
    others[:, :, :2] = np.where(there, _turned(places, -poses[:, 2:]), np.inf)
    others[:, :, 2:4] = _turned(speed, -poses[:, 2:])
    others[:, :, 4] = radius
    return others
