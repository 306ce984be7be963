"""The run's text files: poses, velocities, readings, estimates, commands and events, as comma-separated values.

Outputs are written to a micrometre and a microradian; commands as the shortest decimals that read back the same.
"""

from __future__ import annotations

import json
import math
import threading
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import attrs
import numpy as np
import numpy.typing as npt

from amorsim.contracts import Frame, ObstacleFrame, Recorder, RunInfo
from amorsim.core.poses import logarithm, relative
from amorsim.recorders.files import LineFiles
from amorsim.recorders.lines import EXACT, NAME, NOTHING, as_lines
from amorsim.recorders.steps import Steps

__all__ = ["Text"]

Array = npt.NDArray[np.float64]

_POSE = "true_x,true_y,true_heading,estimated_x,estimated_y,estimated_heading"
_TWIST = "true_forward,true_left,true_turn,estimated_forward,estimated_left,estimated_turn"
_COVARIANCE = "xx,xy,xh,yy,yh,hh"
_UPPER = np.array([0, 1, 2, 4, 5, 8])  # of a 3 x 3 matrix, row by row
_OUTPUT = 6  # decimals
_EVENT = "time,robot,kind,other,x,y,speed,path,value,tick"


class Table(NamedTuple):
    """Lines of a file to be: values (n, k), the kinds of their columns, and the step (n,) that each is of."""

    values: Array
    kinds: Sequence[int]
    steps: npt.NDArray[np.int64]


@attrs.define(kw_only=True, eq=False)
class Text(Recorder):
    """Writes ``poses.csv``, ``velocities.csv``, ``sensors/``, ``estimates/``, ``commands.csv`` and ``events.csv``.

    And ``obstacles.csv`` and ``parts.csv`` if there are any. A `replica` column leads where there are several. Steps
    are kept as numbers and made into lines many at a time, by whoever comes first: a step for which there is no more
    room, or the thread that sees to it that lines reach the files in time.
    """

    _files: LineFiles = attrs.field(init=False)
    _steps: list[Steps] = attrs.field(factory=list, init=False)  # of each group
    _obstacles: list[Steps] | None = attrs.field(default=None, init=False)  # of each group that moves
    _parts: dict[int, Steps] = attrs.field(factory=dict, init=False)  # of each group whose robots have parts
    _previous: list[dict[str, Array]] = attrs.field(factory=list, init=False)
    _joints: list[str] = attrs.field(factory=list, init=False)
    _channels: list[str] = attrs.field(factory=list, init=False)
    _sizes: dict[str, int] = attrs.field(factory=dict, init=False)
    _run: RunInfo | None = attrs.field(default=None, init=False)
    _decimals: int = attrs.field(default=6, init=False)  # of times
    _lock: Any = attrs.field(factory=threading.Lock, init=False)  # over the steps

    def __attrs_post_init__(self) -> None:
        self._files = LineFiles(self._hand_over)

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
        if any(frame.parts for frame in frames):
            self._open("parts", "time,part,x,y,heading")
        self._previous = [{} for _ in frames]
        with self._lock:
            self._steps = [Steps(frame) for frame in frames]
            self._parts = {place: Steps(_part_frame(frame)) for place, frame in enumerate(frames) if frame.parts}
        self.write(frames, [])

    def _open(self, name: str, header: str) -> None:
        assert self._run is not None
        path = Path(self._run.folder) / f"{name}.csv"
        path.parent.mkdir(exist_ok=True)
        self._files.add(name, path, ("replica," if len(self._run.replicas) > 1 else "") + header)

    def write(self, frames: Sequence[Frame], events: Sequence[Any]) -> None:
        """Write a line for each robot into each file, and one for each event and each sample that arrived."""
        self._files.check()
        with self._lock:
            is_full = False
            for frame, steps in zip(frames, self._steps, strict=True):
                is_full |= steps.add(frame)
            for place, steps in self._parts.items():
                is_full |= steps.add(_part_frame(frames[place]))
            if is_full:
                self._write_steps()
        if events:
            self._files.write("events", "".join(self._event(event) for event in events))

    def write_obstacles(self, frames: Sequence[ObstacleFrame]) -> None:
        """Write a line for each obstacle that moves; at the start, for the others too."""
        if not frames or self._run is None:
            return
        if self._obstacles is None:
            self._open("obstacles", "time,obstacle,x,y,heading")
            first = [Steps(frame) for frame in frames]
            for frame, steps in zip(frames, first, strict=True):
                steps.add(frame)
            self._write_tables("obstacles", [(steps, self._poses_of(steps)) for steps in first])
            with self._lock:
                self._obstacles = [Steps(frame) for frame in frames if frame.moves]
            return
        moving = [frame for frame in frames if frame.moves]
        with self._lock:
            is_full = False
            for frame, steps in zip(moving, self._obstacles, strict=True):
                is_full |= steps.add(frame)
            if is_full:
                self._write_steps()

    def _hand_over(self) -> None:
        with self._lock:
            self._write_steps()

    def _write_steps(self) -> None:
        """Make lines of the steps that are kept, and forget them."""
        tables: dict[str, list[tuple[Steps, Table]]] = {}
        for steps, previous in zip(self._steps, self._previous, strict=True):
            if steps.count:
                for name, table in self._tables(steps, previous).items():
                    tables.setdefault(name, []).append((steps, table))
        for name, bodies in (("obstacles", self._obstacles or ()), ("parts", self._parts.values())):
            for steps in bodies:
                if steps.count:
                    tables.setdefault(name, []).append((steps, self._poses_of(steps)))
        for name, parts in tables.items():
            self._write_tables(name, parts)
        for steps in (*self._steps, *(self._obstacles or ()), *self._parts.values()):
            steps.count = 0

    def _write_tables(self, name: str, parts: Sequence[tuple[Steps, Table]]) -> None:
        made = [as_lines(table.values, table.kinds, steps.names) for steps, table in parts]
        if len(made) == 1:
            self._files.write(name, made[0].data)
            return
        # The groups take turns, step by step.
        count = max(steps.count for steps, _ in parts)
        bounds = [_bounds(lines.ends, table.steps, count) for lines, (_, table) in zip(made, parts, strict=True)]
        pieces = [
            lines.data[bound[step] : bound[step + 1]]
            for step in range(count)
            for lines, bound in zip(made, bounds, strict=True)
        ]
        self._files.write(name, b"".join(pieces))

    def _table(self, steps: Steps, kinds: Sequence[int] | None, *parts: Array) -> Table:
        """Lines that begin with the replica where there are several, the time, and the name."""
        return self._table_of(steps, slice(None), None, kinds, *parts)

    def _table_of(
        self, steps: Steps, which: Any, stamp: Array | None, kinds: Sequence[int] | None, *parts: Array
    ) -> Table:
        """The same of some of the lines, with the stamp (n,) [s] of a sample after the time if it has one."""
        assert self._run is not None
        rows, count = len(steps.first.names), steps.count
        times = [steps["time"].reshape(-1)[which]] + ([] if stamp is None else [stamp])
        numbered = len(self._run.replicas) > 1
        replica = [np.tile(steps.first.replica.astype(np.float64), count)[which]] if numbered else []
        row = np.tile(np.arange(rows, dtype=np.float64), count)[which]
        values = np.concatenate((np.column_stack([*replica, *times, row]), *parts), axis=1)
        lead = [0] * numbered + [self._decimals] * len(times) + [NAME]
        kinds = [_OUTPUT] * (values.shape[1] - len(lead)) if kinds is None else kinds
        return Table(values, [*lead, *kinds], np.repeat(np.arange(count), rows)[which])

    def _poses_of(self, steps: Steps) -> Table:
        return self._table(steps, None, steps["true_pose"].reshape(-1, 3))

    def _tables(self, steps: Steps, previous: dict[str, Array]) -> dict[str, Table]:
        """What goes into each file, of one group."""
        assert self._run is not None
        frame = steps.robots
        poses = {name: steps[f"pose {name}"].reshape(-1, 3) for name in frame.estimates}
        estimated = next(iter(poses.values()))
        made = {
            "poses": self._table(steps, None, steps["true_pose"].reshape(-1, 3), estimated),
            "velocities": self._table(steps, None, self._velocities(steps, estimated, previous)),
            "commands": self._commands(steps),
        }
        for name, pose in poses.items():
            spread = steps[f"covariance {name}"].reshape(-1, 9)[:, _UPPER]
            made[f"estimates/{name}"] = self._table(steps, [_OUTPUT] * 3 + [EXACT] * 6, pose, spread)
        if self._run.with_sensors:
            for name, (true, _) in frame.readings.items():
                fresh = np.flatnonzero(steps[f"fresh {name}"])
                if not len(fresh):
                    continue
                size = true.shape[1]
                stamp = steps[f"stamp {name}"].reshape(-1)[fresh] * self._run.dt
                parts = [steps[f"{what} {name}"].reshape(-1, size)[fresh] for what in ("true", "measured")]
                if self._sizes[name] > size:
                    missing = np.full((len(fresh), self._sizes[name] - size), np.nan)
                    parts = [parts[0], missing, parts[1], missing]
                made[f"sensors/{name}"] = self._table_of(steps, fresh, stamp, None, *parts)
        return made

    def _velocities(self, steps: Steps, estimated: Array, previous: dict[str, Array]) -> Array:
        """Velocities of body and joints, true beside estimated or measured; nan where nothing was measured yet."""
        assert self._run is not None
        frame, rows = steps.robots, len(steps.robots.names)
        before = np.concatenate((previous.get("pose", estimated[:rows]), estimated[:-rows]))
        previous["pose"] = estimated[-rows:].copy()
        twist = logarithm(relative(before, estimated)) / self._run.dt
        rates = np.full((len(estimated), 2 * len(self._joints)), np.nan)
        measured = self._measured_rates(steps, previous)
        joint_rates = steps["joint_rates"].reshape(len(estimated), -1)
        for position, joint in enumerate(frame.joint_names):
            column = 2 * self._joints.index(joint)
            rates[:, column] = joint_rates[:, position]
            if measured is not None:
                rates[:, column + 1] = measured[:, position]
        return np.concatenate((steps["true_twist"].reshape(-1, 3), twist, rates), axis=1)

    def _measured_rates(self, steps: Steps, previous: dict[str, Array]) -> Array | None:
        """Joint rates [rad/s] from the newest two samples of the first sensor that tells joints' angles."""
        assert self._run is not None
        frame = steps.robots
        for name, model in frame.robot.sensors.items():
            if not hasattr(model.sensor, "angles"):
                continue
            measured, stamps = steps[f"measured {name}"], steps[f"stamp {name}"]
            if len(frame.names) == 1:
                angles = model.sensor.angles(measured[:, 0])[:, None]
            else:
                angles = np.stack([model.sensor.angles(values) for values in measured])
            if angles.shape[2] != len(frame.joint_names):
                continue
            last_angles = previous.get("angles", angles[0])
            last_stamp = previous.get("stamp", stamps[0])
            rates = previous.get("rates", np.zeros_like(angles[0]))
            elapsed = np.diff(stamps, axis=0, prepend=last_stamp[None]) * self._run.dt
            with np.errstate(divide="ignore", invalid="ignore"):
                all_rates = np.diff(angles, axis=0, prepend=last_angles[None]) / elapsed
            # Between samples the last rates hold.
            held = np.where(elapsed > 0, np.arange(1, steps.count + 1)[:, None, None], 0)
            held = np.maximum.accumulate(held, axis=0)
            all_rates = np.take_along_axis(np.concatenate((rates[None], all_rates)), held, axis=0)
            previous.update(angles=angles[-1].copy(), stamp=stamps[-1].copy(), rates=all_rates[-1].copy())
            return all_rates.reshape(-1, angles.shape[2])
        return None

    def _commands(self, steps: Steps) -> Table:
        columns = [self._channels.index(name) for name in steps.robots.channels]
        command = steps["command"]
        values = np.zeros((command.shape[0] * command.shape[1], len(self._channels)))
        values[:, columns] = command.reshape(len(values), -1)
        kinds = [NOTHING] * len(self._channels)
        for column in columns:
            kinds[column] = EXACT
        return self._table(steps, kinds, values)

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


def _part_frame(frame: Frame) -> ObstacleFrame:
    """The parts of a group's robots, one after another, as bodies of their own."""
    each = len(frame.parts)
    return ObstacleFrame(
        names=[f"{name}.{part}" for name in frame.names for part in frame.parts],
        replica=np.repeat(frame.replica, each),
        tick=np.repeat(frame.tick, each),
        time=np.repeat(frame.time, each),
        true_pose=frame.part_pose.reshape(-1, 3),
        true_twist=np.zeros((len(frame.names) * each, 3)),
        moves=True,
    )


def _bounds(ends: npt.NDArray[np.int64], steps: npt.NDArray[np.int64], count: int) -> list[int]:
    """Where the lines of each of `count` steps begin, and where the last ones end, from each line's end and step."""
    whole = np.concatenate(([0], ends))
    found: list[int] = whole[np.searchsorted(steps, np.arange(count + 1))].tolist()
    return found


def _plain(value: Any) -> Any:
    """What JSON can say of a value that it does not know: the fields of a `Deviation` or a `Distribution`."""
    return attrs.asdict(value, recurse=False) if attrs.has(type(value)) else str(value)


def _quoted(text: str) -> str:
    return '"' + text.replace('"', '""') + '"' if "," in text or '"' in text else text


def _union(names: Iterable[Iterable[str]]) -> list[str]:
    return list(dict.fromkeys(name for group in names for name in group))
