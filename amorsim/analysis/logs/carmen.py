"""Logs of CARMEN: odometry and laser scans of a real robot, a line each.

Read are the messages of CARMEN's log format 1 that hold odometry and scans of the front laser [1]_::

    ODOM x y theta tv rv accel  time host logger_time
    FLASER n range_1 ... range_n  x y theta  odom_x odom_y odom_theta  time host logger_time
    ROBOTLASER1 type start_angle fov resolution range_max accuracy remission_mode n range_1 ... range_n
        m remission_1 ... remission_m  x y theta  odom_x odom_y odom_theta  tv rv forward side turn
        time host logger_time

Lengths are metres, angles radians, times seconds. A scan of FLASER has no angles: its beams are spread over the field
of view of the device, from the right. A pose in a scan is often a corrected one, so odometry is that of ODOM, if there
is any.

Programs that correct logs, such as GMapping's, add ODOM of the corrected pose beside each scan, whose time was never
set: 0, or what lay in the memory. The ODOM after it go on from there. So one whose time is far from those of the lines
around it is not a motion: what follows it is taken relative to it, and what is read is the odometry as it was before
anything was corrected.

Messages come in the order of the lines. Odometry that waited before it was written, with a time before that of the line
before it, gets that time; the times of scans stay, but where two are one. Where lines came all at once they have one
time, so odometry after a scan of its own time was measured after it.

.. [1] M. Montemerlo, N. Roy, S. Thrun, D. Hähnel, C. Stachniss, J. Glover: CARMEN, the Carnegie Mellon robot navigation
   toolkit, 2002; the header of its log files.
"""

from __future__ import annotations

import gzip
import itertools
import math
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
from scipy.ndimage import median_filter

from amorsim.analysis.logs.odometry_counts import OdometryCounts
from amorsim.analysis.logs.run_log import LogEntry
from amorsim.analysis.logs.scan_geometry import ScanGeometry
from amorsim.array_types import Array
from amorsim.contracts import Sensor
from amorsim.core.errors import AnalysisError
from amorsim.core.poses import compose, relative
from amorsim.scenario.spec import Robot
from amorsim.sensors.encoder import Encoder

__all__ = ["SUFFIXES", "CarmenMessage", "carmen_geometry", "entries_of_carmen", "read_carmen"]


SUFFIXES = (".log", ".clf", ".gfs")
"""The ends of such files' names; ``.gz`` may follow."""

_LONGEST_LINE = 1 << 20  # letters
_AROUND = 11  # lines
_FAR = 5.0  # [s]
_TICK = 1e-6  # [s] from a scan to what comes after it, at least: where six digits are written, two can have one time
_ANGLE = math.radians(0.1)  # how far beams may lie from where the robot's laser has them


class CarmenMessage(NamedTuple):
    """Odometry, and perhaps a scan, at one time."""

    kind: str
    """``"ODOM"``, ``"FLASER"`` or ``"ROBOTLASER1"``."""
    time: float
    """[s] when it was measured."""
    odometry: Array
    """(3,) pose [m, m, rad] in the odometry's frame."""
    ranges: Array | None
    """(n,) [m] of a scan, from the right."""
    bearings: Array | None
    """(n,) [rad] of the beams from the laser's axis, if the message has them."""


def read_carmen(path: Path, damaged: Callable[[str], None] | None = None) -> list[CarmenMessage]:
    """The odometry and scans in a log, in the order of its lines; messages of other kinds are left out.

    Parameters
    ----------
    damaged
        Called with a message for each damaged line, which is left out. Without it, the first one is an error.

    Raises
    ------
    AnalysisError
        If the file cannot be read, a line is damaged, there is neither odometry nor a scan, or times go far back.
    """
    found = []
    try:
        with gzip.open(path, "rt", errors="replace") if path.suffix == ".gz" else path.open(errors="replace") as file:
            for number, line in enumerate(iter(lambda: file.readline(_LONGEST_LINE), ""), start=1):
                words = line.split()
                if not words or words[0] not in _READERS:
                    continue
                try:
                    found.append(_READERS[words[0]](words))
                except _DamageError as damage:
                    problem = f"{path}, line {number}: {words[0]}: {damage}"
                    if damaged is None:
                        raise AnalysisError(problem) from None
                    damaged(problem)
    except (OSError, EOFError) as error:
        raise AnalysisError(f"{path}: cannot be read: {getattr(error, 'strerror', None) or error}") from None
    if not found:
        raise AnalysisError(f"{path}: expected a log of CARMEN, with lines of {', '.join(_READERS)}; found none")
    return _in_order(found, path)


def _in_order(messages: Sequence[CarmenMessage], path: Path) -> list[CarmenMessage]:
    """The messages with times that do not decrease, and odometry without jumps to corrected poses."""
    times = np.array([message.time for message in messages])
    is_set = np.abs(times - median_filter(times, size=_AROUND, mode="nearest")) <= _FAR
    is_scan = is_set & np.array([message.ranges is not None for message in messages])
    after = np.minimum.accumulate(np.where(is_scan, times, np.inf)[::-1])[::-1]
    now = np.maximum.accumulate(np.where(is_set, np.where(is_scan, times, np.minimum(times, after)), -np.inf))
    late = is_set & (times < now - _FAR)
    if late.any():
        place = int(np.argmax(late))
        raise AnalysisError(
            f"{path}: {messages[place].kind} of {times[place]:g} s comes after one of {now[place]:g} s; expected a log "
            "in the order of time"
        )
    found: list[CarmenMessage] = []
    here = np.zeros(3)
    before: Array | None = None  # the last line's pose
    last = -math.inf  # [s] of the last message
    last_scan, last_scan_own = -math.inf, math.inf  # as it is given, and as it was written
    for message, own, has_time in zip(messages, now.tolist(), is_set.tolist(), strict=True):
        time = max(own, last)
        if has_time and (message.ranges is not None or message.time >= last_scan_own):
            time = max(time, last_scan + _TICK)
        if has_time and message.ranges is not None:
            last_scan, last_scan_own = time, message.time
        last = time if has_time else last
        if message.kind != "ODOM":
            if has_time:
                found.append(message._replace(time=time))
            continue
        if has_time:
            moved = message.odometry[None] if before is None else relative(before[None], message.odometry[None])
            here = compose(here[None], moved)[0]
            found.append(message._replace(time=time, odometry=here))
        before = message.odometry
    return found


def entries_of_carmen(path: Path, robot: Robot, damaged: Callable[[str], None] | None = None) -> Iterator[LogEntry]:
    """What a robot with an encoder and a laser would have received: one entry for each time of a message.

    Odometry becomes counts of the robot's encoder: those with which its nominal drive would have moved so.

    Raises
    ------
    AnalysisError
        If the log cannot be read, or its scans are not of the robot's laser; or if the robot has no encoder, or a drive
        whose wheels steer.
    """
    messages = read_carmen(path, damaged)
    has_odometry = any(message.kind == "ODOM" for message in messages)
    encoders = {name: one.sensor for name, one in robot.sensors.items() if isinstance(one.sensor, Encoder)}
    scanner = next((name for name, one in robot.sensors.items() if one.sensor.bearings() is not None), None)
    if not encoders:
        raise AnalysisError(
            f"robot {robot.name!r}: a log of CARMEN holds poses by odometry, which become counts of an encoder; the "
            "robot has none"
        )
    encoder = next(iter(encoders))
    wheels = OdometryCounts(robot, encoders[encoder], str(path))
    for time, together in itertools.groupby(messages, lambda message: message.time):
        readings = {}
        for message in together:
            if message.kind == "ODOM" or not has_odometry:
                readings[encoder] = wheels.at(message.odometry)
            if message.ranges is not None and scanner is not None:
                readings[scanner] = _scan(message, robot.sensors[scanner].sensor, f"{path}, at {time:g} s")
        if readings:
            yield LogEntry(time, readings, None, {})


def carmen_geometry(path: Path) -> ScanGeometry | None:
    """The beams of the first scan in a log; None if there is none. FLASER has those of a SICK, over a half circle.

    Raises
    ------
    AnalysisError
        As `read_carmen`, but damaged lines are left out.
    """
    for message in read_carmen(path, lambda _: None):
        if message.ranges is not None:
            beams, bearings = len(message.ranges), message.bearings
            # Of 181 beams the first and the last look to the sides; of 180 the last does not look there yet.
            half_circle = math.pi if beams % 2 else math.pi * (1.0 - 1.0 / beams)
            span = half_circle if bearings is None else float(abs(bearings[-1] - bearings[0]))
            return ScanGeometry(beams, span, None)
    return None


def _scan(message: CarmenMessage, sensor: Sensor, where: str) -> Array:
    """The ranges of a scan as the robot's laser has them: inf for no return."""
    own = np.asarray(sensor.bearings()).reshape(-1)
    assert message.ranges is not None
    if len(own) != len(message.ranges):
        raise AnalysisError(
            f"{where}: a scan of {len(message.ranges)} beams, and the robot's laser has {len(own)}; give it as many, "
            "as laser = { beams = 180, fov_deg = 179.0 }"
        )
    if message.bearings is not None and np.abs(message.bearings - own).max() > _ANGLE:
        low, high = np.degrees(message.bearings[[0, -1]])
        raise AnalysisError(
            f"{where}: its beams go from {low:.2f} to {high:.2f} degrees, and those of the robot's laser from "
            f"{math.degrees(own[0]):.2f} to {math.degrees(own[-1]):.2f}; give it the same field of view"
        )
    range_max = float(np.max(getattr(sensor, "range_max", math.inf)))
    return np.where(message.ranges < range_max, message.ranges, math.inf)


class _DamageError(Exception):
    """The error for a damaged line."""


def _numbers(words: Sequence[str], what: str) -> Array:
    try:
        numbers = np.array([float(word) for word in words])
    except ValueError:
        numbers = np.array([math.nan])
    if not np.isfinite(numbers).all():
        raise _DamageError(f"expected finite numbers for {what}")
    return numbers


def _count(words: Sequence[str], place: int, what: str) -> int:
    if len(words) <= place or not words[place].isdecimal():
        raise _DamageError(f"expected the number of {what}")
    return int(words[place])


def _expect(words: Sequence[str], count: int) -> None:
    if len(words) < count:
        raise _DamageError(f"expected {count} fields, got {len(words)}")


def _odom(words: Sequence[str]) -> CarmenMessage:
    _expect(words, 10)
    pose, time = _numbers(words[1:4], "the pose"), _numbers(words[7:8], "the time")
    return CarmenMessage("ODOM", float(time[0]), pose, None, None)


def _flaser(words: Sequence[str]) -> CarmenMessage:
    count = _count(words, 1, "ranges")
    _expect(words, count + 11)
    ranges, odometry = _numbers(words[2 : 2 + count], "ranges"), _numbers(words[5 + count : 8 + count], "the pose")
    time = _numbers(words[8 + count : 9 + count], "the time")
    return CarmenMessage("FLASER", float(time[0]), odometry, ranges, None)


def _robot_laser(words: Sequence[str]) -> CarmenMessage:
    count = _count(words, 8, "ranges")
    after = 9 + count
    rest = after + 1 + _count(words, after, "remissions")
    _expect(words, rest + 14)
    start, _, resolution = _numbers(words[2:5], "the angles")
    return CarmenMessage(
        "ROBOTLASER1",
        float(_numbers(words[rest + 11 : rest + 12], "the time")[0]),
        _numbers(words[rest + 3 : rest + 6], "the pose"),
        _numbers(words[9:after], "ranges"),
        start + resolution * np.arange(count),
    )


_READERS: dict[str, Callable[[Sequence[str]], CarmenMessage]] = {
    "ODOM": _odom,
    "FLASER": _flaser,
    "ROBOTLASER1": _robot_laser,
}
