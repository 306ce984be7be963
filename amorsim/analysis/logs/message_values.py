"""The meaning of messages of ROS and of Foxglove: poses, readings and commands in the plane."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from amorsim.analysis.logs.message_shapes import VALUES
from amorsim.analysis.logs.scan_geometry import ScanGeometry, laser_with
from amorsim.analysis.trajectory import yaw
from amorsim.array_types import Array
from amorsim.contracts import Sensor
from amorsim.core.errors import AnalysisError
from amorsim.core.poses import wrap_angle
from amorsim.core.rows import stack
from amorsim.scenario.spec import Robot
from amorsim.sensors import Compass, Encoder, Gps, Gyro, Imu, Laser
from amorsim.simulation.fleet.grouping import channels_of

__all__ = [
    "SCANS",
    "beams_of",
    "command_of",
    "geometry_of",
    "holds_pose",
    "nanoseconds_of",
    "plane_pose",
    "pose_of",
    "quaternion",
    "reading_of",
]

Pose = tuple[float, float, float]

_EVEN = 1e-9  # [rad] to which angles at equal steps are equal
_ARRAYS = ("std_msgs/Float64MultiArray", "std_msgs/Float32MultiArray")
SCANS = ("sensor_msgs/LaserScan", "foxglove.LaserScan")
"""The kinds of messages that hold scans."""

_TRANSFORMS = ("geometry_msgs/TransformStamped", "foxglove.FrameTransform")
_POSES = (
    "nav_msgs/Odometry",
    "geometry_msgs/PoseWithCovarianceStamped",
    "geometry_msgs/PoseStamped",
    "foxglove.PoseInFrame",
)
_TURN = 2.0 * math.pi


def nanoseconds_of(time: float) -> int:
    """A time [s] in whole nanoseconds."""
    return round(time * 1e9)


def quaternion(heading: float) -> dict[str, float]:
    """A heading as a quaternion about z."""
    return {"x": 0.0, "y": 0.0, "z": math.sin(0.5 * heading), "w": math.cos(0.5 * heading)}


def beams_of(sensor: Sensor) -> Array | None:
    """The angles [rad] of a sensor's ranges `(beams,)`, if it measures several ranges [m] at even angles."""
    bearings = sensor.bearings() if sensor.unit == "m" else None
    angles = np.empty(0) if bearings is None else np.asarray(bearings)[0]
    if len(angles) < 2:
        return None
    steps = np.diff(angles)
    return angles if np.abs(steps - steps[0]).max() < _EVEN and steps[0] != 0.0 else None


def holds_pose(kind: str) -> bool:
    """Whether a message of a kind has a pose, or frames."""
    return kind in (*_POSES, *_TRANSFORMS, "tf2_msgs/TFMessage")


def pose_of(kind: str, content: Any, frame: str | None) -> tuple[Any, Pose] | None:
    """The part of a message with its stamp, and its pose; None if it has none of that frame."""
    if kind == "tf2_msgs/TFMessage":
        for each in content.transforms:
            if frame is None or each.child_frame_id == frame:
                return each, _plane(each.transform.translation, each.transform.rotation)
        return None
    if kind in _TRANSFORMS:
        if frame is not None and content.child_frame_id != frame:
            return None
        moved = content if kind == "foxglove.FrameTransform" else content.transform
        return content, _plane(moved.translation, moved.rotation)
    has_covariance = kind in _POSES[:2]
    return content, plane_pose(content.pose.pose if has_covariance else content.pose)


def plane_pose(pose: Any) -> Pose:
    """A pose of ROS or Foxglove in the plane z = 0: x, y [m], heading [rad]."""
    return _plane(pose.position, pose.orientation)


def geometry_of(content: Any) -> ScanGeometry:
    """The beams of a scan, of ROS or Foxglove."""
    beams = len(content.ranges)
    if hasattr(content, "angle_increment"):
        return ScanGeometry(beams, abs(float(content.angle_increment)) * (beams - 1), float(content.range_max))
    return ScanGeometry(beams, abs(float(content.end_angle) - float(content.start_angle)), None)


def _plane(place: Any, turned: Any) -> Pose:
    return place.x, place.y, _yaw(turned)


def _yaw(turned: Any) -> float:
    return yaw(turned.x, turned.y, turned.z, turned.w)


def reading_of(kind: str, content: Any, sensor: Sensor, robot: Robot, topic: str) -> Array:
    """A message as a reading of a robot's sensor, in that sensor's units.

    Raises
    ------
    AnalysisError
        If a message of that kind holds no such reading.
    """
    if kind == VALUES:
        return np.array([math.nan if value is None else float(value) for value in content.values], dtype=np.float64)
    if kind in _ARRAYS:
        return np.asarray(content.data, dtype=np.float64)
    if isinstance(sensor, Encoder) and kind == "sensor_msgs/JointState":
        return _counts(content, sensor, robot, topic)
    if kind == "sensor_msgs/Imu" and isinstance(sensor, (Gyro, Imu, Compass)):
        turn, moved = content.angular_velocity.z, content.linear_acceleration
        if isinstance(sensor, Compass):
            return np.array([_yaw(content.orientation)])
        return np.array([turn] if isinstance(sensor, Gyro) else [moved.x, moved.y, turn])
    if isinstance(sensor, Gps) and kind == "geometry_msgs/PointStamped":
        return np.array([content.point.x, content.point.y])
    if kind in SCANS and sensor.bearings() is not None:
        return _ranges(kind, content, sensor, topic)
    if kind == "sensor_msgs/Range" and sensor.unit == "m":
        return np.array([content.range], dtype=np.float64)
    raise AnalysisError(
        f"{topic}: a message {kind!r} holds no reading of a {type(sensor).__name__}; expected one of the kinds that "
        "write_bag writes for it, or std_msgs/Float64MultiArray"
    )


def _counts(content: Any, sensor: Encoder, robot: Robot, topic: str) -> Array:
    wanted = [joint.name for joint in robot.drive.joints]
    angles = np.asarray(content.position, dtype=np.float64)
    names: Sequence[str] = list(content.name)
    if set(wanted) <= set(names) and len(names) == len(angles):
        angles = angles[[names.index(name) for name in wanted]]
    elif len(angles) != len(wanted):
        raise AnalysisError(
            f"{topic}: expected the angles of the joints {', '.join(wanted)}, got those of {', '.join(names) or 'none'}"
        )
    counts: Array = angles / _TURN * np.asarray(sensor.counts_per_revolution)
    return counts


def _ranges(kind: str, content: Any, sensor: Sensor, topic: str) -> Array:
    """The ranges of a scan in the order of the sensor's own beams, found by their angles.

    Of a finite range beyond what the scan says that it can measure, nothing returned (inf); one that is too short, as
    the 0 of many drivers, is lost (nan).
    """
    ranges = np.asarray(content.ranges, dtype=np.float64)
    if kind == "sensor_msgs/LaserScan":
        ranges = np.where((ranges < content.range_min) & (ranges > -np.inf), np.nan, ranges)
        ranges = np.where(ranges > content.range_max, np.inf, ranges)
        # Not from angle_max: some drivers give the end of a full circle there, one step past the last beam.
        angles = content.angle_min + content.angle_increment * np.arange(len(ranges))
    else:
        angles = np.linspace(content.start_angle, content.end_angle, len(ranges))
        ranges = np.where(ranges == 0.0, np.inf, ranges)  # as JSON has no infinity
    own = beams_of(sensor)
    if own is None:  # numbers that do not fit are refused by who takes the reading
        return ranges
    if len(own) != len(ranges):
        laser = laser_with(geometry_of(content), Laser())
        raise AnalysisError(
            f"{topic}: a scan of {len(ranges)} beams, and the robot's sensor has {len(own)}; give it as many, as "
            f"laser = {{ beams = {laser.beams}, fov_deg = {math.degrees(laser.fov):.6g}, range_max = "
            f"{laser.range_max:.6g} }}"
        )
    if (angles[-1] > angles[0]) != (own[-1] > own[0]):
        angles, ranges = angles[::-1], ranges[::-1]
    first = int(np.argmin(_apart(angles, own[0])))  # the scan of a full circle may begin anywhere
    angles, ranges = np.roll(angles, -first), np.roll(ranges, -first)
    if not _apart(angles, own).max() <= 1.001 * abs(own[1] - own[0]):  # off by up to a beam in a full circle
        seen, wanted = (
            f"{math.degrees(each.min()):.1f} to {math.degrees(each.max()):.1f} degrees" for each in (angles, own)
        )
        raise AnalysisError(
            f"{topic}: expected beams at the angles of the robot's sensor, {wanted}, got {seen}; give the sensor the "
            "field of view of the scans"
        )
    return ranges


def _apart(angles: Array, others: Array | float) -> Array:
    """How far angles are apart [rad], the short way."""
    return np.asarray(np.abs(wrap_angle(angles - others)))


def command_of(kind: str, content: Any, robot: Robot, topic: str) -> Array:
    """A message as a command of a robot: numbers for its channels, or a twist that its nominal drive follows.

    Raises
    ------
    AnalysisError
        If a message of that kind holds no command.
    """
    if kind == VALUES:
        return np.array(content.values, dtype=np.float64)
    if kind in _ARRAYS:
        return np.asarray(content.data, dtype=np.float64)
    if kind not in ("geometry_msgs/Twist", "geometry_msgs/TwistStamped"):
        raise AnalysisError(
            f"{topic}: a message {kind!r} holds no command; expected geometry_msgs/Twist or std_msgs/Float64MultiArray"
        )
    twist = content if kind == "geometry_msgs/Twist" else content.twist
    wanted = np.array([[twist.linear.x, twist.linear.y, twist.angular.z]])
    command = stack([robot.drive]).command_for(wanted, np.zeros((1, len(robot.drive.joints))))
    return np.append(command[0], np.zeros(len(channels_of(robot)) - command.shape[1]))
