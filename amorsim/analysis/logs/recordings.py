"""Trajectories and logs from recordings: rosbags and MCAP files, and the folders of runs."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Callable, Iterable, Iterator, Mapping
from pathlib import Path
from types import SimpleNamespace
from typing import Any, NamedTuple

import numpy as np

from amorsim.analysis.logs.carmen import SUFFIXES, entries_of_carmen
from amorsim.analysis.logs.message_shapes import check_message
from amorsim.analysis.logs.message_values import (
    SCANS,
    beams_of,
    command_of,
    holds_pose,
    plane_pose,
    pose_of,
    reading_of,
)
from amorsim.analysis.logs.odometry_counts import OdometryCounts
from amorsim.analysis.logs.run_log import LogEntry, entries_of_run
from amorsim.analysis.trajectory import Trajectory
from amorsim.array_types import Array
from amorsim.core.arguments import check_kind, path_of
from amorsim.core.errors import AmorsimError, AnalysisError, did_you_mean
from amorsim.core.files.json_files import parse_json
from amorsim.core.files.reading import is_file, is_folder
from amorsim.core.unknown_names import no_such
from amorsim.runs.folder import ABOUT
from amorsim.scenario.spec import Robot
from amorsim.sensors.encoder import Encoder

__all__ = ["is_carmen", "messages_of", "read_bag", "read_log", "read_mcap"]


class _Received(NamedTuple):
    """A message: when it was received [ns], its topic, the name of its type, and its content."""

    time: int
    topic: str
    kind: str
    content: Any


Topics = dict[str, str]  # the type of each topic
Wanted = Callable[[Topics], Iterable[str]]


RECORDING = "the path of a recording"


def read_bag(path: str | os.PathLike[str], topic: str | None = None, *, frame: str | None = None) -> Trajectory:
    """A trajectory in a rosbag, projected to the plane z = 0: the poses on a topic, at their stamps.

    Topics of ``nav_msgs/Odometry``, ``PoseStamped``, ``PoseWithCovarianceStamped``, ``TransformStamped`` and
    ``tf2_msgs/TFMessage`` have poses. It needs no ROS, but the extra ``rosbag``.

    Parameters
    ----------
    path
        The folder of a rosbag2, or the file of a rosbag of ROS 1.
    topic
        Such as ``"/odom"``; a recording with a single topic of poses needs none.
    frame
        Of transforms, those into this child frame; without it, the first of each message.

    Raises
    ------
    AnalysisError
        If the library is missing, the recording cannot be read, or there is no such topic.
    """
    return _trajectory(path_of(path, "path", RECORDING), _bag, topic, frame)


def read_mcap(path: str | os.PathLike[str], topic: str | None = None, *, frame: str | None = None) -> Trajectory:
    """A trajectory in an MCAP file with Foxglove's schemas as JSON: ``PoseInFrame`` or ``FrameTransform``.

    An MCAP file of ROS 2 is read by `read_bag`. Parameters and errors are those of `read_bag`; it needs the extra
    ``mcap``.
    """
    return _trajectory(path_of(path, "path", RECORDING), _mcap, topic, frame)


def read_log(
    path: str | os.PathLike[str],
    robot: Robot,
    *,
    topics: Mapping[str, str] | None = None,
    command: str | None = None,
    replica: int | None = None,
    damaged: Callable[[str], None] | None = None,
    as_measured: bool = False,
) -> Iterator[LogEntry]:
    """The readings that a robot received: from a run's folder, a rosbag, an MCAP file or a log of CARMEN.

    They are for an `EstimatorRunner`: ``runner.update(*entry)`` takes an entry. There is one for each time at which a
    reading or a command arrived.

    Parameters
    ----------
    path
        The folder of a run; a rosbag; a file whose name ends in ``.mcap``, of ROS 2 or as `export_run` writes it; or a
        log of CARMEN, whose name ends in ``.log``, ``.clf`` or ``.gfs``, and perhaps ``.gz`` after that.
    robot
        Whose sensors and drive give the readings' meaning. Of a log of CARMEN, odometry becomes counts of its encoder,
        and scans are those of its laser.
    topics
        By sensor, the topic of its readings, as ``{"laser": "/scan"}``. Without it, each sensor's is
        ``/ROBOT/SENSOR``, as in exported runs; if no topic begins with ``/ROBOT/``, the only one of scans is the
        laser's, and the only one of odometry, or else of joints, the encoder's. Sensors without a topic are left out,
        and if none has one, that is an error.
    command
        The topic of commands, such as ``"/cmd_vel"``; without it, ``/ROBOT/command``, if it is there. A twist becomes
        the command that the nominal drive needs for it.
    replica
        Of a run's folder; a run of one replica needs none. The folder has no topics.
    damaged
        Of a log of CARMEN: called with a message for each damaged line, which is left out. Without it, the first one is
        an error.
    as_measured
        Of a recording: whether times are those at which readings were measured, by their headers, instead of those at
        which they arrived. Then no reading is old, and all messages are read at once.

    Raises
    ------
    AnalysisError
        If a library is missing, the recording cannot be read, there is no such topic, messages on it are of another
        kind, or the run has not written its readings.
    RunError
        If a file of the run's folder is damaged, or the run has no such robot or replica.
    """
    path = path_of(path, "path", RECORDING)
    check_kind(robot, Robot, "robot", "a Robot, as am.load('demo').robots[0]")
    if is_file(path / ABOUT):
        if topics is not None or command is not None:
            raise AnalysisError(f"{path}: the folder of a run has no topics; leave out topics and command")
        return entries_of_run(path, robot, replica)
    if is_carmen(path):
        if topics is not None or command is not None or replica is not None:
            raise AnalysisError(f"{path}: a log of CARMEN has no topics and no replicas; leave them out")
        return entries_of_carmen(path, robot, damaged)
    if replica is not None:
        raise AnalysisError(f"{path}: is not the folder of a run, and a recording has no replicas; leave out replica")
    for name in topics or {}:
        if name not in robot.sensors:
            raise AnalysisError(f"topics: {no_such('sensor', name, robot.sensors, whose=f'robot {robot.name!r}')}")
    given = {topic: name for name, topic in (topics or {}).items()}
    own = given if topics is not None else {f"/{robot.name}/{name}": name for name in robot.sensors}
    orders = f"/{robot.name}/command" if command is None else command
    needed = [*given, *([] if command is None else [command])]

    def wanted(there: Topics) -> list[str]:
        for topic in needed:
            if topic not in there:
                raise _no_topic(path, topic, there)
        expected = list(own)
        if topics is None and not any(topic.startswith(f"/{robot.name}/") for topic in there):
            own.clear()
            own.update(_by_kind(path, robot, there))
        found = [topic for topic in (*own, orders) if topic in there]
        if not found or (expected and found == [orders]):
            raise AnalysisError(
                f"{path}: there is none of the topics {', '.join(expected)}; say which topic has the readings of which "
                f"sensor with topics=, as {{'laser': '/scan'}}. It has: {_listed(there)}"
            )
        return found

    messages = messages_of(path, wanted)
    return _entries(path, _as_measured(messages) if as_measured else messages, robot, own, orders)


def _by_kind(path: Path, robot: Robot, there: Topics) -> dict[str, str]:
    """The sensor of the only topic of scans, and that of the only one of odometry or else of joints."""
    scanners = [name for name, one in robot.sensors.items() if beams_of(one.sensor) is not None]
    encoders = [name for name, one in robot.sensors.items() if isinstance(one.sensor, Encoder)]
    found: dict[str, str] = {}
    for sensors, kinds in ((scanners, (SCANS,)), (encoders, (("nav_msgs/Odometry",), ("sensor_msgs/JointState",)))):
        fits = ([topic for topic, kind in there.items() if kind in one] for one in kinds)
        fit = next((topics for topics in fits if topics), [])
        if len(fit) > 1 or (fit and len(sensors) > 1):
            raise AnalysisError(
                f"{path}: several topics or sensors are alike: topics {', '.join(sorted(fit))}, sensors "
                f"{', '.join(sensors)}; say which topic has the readings of which sensor with topics=, as "
                f"{{{sensors[0]!r}: {min(fit)!r}}}"
            )
        if fit and sensors:
            found[fit[0]] = sensors[0]
    return found


def is_carmen(path: Path) -> bool:
    """Whether a file is a log of CARMEN, by its name."""
    ends = path.suffixes[:-1] if path.suffix == ".gz" else path.suffixes
    return bool(ends) and ends[-1] in SUFFIXES


def messages_of(path: Path, wanted: Wanted) -> Iterator[_Received]:
    """The messages of a recording on the topics that are wanted of those that are there.

    Raises
    ------
    AnalysisError
        If it cannot be read.
    """
    return _opened(path)(path, wanted)


def _as_measured(messages: Iterator[_Received]) -> Iterator[_Received]:
    """Messages in the order in which they were measured, as if they had arrived at once."""
    measured = (each._replace(time=_stamp(each.content, each.time)) for each in messages)
    return iter(sorted(measured, key=lambda each: each.time))


def _entries(
    path: Path, messages: Iterator[_Received], robot: Robot, sensors: Mapping[str, str], orders: str
) -> Iterator[LogEntry]:
    """The messages of each time together."""
    time: int | None = None
    readings: dict[str, Array] = {}
    ages: dict[str, float] = {}
    held: Array | None = None
    given: Array | None = None
    odometry: dict[str, OdometryCounts] = {}
    for each in messages:
        check_message(each.kind, each.content, f"{path}, {each.topic}")
        if time is not None and each.time != time:
            yield LogEntry(time / 1e9, readings, held, ages)
            readings, ages, held = {}, {}, given
        time = each.time
        if each.topic == orders:
            given = command_of(each.kind, each.content, robot, each.topic)
        else:
            name = sensors[each.topic]
            sensor = robot.sensors[name].sensor
            if each.kind == "nav_msgs/Odometry" and isinstance(sensor, Encoder):
                counts = odometry.setdefault(name, OdometryCounts(robot, sensor, f"{path}, {each.topic}"))
                readings[name] = counts.at(np.array(plane_pose(each.content.pose.pose)))
            else:
                readings[name] = reading_of(each.kind, each.content, sensor, robot, each.topic)
            ages[name] = max(0.0, (time - _stamp(each.content, time)) / 1e9)
    if time is not None:
        yield LogEntry(time / 1e9, readings, held, ages)


def _trajectory(
    path: Path, messages: Callable[[Path, Wanted], Iterator[_Received]], topic: str | None, frame: str | None
) -> Trajectory:
    _check_recording(path)
    times: list[float] = []
    poses: list[tuple[float, float, float]] = []
    chosen = topic

    def wanted(there: Topics) -> list[str]:
        nonlocal chosen
        chosen = _topic_of_poses(path, topic, there)
        return [chosen]

    for each in messages(path, wanted):
        check_message(each.kind, each.content, f"{path}, {each.topic}")
        found = pose_of(each.kind, each.content, frame)
        if found is not None:
            stamped, pose = found
            times.append(_stamp(stamped, each.time) / 1e9)
            poses.append(pose)
    if not poses:
        of = "" if frame is None else f" into the frame {frame!r}"
        raise AnalysisError(f"{path}: there are no poses{of} on the topic {chosen}")
    return Trajectory(time=np.array(times), poses=np.array(poses), name=f"{path} ({chosen})")


def _topic_of_poses(path: Path, topic: str | None, there: Topics) -> str:
    fit = {name: kind for name, kind in there.items() if holds_pose(kind)}
    if topic is None:
        if len(fit) != 1:
            which = "several topics have poses; say which with topic=" if fit else "no topic has poses"
            raise AnalysisError(f"{path}: {which}. It has: {_listed(fit or there)}")
        return next(iter(fit))
    if topic not in there:
        raise _no_topic(path, topic, there)
    if topic not in fit:
        raise AnalysisError(f"{path}: messages on {topic}, {there[topic]}, have no pose. Topics with: {_listed(fit)}")
    return topic


def _no_topic(path: Path, topic: str, there: Topics) -> AnalysisError:
    return AnalysisError(f"{path}: there is no topic {topic!r}; it has: {_listed(there)}.{did_you_mean(topic, there)}")


def _listed(topics: Topics) -> str:
    return ", ".join(f"{name} ({kind})" for name, kind in sorted(topics.items())) or "none"


def _stamp(content: Any, received: int) -> int:
    """When a message was measured [ns]; when it was received if it has no such time."""
    header = getattr(content, "header", None)
    stamp = getattr(content, "timestamp", None) if header is None else header.stamp
    if stamp is None:
        return received
    time = int(stamp.sec) * 10**9 + int(stamp.nsec if header is None else stamp.nanosec)
    # A header that was never filled has no time, and names no frame.
    return received if header is not None and time == 0 and not header.frame_id else time


# ------------------------------------------------------------------------------------------------------------- formats


def _check_recording(path: Path, folders: str = "that of a rosbag, with metadata.yaml") -> None:
    """Raise `AnalysisError` where there is nothing that could be a recording; `folders` are right, for a message."""
    if is_folder(path):
        if not is_file(path / "metadata.yaml"):
            raise AnalysisError(f"{path}: a folder without a recording; expected {folders}")
    elif not is_file(path):
        raise AnalysisError(f"{path}: there is no such file or folder")
    elif path.stat().st_size == 0:
        raise AnalysisError(f"{path}: the file is empty")


def _opened(path: Path) -> Callable[[Path, Wanted], Iterator[_Received]]:
    _check_recording(path, f"that of a run, with {ABOUT}, or of a rosbag, with metadata.yaml")
    if path.suffix != ".mcap":
        if is_file(path) and path.suffix not in (".bag", ".db3"):
            raise AnalysisError(
                f"{path}: is not a recording that can be read: expected the folder of a run or of a rosbag, a file "
                "that ends in .bag or .mcap, or a log of CARMEN, which ends in .log, .clf or .gfs, and perhaps .gz "
                "after it"
            )
        return _bag
    with _damage(path):
        reader = _mcap_reader()
        with path.open("rb") as stream:
            summary = reader(stream).get_summary()
            kinds = {} if summary is None else summary.channels
            return _mcap if all(each.message_encoding == "json" for each in kinds.values()) else _bag


@contextlib.contextmanager
def _damage(path: Path) -> Iterator[None]:
    """A block in which errors of a library that reads a file, of many kinds, become an `AnalysisError`."""
    try:
        yield
    except AmorsimError:
        raise
    except Exception as error:
        raise AnalysisError(f"{path}: cannot be read as a recording ({type(error).__name__}: {error})") from None


def _bag(path: Path, wanted: Wanted) -> Iterator[_Received]:
    try:
        from rosbags.highlevel import AnyReader
        from rosbags.typesys import Stores, get_typestore
    except ModuleNotFoundError:
        raise AnalysisError('rosbags need a library: python -m pip install "amorsim[rosbag]"') from None
    with _damage(path), AnyReader([path], default_typestore=get_typestore(Stores.ROS2_HUMBLE)) as reader:
        chosen = set(wanted({each.topic: _kind(each.msgtype) for each in reader.connections}))
        connections = [each for each in reader.connections if each.topic in chosen]
        for connection, time, data in reader.messages(connections) if connections else ():  # of none it reads all
            yield _Received(
                time, connection.topic, _kind(connection.msgtype), reader.deserialize(data, connection.msgtype)
            )


def _kind(name: str) -> str:
    return name.replace("/msg/", "/")


def _mcap_reader() -> Any:
    try:
        from mcap.reader import make_reader
    except ModuleNotFoundError:
        raise AnalysisError('MCAP needs a library: python -m pip install "amorsim[mcap]"') from None
    return make_reader


def _mcap(path: Path, wanted: Wanted) -> Iterator[_Received]:
    make_reader = _mcap_reader()
    with _damage(path), path.open("rb") as stream:
        reader = make_reader(stream)
        summary = reader.get_summary()
        if summary is None:
            raise AnalysisError(f"{path}: has no summary; it was not closed. `mcap recover` may mend it")
        there = {
            channel.topic: summary.schemas[channel.schema_id].name if channel.schema_id else ""
            for channel in summary.channels.values()
            if channel.message_encoding == "json"
        }
        if summary.channels and not there:
            raise AnalysisError(f"{path}: its messages are not JSON; read it with read_bag if it is of ROS 2")
        chosen = list(wanted(there))
        for _, channel, message in reader.iter_messages(topics=chosen) if chosen else ():
            if channel.message_encoding == "json":
                content = parse_json(message.data, lambda table: SimpleNamespace(**table))
                yield _Received(message.log_time, channel.topic, there[channel.topic], content)
