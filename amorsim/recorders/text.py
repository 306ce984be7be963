"""The run's text files: poses, velocities, readings, estimates, commands and events, as comma-separated values.

Outputs are written to a micrometre and a microradian; commands as the shortest decimals that read back the same.
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

import attrs
import numpy as np
import numpy.typing as npt

from amorsim.contracts import Frame, ObstacleFrame, Recorder, RunInfo
from amorsim.core.poses import logarithm, relative
from amorsim.recorders.files import LineFiles

__all__ = ["Text"]

Array = npt.NDArray[np.float64]

_POSE = "true_x,true_y,true_heading,estimated_x,estimated_y,estimated_heading"
_TWIST = "true_forward,true_left,true_turn,estimated_forward,estimated_left,estimated_turn"
_COVARIANCE = "xx,xy,xh,yy,yh,hh"
_UPPER = np.array([0, 1, 2, 4, 5, 8])  # of a 3 x 3 matrix, row by row
_EVENT = "time,robot,kind,other,x,y,speed,path,value,tick"


@attrs.define(kw_only=True, eq=False)
class Text(Recorder):
    """Writes ``poses.csv``, ``velocities.csv``, ``sensors/``, ``estimates/``, ``commands.csv`` and ``events.csv``.

    And ``obstacles.csv`` if there are any. A `replica` column leads where there are several.
    """

    _files: LineFiles = attrs.field(factory=LineFiles, init=False)
    _previous: list[dict[str, Any]] = attrs.field(factory=list, init=False)
    _joints: list[str] = attrs.field(factory=list, init=False)
    _channels: list[str] = attrs.field(factory=list, init=False)
    _sizes: dict[str, int] = attrs.field(factory=dict, init=False)
    _run: RunInfo | None = attrs.field(default=None, init=False)
    _tells_obstacles: bool = attrs.field(default=False, init=False)
    _decimals: int = attrs.field(default=6, init=False)  # of times

    def open(self, run: RunInfo, frames: Sequence[Frame]) -> None:
        """Make the files and write the first readings."""
        self._run = run
        # Microseconds, but always enough to tell the steps apart.
        self._decimals = max(6, 2 - math.floor(math.log10(run.dt)))
        self._joints = _union(frame.joint_names for frame in frames)
        self._channels = _union(frame.channels for frame in frames)
        rates = [f"{kind}_{joint}" for joint in self._joints for kind in ("true", "measured")]
        self._open("poses", "time,robot," + _POSE)
        self._open("velocities", ",".join(["time,robot", _TWIST, *rates]))
        self._open("commands", ",".join(["time,robot", *self._channels]))
        self._open("events", _EVENT)
        for name in _union(frame.estimates for frame in frames):
            self._open(f"estimates/{name}", f"time,robot,x,y,heading,{_COVARIANCE}")
        if run.with_sensors:
            for name in _union(frame.readings for frame in frames):
                size = max(frame.readings[name][0].shape[1] for frame in frames if name in frame.readings)
                columns = [f"{kind}_{i}" for kind in ("true", "measured") for i in range(size)]
                self._open(f"sensors/{name}", ",".join(["time,stamp,robot", *columns]))
                self._sizes[name] = size
        self._previous = [{} for _ in frames]
        self.write(frames, [])

    def _open(self, name: str, header: str) -> None:
        assert self._run is not None
        path = Path(self._run.folder) / f"{name}.csv"
        path.parent.mkdir(exist_ok=True)
        self._files.add(name, path, ("replica," if len(self._run.replicas) > 1 else "") + header)

    def write(self, frames: Sequence[Frame], events: Sequence[Any]) -> None:
        """Write a line for each robot into each file, and one for each event and each sample that arrived."""
        for frame, previous in zip(frames, self._previous, strict=True):
            self._write_frame(frame, previous)
        if events:
            self._files.write("events", "".join(self._event(event) for event in events))

    def write_obstacles(self, frames: Sequence[ObstacleFrame]) -> None:
        """Write a line for each obstacle that moves; at the start, for the others too."""
        if not frames or self._run is None:
            return
        is_first = not self._tells_obstacles
        if is_first:
            self._tells_obstacles = True
            self._open("obstacles", "time,obstacle,x,y,heading")
        for frame in frames:
            if frame.moves or is_first:
                self._lines("obstacles", self._leads(frame), frame.true_pose)

    def _leads(self, frame: Frame | ObstacleFrame) -> list[str]:
        """How the lines of a frame begin: with the replica where there are several, the time and the name."""
        time = [f"{t:.{self._decimals}f}" for t in frame.time.tolist()]
        if self._run is not None and len(self._run.replicas) > 1:
            time = [f"{number},{t}" for number, t in zip(frame.replica.tolist(), time, strict=True)]
        return [f"{t},{name}" for t, name in zip(time, frame.names, strict=True)]

    def _write_frame(self, frame: Frame, previous: dict[str, Any]) -> None:
        rows = range(len(frame.names))
        replica = [""] * len(rows)
        if self._run is not None and len(self._run.replicas) > 1:
            replica = [f"{number}," for number in frame.replica.tolist()]
        time = [f"{t:.{self._decimals}f}" for t in frame.time.tolist()]
        lead = self._leads(frame)
        estimate = next(iter(frame.estimates.values()))
        self._lines("poses", lead, np.concatenate((frame.true_pose, estimate.pose), axis=1))
        self._lines("velocities", lead, self._velocities(frame, estimate.pose, previous))
        self._files.write("commands", self._commands(frame, lead))
        for name, held in frame.estimates.items():
            flat = held.covariance.reshape(len(rows), 9)[:, _UPPER]
            lines = (
                f"{lead[i]},{_fixed(pose)},{','.join(map(repr, spread))}\n"
                for i, pose, spread in zip(rows, held.pose.tolist(), flat.tolist(), strict=True)
            )
            self._files.write(f"estimates/{name}", "".join(lines))
        if self._run is not None and self._run.with_sensors:
            for name, (true, reading) in frame.readings.items():
                fresh = np.flatnonzero(reading.fresh[:, 0]).tolist()
                if not fresh:
                    continue
                stamp = [f"{tick * self._run.dt:.{self._decimals}f}" for tick in reading.stamp[:, 0].tolist()]
                leads = [f"{replica[i]}{time[i]},{stamp[i]},{frame.names[i]}" for i in fresh]
                missing = np.full((len(fresh), self._sizes[name] - true.shape[1]), np.nan)
                parts = (true[fresh], missing, reading.measured[fresh], missing)
                self._lines(f"sensors/{name}", leads, np.concatenate(parts, axis=1))

    def _lines(self, file: str, lead: Sequence[str], values: Array) -> None:
        text = "".join(f"{start},{_fixed(row)}\n" for start, row in zip(lead, values.tolist(), strict=True))
        self._files.write(file, text)

    def _velocities(self, frame: Frame, estimated: Array, previous: dict[str, Any]) -> Array:
        """Velocities of body and joints, true beside estimated or measured; nan where nothing was measured yet."""
        assert self._run is not None
        rows = len(frame.names)
        before = previous.get("pose", estimated)
        previous["pose"] = estimated
        twist = logarithm(relative(before, estimated)) / self._run.dt
        rates = np.full((rows, 2 * len(self._joints)), np.nan)
        measured = self._measured_rates(frame, previous)
        for position, joint in enumerate(frame.joint_names):
            column = 2 * self._joints.index(joint)
            rates[:, column] = frame.joint_rates[:, position]
            if measured is not None:
                rates[:, column + 1] = measured[:, position]
        return np.concatenate((frame.true_twist, twist, rates), axis=1)

    def _measured_rates(self, frame: Frame, previous: dict[str, Any]) -> Array | None:
        """Joint rates [rad/s] from the newest two samples of the first sensor that tells joints' angles."""
        assert self._run is not None
        for name, model in frame.robot.sensors.items():
            if not hasattr(model.sensor, "angles"):
                continue
            reading = frame.readings[name][1]
            angles, stamp = model.sensor.angles(reading.measured), reading.stamp
            if angles.shape[1] != len(frame.joint_names):
                continue
            last_angles, last_stamp, rates = previous.get("angles", (angles, stamp, np.zeros_like(angles)))
            elapsed = (stamp - last_stamp) * self._run.dt
            with np.errstate(divide="ignore", invalid="ignore"):
                rates = np.where(elapsed > 0, (angles - last_angles) / elapsed, rates)
            previous["angles"] = (angles, stamp, rates)
            return np.asarray(rates)
        return None

    def _commands(self, frame: Frame, lead: Sequence[str]) -> str:
        columns = [self._channels.index(name) for name in frame.channels]
        lines = []
        for start, row in zip(lead, frame.command.tolist(), strict=True):
            cells = [""] * len(self._channels)
            for column, value in zip(columns, row, strict=True):
                cells[column] = repr(value)
            lines.append(f"{start},{','.join(cells)}\n")
        return "".join(lines)

    def _event(self, event: Any) -> str:
        assert self._run is not None
        replica = f"{event.replica}," if len(self._run.replicas) > 1 else ""
        x, y = ("", "") if event.point is None else (f"{part:.6f}" for part in event.point)
        speed = "" if event.speed is None else f"{event.speed:.6f}"
        value = _quoted(json.dumps(event.value, default=_plain)) if event.path else ""
        time = f"{event.time:.{self._decimals}f}"
        cells = [time, event.name, event.kind, event.other, x, y, speed, event.path, value, event.tick]
        return replica + ",".join(map(str, cells)) + "\n"

    def close(self) -> None:
        """Close the files, whatever happened before."""
        self._files.close()


def _fixed(values: Iterable[float]) -> str:
    return ",".join([f"{value:.6f}" for value in values])


def _plain(value: Any) -> Any:
    """What JSON can say of a value that it does not know: the fields of a `Deviation` or a `Distribution`."""
    return attrs.asdict(value, recurse=False) if attrs.has(type(value)) else str(value)


def _quoted(text: str) -> str:
    return '"' + text.replace('"', '""') + '"' if "," in text or '"' in text else text


def _union(names: Iterable[Iterable[str]]) -> list[str]:
    return list(dict.fromkeys(name for group in names for name in group))
