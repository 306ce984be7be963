"""The lines of a run's text files, made step by step and cell by cell: the plain twin of `amorsim.recorders.text`."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from typing import Any

import numpy as np

from amorsim.contracts import Frame, ObstacleFrame
from amorsim.core.poses import logarithm, relative


class PlainText:
    """Collects the lines, without heads, by file."""

    def __init__(self, frames: Sequence[Frame], obstacles: Sequence[ObstacleFrame], dt: float, numbered: bool) -> None:
        self.lines: dict[str, list[str]] = defaultdict(list)
        self._dt = dt
        self._numbered = numbered
        self._only_moving = False
        self._joints = list(dict.fromkeys(name for frame in frames for name in frame.joint_names))
        self._channels = list(dict.fromkeys(name for frame in frames for name in frame.channels))
        self._sizes: dict[str, int] = {}
        for frame in frames:
            for name, (true, _) in frame.readings.items():
                self._sizes[name] = max(self._sizes.get(name, 0), true.shape[1])
        self._previous: list[dict[str, Any]] = [{} for _ in frames]
        self.write(frames, obstacles)
        self._only_moving = True

    def write(self, frames: Sequence[Frame], obstacles: Sequence[ObstacleFrame]) -> None:
        """Take a step."""
        for frame in obstacles:
            for row, name in enumerate(frame.names):
                if frame.moves or not self._only_moving:
                    replica = f"{frame.replica[row]}," if self._numbered else ""
                    self._add("obstacles", f"{replica}{float(frame.time[row]):.6f},{name}", frame.true_pose[row])
        for frame, previous in zip(frames, self._previous, strict=True):
            velocities = self._velocities(frame, previous)
            for row in range(len(frame.names)):
                self._write_row(frame, row, velocities[row])

    def _write_row(self, frame: Frame, row: int, velocities: np.ndarray) -> None:
        replica = f"{frame.replica[row]}," if self._numbered else ""
        time = f"{replica}{float(frame.time[row]):.6f}"
        name = frame.names[row]
        estimate = next(iter(frame.estimates.values()))
        self._add("poses", f"{time},{name}", [*frame.true_pose[row], *estimate.pose[row]])
        self._add("velocities", f"{time},{name}", velocities)
        commands = dict(zip(frame.channels, frame.command[row].tolist(), strict=True))
        cells = [repr(commands[channel]) if channel in commands else "" for channel in self._channels]
        self.lines["commands"].append(",".join([time, name, *cells]))
        for key, held in frame.estimates.items():
            upper = held.covariance[row][np.triu_indices(3)].tolist()
            pose = [f"{part:.6f}" for part in held.pose[row].tolist()]
            self.lines[f"estimates/{key}"].append(",".join([time, name, *pose, *map(repr, upper)]))
        for key, (true, reading) in frame.readings.items():
            if reading.fresh[row, 0]:
                stamp = f"{int(reading.stamp[row, 0]) * self._dt:.6f}"
                missing = [np.nan] * (self._sizes[key] - true.shape[1])
                values = [*true[row], *missing, *reading.measured[row], *missing]
                self._add(f"sensors/{key}", f"{time},{stamp},{name}", values)

    def _add(self, file: str, lead: str, values: Any) -> None:
        self.lines[file].append(",".join([lead, *(f"{float(value):.6f}" for value in values)]))

    def _velocities(self, frame: Frame, previous: dict[str, Any]) -> np.ndarray:
        estimated = next(iter(frame.estimates.values())).pose
        twist = logarithm(relative(previous.get("pose", estimated), estimated)) / self._dt
        previous["pose"] = estimated.copy()
        rates = np.full((len(frame.names), 2 * len(self._joints)), np.nan)
        for name, model in frame.robot.sensors.items():
            if hasattr(model.sensor, "angles"):
                reading = frame.readings[name][1]
                angles, stamp = model.sensor.angles(reading.measured), reading.stamp
                last, last_stamp, held = previous.get("angles", (angles, stamp, np.zeros_like(angles)))
                elapsed = (stamp - last_stamp) * self._dt
                with np.errstate(divide="ignore", invalid="ignore"):
                    held = np.where(elapsed > 0, (angles - last) / elapsed, held)
                previous["angles"] = (angles.copy(), stamp.copy(), held)
                for position, joint in enumerate(frame.joint_names):
                    rates[:, 2 * self._joints.index(joint) + 1] = held[:, position]
                break
        for position, joint in enumerate(frame.joint_names):
            rates[:, 2 * self._joints.index(joint)] = frame.joint_rates[:, position]
        return np.concatenate((frame.true_twist, twist, rates), axis=1)
