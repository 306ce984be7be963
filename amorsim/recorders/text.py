"""The run's text files: poses, velocities, readings, estimates, commands and events, as comma-separated values.

Outputs are written to a micrometre and a microradian; commands as the shortest decimals that read back the same.
"""

from __future__ import annotations

import json
import math
import threading
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import attrs
import numpy as np

from amorsim.array_types import Array, Ints
from amorsim.contracts import Frame, ObstacleFrame, Recorder, RunInfo
from amorsim.core.errors import RunError
from amorsim.core.poses import logarithm, relative
from amorsim.recorders.line_files import LineFiles
from amorsim.recorders.line_printer import EXACT, MISSING, NAME, NOTHING, Columns, Printer, Span
from amorsim.recorders.steps import BodySteps, RobotSteps, Steps, small_beliefs

__all__ = ["Text"]


_POSE = "true_x,true_y,true_heading,estimated_x,estimated_y,estimated_heading"
_TWIST = "true_forward,true_left,true_turn,estimated_forward,estimated_left,estimated_turn"
_COVARIANCE = "xx,xy,xh,yy,yh,hh"
_UPPER = ((0, 3), (4, 2), (8, 1))  # upper triangle of a 3 x 3 matrix, row by row: start, and count
_OUTPUT = 6  # decimals
_EVENT = "time,robot,kind,other,x,y,speed,path,value,tick"


class Page(NamedTuple):
    """Lines to be written to a file for one group: their steps and rows, and their columns."""

    steps: Steps
    lines: Ints  # (n,), step * rows + row
    columns: Columns


@attrs.define(eq=False)
class Group:
    """The kept steps of one group of robots, the columns of each file, and the last values before the next steps."""

    steps: RobotSteps
    columns: dict[str, Columns]
    previous: dict[str, Array]


@attrs.define(kw_only=True, eq=False)
class Text(Recorder):
    """Writes ``poses.csv``, ``velocities.csv``, ``sensors/``, ``estimates/``, ``commands.csv`` and ``events.csv``.

    And ``beliefs/``, ``obstacles.csv`` and ``parts.csv`` if there are any. With several replicas the first column is
    `replica`. Steps are kept as numbers and made into lines many at a time: by a step for which there is no more room,
    or by the thread that brings lines to the files in time.
    """

    _files: LineFiles = attrs.field(init=False)
    _groups: list[Group] = attrs.field(factory=list, init=False)
    _obstacles: list[BodySteps] | None = attrs.field(default=None, init=False)  # of each group that moves
    _parts: dict[int, BodySteps] = attrs.field(factory=dict, init=False)  # of each group whose robots have parts
    _todo: list[tuple[str, list[Page]]] = attrs.field(factory=list, init=False)  # lines of files waiting to be written
    _printer: Printer = attrs.field(factory=Printer, init=False)
    _joints: list[str] = attrs.field(factory=list, init=False)
    _channels: list[str] = attrs.field(factory=list, init=False)
    _sizes: dict[str, int] = attrs.field(factory=dict, init=False)
    _beliefs: dict[str, list[str]] = attrs.field(factory=dict, init=False)  # columns of each estimator's
    _run: RunInfo | None = attrs.field(default=None, init=False)
    _has_parts: bool = attrs.field(default=False, init=False)  # whether any robot has
    _decimals: int = attrs.field(default=6, init=False)  # of times
    _lock: Any = attrs.field(factory=threading.Lock, init=False)  # over the steps

    def __attrs_post_init__(self) -> None:
        self._files = LineFiles(self._hand_over)

    def open(self, run: RunInfo, frames: Sequence[Frame]) -> None:
        """Make the files and write the first readings."""
        self._run = run
        # Microseconds, or more decimals where steps need them to differ.
        self._decimals = max(6, 2 - math.floor(math.log10(run.dt)))
        self._joints = _union(frame.joint_names for frame in frames)
        self._channels = _union(frame.channels for frame in frames)
        rates = [f"{kind}_{joint}" for joint in self._joints for kind in ("true", "measured")]
        self._open("poses", "time,robot," + _POSE)
        self._open("velocities", ",".join(["time,robot", _TWIST, *rates]))
        self._open("commands", ",".join(["time,robot", *self._channels]))
        self._has_parts = any(frame.parts for frame in frames)
        self._open("events", _EVENT + ",part,other_part" * self._has_parts)
        for name in _union(frame.estimates for frame in frames):
            self._open(f"estimates/{name}", f"time,robot,x,y,heading,{_COVARIANCE}")
        if run.with_sensors:
            for name in _union(frame.readings for frame in frames):
                size = max(frame.readings[name][0].shape[1] for frame in frames if name in frame.readings)
                columns = [f"{kind}_{i}" for kind in ("true", "measured") for i in range(size)]
                self._open(f"sensors/{name}", ",".join(["time,stamp,robot", *columns]))
                self._sizes[name] = size
            found = [small_beliefs(frame) for frame in frames]
            for name in _union(found):
                self._beliefs[name] = _union(_belief_columns(beliefs.get(name, {})) for beliefs in found)
                self._open(f"beliefs/{name}", ",".join(["time,robot", *self._beliefs[name]]))
        if self._has_parts:
            self._open("parts", "time,part,x,y,heading")
        with self._lock:
            for frame in frames:
                steps = RobotSteps(frame, run.with_sensors)
                self._groups.append(Group(steps, self._columns(steps), {}))
            self._parts = {
                place: BodySteps(
                    [f"{name}.{part}" for name in frame.names for part in frame.parts],
                    np.repeat(frame.replica, len(frame.parts)),
                )
                for place, frame in enumerate(frames)
                if frame.parts
            }
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
            if self._todo:  # an interrupt broke off their writing
                self._write_steps()
            is_full = False
            for group, frame in zip(self._groups, frames, strict=True):
                is_full |= group.steps.add(frame)
            for place, steps in self._parts.items():
                time = np.repeat(frames[place].time, len(frames[place].parts))
                is_full |= steps.add(time, frames[place].part_pose)
            if is_full:
                self._write_steps()
        if events:
            self._files.write("events", "".join(self._event(event) for event in events))

    def write_obstacles(self, frames: Sequence[ObstacleFrame]) -> None:
        """Write a line for each obstacle that moves, at the start also for the others."""
        if not frames or self._run is None:
            return
        if self._obstacles is None:
            self._open("obstacles", "time,obstacle,x,y,heading")
            with self._lock:
                everything = [BodySteps(frame.names, frame.replica) for frame in frames]
                for frame, steps in zip(frames, everything, strict=True):
                    steps.add(frame.time, frame.true_pose)
                self._write_pages("obstacles", [self._page_of(steps) for steps in everything])
                self._obstacles = [steps for frame, steps in zip(frames, everything, strict=True) if frame.moves]
                for steps in self._obstacles:
                    steps.count = 0
            return
        moving = [frame for frame in frames if frame.moves]
        with self._lock:
            is_full = False
            for frame, steps in zip(moving, self._obstacles, strict=True):
                is_full |= steps.add(frame.time, frame.true_pose)
            if is_full:
                self._write_steps()

    def _hand_over(self) -> None:
        with self._lock:
            self._write_steps()

    def _write_steps(self) -> None:
        """Write the kept steps as lines, and forget them; after an interrupt the next call continues."""
        if not self._todo:
            previous = [self._reckon(group) if group.steps.count else group.previous for group in self._groups]
            todo = list(self._pages().items())
            for group, now in zip(self._groups, previous, strict=True):
                group.previous = now
            self._todo = todo
        while self._todo:
            try:
                self._write_pages(*self._todo[0])
            except RunError:  # it would fail again, and the other files need not wait for it
                del self._todo[0]
                raise
            del self._todo[0]
        for steps in (*(group.steps for group in self._groups), *(self._obstacles or ()), *self._parts.values()):
            steps.count = 0

    def _pages(self) -> dict[str, list[Page]]:
        """The pages of each file."""
        found: dict[str, list[Page]] = {}
        for group in self._groups:
            steps = group.steps
            for name, columns in group.columns.items():
                if name.startswith("sensors/"):
                    lines = np.flatnonzero(steps[f"fresh {name.removeprefix('sensors/')}"])
                else:
                    lines = np.arange(steps.count * steps.rows)
                if len(lines):
                    found.setdefault(name, []).append(Page(steps, lines, columns))
        for name, bodies in (("obstacles", self._obstacles or ()), ("parts", self._parts.values())):
            pages = [self._page_of(steps) for steps in bodies if steps.count]
            if pages:
                found[name] = pages
        return found

    def _write_pages(self, name: str, pages: list[Page]) -> None:
        """Write lines, and take them from the pages as they are written."""
        if len(pages) == 1:
            page = pages[0]
            for made in self._printer.print(page.steps.table, page.steps.rows, page.lines, page.columns):
                self._files.write(name, made.data)
                pages[0] = pages[0]._replace(lines=pages[0].lines[len(made.ends) :])
            return
        # The groups take turns, step by step.
        count = max(page.steps.count for page in pages)
        whole = []
        for page in pages:
            data, ends, size = [], [np.zeros(1, dtype=np.int64)], 0
            for made in self._printer.print(page.steps.table, page.steps.rows, page.lines, page.columns):
                data.append(bytes(made.data))
                ends.append(made.ends + size)
                size += len(made.data)
            at = np.concatenate(ends)[np.searchsorted(page.lines // page.steps.rows, np.arange(count + 1))].tolist()
            whole.append((b"".join(data), at))
        self._files.write(name, b"".join(data[at[i] : at[i + 1]] for i in range(count) for data, at in whole))

    # ------------------------------------------------------------------------------------------------------ columns

    def _page_of(self, steps: BodySteps) -> Page:
        spans = [*self._lead(steps), steps.span(_OUTPUT, "true_pose")]
        return Page(steps, np.arange(steps.count * steps.rows), Columns(spans, steps.texts))

    def _lead(self, steps: Steps, stamp: str = "") -> list[Span]:
        """The first columns: the replica where there are several, times, and the name."""
        assert self._run is not None
        texts = [Span(NAME, steps.rows, 1)] if len(self._run.replicas) > 1 else []
        times = [steps.span(self._decimals, name) for name in ("time", stamp) if name]
        return [*texts, *times, Span(NAME, 0, 1)]

    def _columns(self, steps: RobotSteps) -> dict[str, Columns]:
        """The columns of each file."""
        assert self._run is not None
        frame, lead = steps.first, self._lead(steps)
        first = next(iter(frame.estimates))
        rates, channels = [], []
        for joint in self._joints:
            if joint in frame.joint_names:
                place = list(frame.joint_names).index(joint)
                rates += [steps.span(_OUTPUT, name, place, 1) for name in ("joint_rates", "measured_rates")]
            else:
                rates.append(Span(MISSING, cells=2))
        for channel in self._channels:
            is_there = channel in frame.channels
            place = list(frame.channels).index(channel) if is_there else 0
            channels.append(steps.span(EXACT, "command", place, 1) if is_there else Span(NOTHING))
        twists = [steps.span(_OUTPUT, name) for name in ("true_twist", "estimated_twist")]
        found = {
            "poses": [*lead, *(steps.span(_OUTPUT, name) for name in ("true_pose", f"pose {first}"))],
            "velocities": [*lead, *twists, *rates],
            "commands": [*lead, *channels],
        }
        for name in frame.estimates:
            upper = [steps.span(EXACT, f"covariance {name}", of, count) for of, count in _UPPER]
            found[f"estimates/{name}"] = [*lead, steps.span(_OUTPUT, f"pose {name}"), *upper]
        if self._run.with_sensors:
            for name, (true, _) in frame.readings.items():
                missing = [Span(MISSING, cells=self._sizes[name] - true.shape[1])]
                values = [[steps.span(_OUTPUT, f"{what} {name}"), *missing] for what in ("true", "measured")]
                head = self._lead(steps, f"seconds {name}")
                found[f"sensors/{name}"] = [*head, *values[0], *values[1]]
        for name, beliefs in steps.beliefs.items():
            places = {
                column: steps.span(EXACT, f"belief {name} {belief}", place, 1)
                for belief, shape in beliefs.items()
                for place, column in enumerate(_belief_columns({belief: shape}))
            }
            found[f"beliefs/{name}"] = [*lead, *(places.get(column, Span(MISSING)) for column in self._beliefs[name])]
        return {name: Columns(spans, steps.texts) for name, spans in found.items()}

    # ------------------------------------------------------------------------------------- what follows from the steps

    def _reckon(self, group: Group) -> dict[str, Array]:
        """Compute the derived quantities of the table; returns the last values, which the next steps need.

        These are the body's estimated velocities; the joints' measured velocities, nan where nothing was measured; and
        the times at which samples were taken.
        """
        assert self._run is not None
        steps, previous = group.steps, dict(group.previous)
        for name in steps.first.readings:
            np.multiply(steps[f"stamp {name}"], self._run.dt, out=steps[f"seconds {name}"])
        estimated = steps[f"pose {next(iter(steps.first.estimates))}"].reshape(-1, 3)
        before = np.concatenate((previous.get("pose", estimated[: steps.rows]), estimated[: -steps.rows]))
        previous["pose"] = estimated[-steps.rows :].copy()
        twist = logarithm(relative(before, estimated)) / self._run.dt
        steps["estimated_twist"][:] = twist.reshape(steps.count, steps.rows, 3)
        steps["measured_rates"][:] = self._measured_rates(steps, previous)
        return previous

    def _measured_rates(self, steps: RobotSteps, previous: dict[str, Array]) -> Array | float:
        """Joint rates [rad/s] from the newest two samples of the first sensor of joint angles; nan if none.

        ``(steps, rows, joints)``.
        """
        assert self._run is not None
        frame = steps.first
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
            return all_rates
        return math.nan

    def _event(self, event: Any) -> str:
        assert self._run is not None
        replica = f"{event.replica}," if len(self._run.replicas) > 1 else ""
        x, y = ("", "") if event.point is None else (f"{part:.6f}" for part in event.point)
        speed = "" if event.speed is None else f"{event.speed:.6f}"
        value = _quoted(json.dumps(event.value, default=_plain)) if event.path else ""
        time = f"{event.time:.{self._decimals}f}"
        cells = [time, event.name, event.kind, event.other, x, y, speed, event.path, value, event.tick]
        if self._has_parts:
            cells += [event.part, event.other_part]
        return replica + ",".join(map(str, cells)) + "\n"

    def close(self) -> None:
        """Close the files, also after an error."""
        self._files.close()


def _plain(value: Any) -> Any:
    """A value in a form for JSON: the fields of a `Deviation` or a `Distribution`."""
    return attrs.asdict(value, recurse=False) if attrs.has(type(value)) else str(value)


def _quoted(text: str) -> str:
    return '"' + text.replace('"', '""') + '"' if "," in text or '"' in text else text


def _belief_columns(beliefs: Mapping[str, tuple[int, ...]]) -> list[str]:
    """A column for each number of a row: ``nis``, or ``innovation_0_1`` for an array of two dimensions in a row."""
    return ["_".join((name, *map(str, place))) for name, shape in beliefs.items() for place in np.ndindex(*shape)]


def _union(names: Iterable[Iterable[str]]) -> list[str]:
    return list(dict.fromkeys(name for group in names for name in group))
