"""A run as a rosbag2, by the library rosbags: it needs no ROS, and `ros2 bag play` plays it."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any, Final

import numpy as np

from amorsim.analysis.logs.message_values import beams_of, nanoseconds_of, quaternion
from amorsim.analysis.own_columns import own_commands, own_readings
from amorsim.analysis.run_files import RunFiles, Table
from amorsim.array_types import Array
from amorsim.core.errors import AnalysisError, RunError
from amorsim.core.files.atomic_files import make_folders, new_file
from amorsim.scenario.spec import MountedSensor, Robot
from amorsim.sensors import Compass, Encoder, Gps, Gyro, Imu
from amorsim.simulation.fleet.grouping import channels_of

__all__ = ["write_bag"]


_VERSION: Final = 8  # of the bag's format: ROS 2 Iron and later read it
_MAP = "map"
_NO_COVARIANCE = np.zeros(36)
_PLACES = (("xx", (0,)), ("xy", (1, 6)), ("xh", (5, 30)), ("yy", (7,)), ("yh", (11, 31)), ("hh", (35,)))
_UNKNOWN = -1.0  # first element of a covariance of what an IMU does not measure

Sent = tuple[int, str, Any]  # time [ns], topic, message


def write_bag(files: RunFiles, path: Path, within: Path) -> None:
    """Write the first replica of a run as a rosbag2, a folder with one MCAP file, compressed with zstd.

    =========================  =====================================================================================
    ``/clock``                 ``rosgraph_msgs/Clock`` at each step
    ``/tf``, ``/tf_static``    ``map`` to ``ROBOT/odom`` (the same frame) to ``ROBOT/base_link``, by the estimated
                               pose; ``ROBOT/true_base_link``, by the true pose; a frame for each sensor
    ``/ROBOT/odom``            ``nav_msgs/Odometry``: the estimated pose and twist
    ``/ROBOT/ground_truth``    ``nav_msgs/Odometry``: the true pose and twist
    ``/ROBOT/estimates/NAME``  ``geometry_msgs/PoseWithCovarianceStamped``: the estimate of each estimator
    ``/ROBOT/command``         ``std_msgs/Float64MultiArray``, at the time at which it was given
    ``/ROBOT/SENSOR``          ``sensor_msgs/LaserScan`` for ranges at even angles, ``JointState`` [rad] for encoders,
                               ``Imu`` for gyros, IMUs and compasses, ``geometry_msgs/PointStamped`` for places of a
                               GPS, ``std_msgs/Float64MultiArray`` for others
    =========================  =====================================================================================

    Messages are in the order in which they arrived; stamps are when they were measured. An array has no stamp, so those
    who read it take it for measured when it arrived. ROS's scans have single precision.

    Parameters
    ----------
    within
        The folder in which the bag must stay, as of `amorsim.core.files.atomic_files.replacing`.

    Raises
    ------
    AnalysisError
        Without the library rosbags; or if two names are the same in ROS, which has letters, digits and ``_`` only.
    RunError
        If a file of the run is damaged, or the bag cannot be written.
    """
    try:
        from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin, Writer
        from rosbags.typesys import Stores, get_typestore
    except ModuleNotFoundError:
        raise AnalysisError('rosbag2 needs a library: python -m pip install "amorsim[rosbag]"') from None
    store = get_typestore(Stores.ROS2_HUMBLE)
    sent = sorted(_Messages(files, store).all(), key=lambda each: each[:2])
    try:
        make_folders(path.parent, within)
        with new_file(path.name, path.parent) as new:
            whole = Writer(new, version=_VERSION, storage_plugin=StoragePlugin.MCAP)
            # The chunks of the MCAP file, which every reader of MCAP opens; ROS takes the bag for an uncompressed one.
            whole.set_compression(CompressionMode.STORAGE, CompressionFormat.ZSTD)
            with whole as writer:
                connections: dict[str, Any] = {}
                for time, topic, message in sent:
                    kind = message.__msgtype__
                    if topic not in connections:
                        qos = [_latched()] if topic == "/tf_static" else []
                        connections[topic] = writer.add_connection(
                            topic, kind, typestore=store, offered_qos_profiles=qos
                        )
                    writer.write(connections[topic], time, store.serialize_cdr(message, kind))
            _put(new, path)
    except OSError as error:
        raise RunError(f"{path}: cannot be written ({error.strerror or error})") from None


def _put(new: Path, path: Path) -> None:
    """Move a bag to its place; replaces an earlier bag there and nothing else."""
    if path.is_symlink():
        path.unlink()
    if path.exists():
        if not (path / "metadata.yaml").exists():
            raise RunError(f"{path}: exists and is not a bag; remove it, or name another folder")
        path.rename(new.with_name(f"{path.name}-before"))
    new.rename(path)


def _latched() -> Any:
    """The quality of service for frames that never change: those that listen later get the last message."""
    from rosbags import interfaces as ros

    never = ros.QosTime(0, 0)
    return ros.Qos(
        ros.QosHistory.KEEP_LAST,
        1,
        ros.QosReliability.RELIABLE,
        ros.QosDurability.TRANSIENT_LOCAL,
        never,
        never,
        ros.QosLiveliness.AUTOMATIC,
        never,
        False,
    )


class _Messages:
    """Makes the messages of a run."""

    def __init__(self, files: RunFiles, store: Any) -> None:
        self._files = files
        self._types = store.types
        self._replica = files.replicas[0]
        self._names: dict[str, str] = {}

    def all(self) -> Iterator[Sent]:
        """All messages, robot by robot."""
        robots = self._files.scenario.robots
        times = self._table("poses", robots[0])["time"]
        for time in map(nanoseconds_of, times.tolist()):
            yield time, "/clock", self._type("rosgraph_msgs/msg/Clock")(clock=self._stamp(time))
        fixed: list[Any] = []
        begin = nanoseconds_of(float(times[0])) if len(times) else 0
        for robot in robots:
            name = self._name(robot.name)
            fixed.append(self._transform(begin, _MAP, f"{name}/odom", (0.0, 0.0, 0.0)))
            for sensor, unit in robot.sensors.items():
                mount = (unit.mount.x, unit.mount.y, unit.mount.heading)
                fixed.append(self._transform(begin, f"{name}/base_link", self._frame(robot, sensor), mount))
            yield from self._poses(robot)
            yield from self._estimates(robot)
            yield from self._commands(robot)
            for sensor in self._files.sensors:
                if sensor in robot.sensors:
                    yield from self._readings(robot, sensor, robot.sensors[sensor])
        yield begin, "/tf_static", self._type("tf2_msgs/msg/TFMessage")(transforms=fixed)

    def _name(self, name: str) -> str:
        """A name as ROS allows it."""
        plain = re.sub(r"\W", "_", name, flags=re.ASCII)
        plain = f"_{plain}" if plain[0].isdigit() else plain
        if self._names.setdefault(plain, name) != name:
            raise AnalysisError(
                f"{self._files.folder}: {self._names[plain]!r} and {name!r} are both {plain!r} in ROS; rename one"
            )
        return plain

    def _frame(self, robot: Robot, sensor: str) -> str:
        return f"{self._name(robot.name)}/{self._name(sensor)}"

    def _table(self, name: str, robot: Robot) -> Table:
        return self._files.table(name, robot=robot.name, replica=self._replica)

    def _poses(self, robot: Robot) -> Iterator[Sent]:
        poses, twists = self._table("poses", robot), self._table("velocities", robot)
        own = self._name(robot.name)
        times = list(map(nanoseconds_of, poses["time"].tolist()))
        odometry = self._type("nav_msgs/msg/Odometry")
        of = {"estimated": ("odom", f"{own}/odom", "base_link"), "true": ("ground_truth", _MAP, "true_base_link")}
        for what, (topic, parent, child) in of.items():
            found = _columns(poses, [f"{what}_{key}" for key in ("x", "y", "heading")])
            moving = _columns(twists, [f"{what}_{key}" for key in ("forward", "left", "turn")])
            for time, pose, twist in zip(times, found, moving, strict=False):
                yield (
                    time,
                    f"/{own}/{topic}",
                    odometry(
                        header=self._header(time, parent),
                        child_frame_id=f"{own}/{child}",
                        pose=self._with_covariance(pose, _NO_COVARIANCE),
                        twist=self._type("geometry_msgs/msg/TwistWithCovariance")(
                            twist=self._twist(twist), covariance=_NO_COVARIANCE
                        ),
                    ),
                )
                moved = self._transform(time, parent, f"{own}/{child}", pose)
                yield time, "/tf", self._type("tf2_msgs/msg/TFMessage")(transforms=[moved])

    def _estimates(self, robot: Robot) -> Iterator[Sent]:
        own = self._name(robot.name)
        stamped = self._type("geometry_msgs/msg/PoseWithCovarianceStamped")
        for name in robot.estimators:
            table = self._table(f"estimates/{name}", robot)
            covariance = np.zeros((len(table["time"]), 36))
            for key, places in _PLACES:
                covariance[:, places] = table[key][:, None]
            poses = _columns(table, ["x", "y", "heading"])
            topic = f"/{own}/estimates/{self._name(name)}"
            for time, pose, spread in zip(table["time"].tolist(), poses, covariance, strict=True):
                when = nanoseconds_of(time)
                header = self._header(when, f"{own}/odom")
                yield when, topic, stamped(header=header, pose=self._with_covariance(pose, spread))

    def _commands(self, robot: Robot) -> Iterator[Sent]:
        table, values = own_commands(self._files, robot.name, self._replica)
        channels = channels_of(robot)
        times = table["time"].tolist()
        topic = f"/{self._name(robot.name)}/command"
        # A line has the command of the step that ended then; it was given at the end of the step before.
        for time, row in zip(times, values[1:], strict=False):
            yield nanoseconds_of(time), topic, self._numbers(row, channels)

    def _readings(self, robot: Robot, name: str, unit: MountedSensor) -> Iterator[Sent]:
        table, values = own_readings(self._files, robot.name, name, self._replica)
        topic = f"/{self._name(robot.name)}/{self._name(name)}"
        frame = self._frame(robot, name)
        for time, stamp, row in zip(table["time"].tolist(), table["stamp"].tolist(), values, strict=True):
            yield nanoseconds_of(time), topic, self._reading(robot, unit, nanoseconds_of(stamp), frame, row)

    def _reading(self, robot: Robot, unit: MountedSensor, stamp: int, frame: str, values: Array) -> Any:
        sensor, header = unit.sensor, self._header(stamp, frame)
        angles = beams_of(sensor)
        if angles is not None and len(angles) == len(values):
            # Noise may have led values out of the sensor's range; ROS has none there that count.
            told = values[np.isfinite(values)]
            low, high = (
                float(getattr(sensor, name, other)) for name, other in (("range_min", 0.0), ("range_max", np.inf))
            )
            return self._type("sensor_msgs/msg/LaserScan")(
                header=header,
                angle_min=float(angles[0]),
                angle_max=float(angles[-1]),
                angle_increment=float(angles[1] - angles[0]),
                time_increment=0.0,
                scan_time=0.0,
                range_min=float(told.min(initial=low)),
                range_max=float(told.max(initial=high)),
                ranges=values.astype(np.float32),
                intensities=np.empty(0, np.float32),
            )
        if isinstance(sensor, Encoder):
            return self._type("sensor_msgs/msg/JointState")(
                header=header,
                name=[joint.name for joint in robot.drive.joints],
                position=sensor.angles(values),
                velocity=np.empty(0),
                effort=np.empty(0),
            )
        if isinstance(sensor, (Compass, Gyro, Imu)):
            return self._imu(sensor, header, values)
        if isinstance(sensor, Gps) and not sensor.heading:
            x, y = values.tolist()
            return self._type("geometry_msgs/msg/PointStamped")(
                header=self._header(stamp, _MAP), point=self._type("geometry_msgs/msg/Point")(x=x, y=y, z=0.0)
            )
        return self._numbers(values, [sensor.unit])

    def _imu(self, sensor: Compass | Gyro | Imu, header: Any, values: Array) -> Any:
        """An Imu with what the sensor measures; the covariances mark the rest as unknown."""
        is_compass = isinstance(sensor, Compass)
        heading = float(values[0]) if is_compass else 0.0
        ahead, left = values[:2].tolist() if isinstance(sensor, Imu) else (0.0, 0.0)
        known, unknown = np.zeros(9), np.zeros(9)
        unknown[0] = _UNKNOWN
        return self._type("sensor_msgs/msg/Imu")(
            header=header,
            orientation=self._turned(heading if math.isfinite(heading) else math.nan),  # a lost one may be infinite
            orientation_covariance=known if is_compass else unknown,
            angular_velocity=self._vector(0.0, 0.0, 0.0 if is_compass else float(values[-1])),
            angular_velocity_covariance=unknown if is_compass else known,
            linear_acceleration=self._vector(ahead, left, 0.0),
            linear_acceleration_covariance=known if isinstance(sensor, Imu) else unknown,
        )

    # ----------------------------------------------------------------------------------------------------------- parts

    def _type(self, name: str) -> Any:
        return self._types[name]

    def _stamp(self, time: int) -> Any:
        return self._type("builtin_interfaces/msg/Time")(sec=time // 10**9, nanosec=time % 10**9)

    def _header(self, time: int, frame: str) -> Any:
        return self._type("std_msgs/msg/Header")(stamp=self._stamp(time), frame_id=frame)

    def _vector(self, x: float, y: float, z: float) -> Any:
        return self._type("geometry_msgs/msg/Vector3")(x=x, y=y, z=z)

    def _turned(self, heading: float) -> Any:
        return self._type("geometry_msgs/msg/Quaternion")(**quaternion(heading))

    def _twist(self, twist: Iterable[float]) -> Any:
        forward, left, turn = twist
        return self._type("geometry_msgs/msg/Twist")(
            linear=self._vector(forward, left, 0.0), angular=self._vector(0.0, 0.0, turn)
        )

    def _with_covariance(self, pose: Iterable[float], covariance: Array) -> Any:
        x, y, heading = pose
        point = self._type("geometry_msgs/msg/Point")(x=x, y=y, z=0.0)
        made = self._type("geometry_msgs/msg/Pose")(position=point, orientation=self._turned(heading))
        return self._type("geometry_msgs/msg/PoseWithCovariance")(pose=made, covariance=covariance)

    def _transform(self, time: int, parent: str, child: str, pose: Iterable[float]) -> Any:
        x, y, heading = pose
        return self._type("geometry_msgs/msg/TransformStamped")(
            header=self._header(time, parent),
            child_frame_id=child,
            transform=self._type("geometry_msgs/msg/Transform")(
                translation=self._vector(x, y, 0.0), rotation=self._turned(heading)
            ),
        )

    def _numbers(self, values: Array, labels: Iterable[str]) -> Any:
        dimension = self._type("std_msgs/msg/MultiArrayDimension")
        size = len(values)
        layout = self._type("std_msgs/msg/MultiArrayLayout")(
            dim=[dimension(label=", ".join(labels), size=size, stride=size)], data_offset=0
        )
        return self._type("std_msgs/msg/Float64MultiArray")(layout=layout, data=np.ascontiguousarray(values))


def _columns(table: Table, keys: Iterable[str]) -> Iterator[tuple[float, ...]]:
    return zip(*(table[key].tolist() for key in keys), strict=True)
