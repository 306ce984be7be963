"""The robot that a log is taken to be of: with the beams of its scans, and its laser where the log has it."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import attrs

from amorsim.analysis.logs.carmen import carmen_geometry
from amorsim.analysis.logs.frames import Frames
from amorsim.analysis.logs.message_shapes import check_message
from amorsim.analysis.logs.message_values import SCANS, geometry_of
from amorsim.analysis.logs.recordings import RECORDING, is_carmen, messages_of
from amorsim.analysis.logs.scan_geometry import laser_with
from amorsim.core.arguments import checked, path_of
from amorsim.core.errors import AnalysisError
from amorsim.core.files.reading import is_file
from amorsim.runs.folder import ABOUT
from amorsim.scenario.pose import Pose
from amorsim.scenario.reading.robots import load_robot
from amorsim.scenario.spec import Robot

__all__ = ["default_robot", "robot_of"]


def default_robot() -> Robot:
    """The model ``pioneer2dx-lms200`` at the origin."""
    return load_robot("pioneer2dx-lms200", pose=Pose())


@checked
def robot_of(log: str | os.PathLike[str], topics: Mapping[str, str] | None = None) -> Robot:
    """The robot that a log is taken to be of if nobody names one: the model ``pioneer2dx-lms200`` at the origin.

    Its laser has the beams of the log's first scan. It is mounted as ``/tf_static`` of a recording has it in the frame
    of the odometry; without that, at the robot's base point, looking ahead. The nominal drive only translates odometry,
    so that any robot whose wheels roll and do not steer may have made the log.

    Parameters
    ----------
    log
        As of `read_log`.
    topics
        Of a recording: by sensor, ``"laser"`` and ``"encoder"``, the topic of its readings, if there are several.

    Raises
    ------
    AnalysisError
        If the log cannot be read, it has angles of wheels instead of odometry, or its laser hangs upside down.
    """
    path, robot = path_of(log, "log", RECORDING), default_robot()
    if is_file(path / ABOUT):
        return robot
    laser, geometry = robot.sensors["laser"], None
    if is_carmen(path):
        geometry = carmen_geometry(path)
    else:
        of_laser, of_encoder = ((topics or {}).get(name) for name in ("laser", "encoder"))
        odometry = _first(path, ("nav_msgs/Odometry",), of_encoder)
        if odometry is None and _first(path, ("sensor_msgs/JointState",), of_encoder) is not None:
            raise AnalysisError(
                f"{path}: angles of wheels tell how far a robot went only with its own radius and track; name the "
                "robot that made it"
            )
        if (scan := _first(path, SCANS, of_laser)) is not None:
            geometry = geometry_of(scan)
            mount = _frames(path).mount(_frame_of(scan), str(getattr(odometry, "child_frame_id", "")), str(path))
            laser = laser if mount is None else attrs.evolve(laser, mount=mount)
    if geometry is None:
        return robot
    sensor: Any = laser.sensor
    laser = attrs.evolve(laser, sensor=laser_with(geometry, sensor))
    return attrs.evolve(robot, sensors={**robot.sensors, "laser": laser})


def _first(path: Path, kinds: Sequence[str], topic: str | None) -> Any:
    """The content of the first message on a topic of these kinds, or on the only one; None if there is none."""

    def wanted(there: Mapping[str, str]) -> list[str]:
        fit = [name for name, kind in there.items() if kind in kinds and topic in (None, name)]
        return fit if len(fit) == 1 else []

    for each in messages_of(path, wanted):
        check_message(each.kind, each.content, f"{path}, {each.topic}")
        return each.content
    return None


def _frame_of(message: Any) -> str:
    header = getattr(message, "header", None)
    return "" if header is None else str(header.frame_id)


def _frames(path: Path) -> Frames:
    """The frames that do not move."""
    frames = Frames()
    for each in messages_of(path, lambda there: [name for name in ("/tf_static",) if name in there]):
        check_message(each.kind, each.content, f"{path}, {each.topic}")
        for one in getattr(each.content, "transforms", ()):
            frames.add(_frame_of(one), one.child_frame_id, one.transform)
    return frames
