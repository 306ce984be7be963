"""A run's text files as arrays."""

from __future__ import annotations

import functools
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Literal

import numpy as np

from amorsim.array_types import AnyArray, Ints
from amorsim.core.arguments import checked, path_of
from amorsim.core.errors import RunError
from amorsim.core.unknown_names import no_such
from amorsim.runs.manifest import RUN_FOLDER, read_about, scenario_of
from amorsim.runs.tables import read_columns
from amorsim.scenario.spec import Scenario

__all__ = ["RunFiles", "Table", "belief_arrays"]

Table = Mapping[str, AnyArray]

_POSE = ("x", "y", "heading")
_TWIST = ("forward", "left", "turn")
_COVARIANCE = ("xx", "xy", "xh", "xy", "yy", "yh", "xh", "yh", "hh")


class RunFiles:
    """The files in the folder of a run: `about` is its ``run.json``; `table` and `arrays` read its text files.

    Each file is read once, when it is first asked for. A run that was killed can be read too, up to its last whole
    lines.

    Attributes
    ----------
    replicas
        The replicas' numbers, in the order of their rows.

    Raises
    ------
    RunError
        If the folder is not a run's. Each method, too, if a file is damaged: it names file, line and column.
    """

    def __init__(self, folder: str | os.PathLike[str]) -> None:
        self.folder = path_of(folder, "run", RUN_FOLDER)
        self.about: dict[str, Any] = read_about(self.folder)
        self.replicas: list[int] = self.about["replicas"]
        self._columns: dict[str, Table] = {}
        self._by_replica: dict[str, dict[int, Ints]] = {}

    @functools.cached_property
    def scenario(self) -> Scenario:
        """The scenario that was run."""
        return scenario_of(self.folder, self.about)

    @property
    def sensors(self) -> list[str]:
        """The names of the sensors that were written."""
        return sorted(path.stem for path in (self.folder / "sensors").glob("*.csv"))

    @property
    def estimators(self) -> list[str]:
        """The names of the estimators whose estimates were written."""
        return sorted(path.stem for path in (self.folder / "estimates").glob("*.csv"))

    @property
    def believers(self) -> list[str]:
        """The names of the estimators whose beliefs were written."""
        return sorted(path.stem for path in (self.folder / "beliefs").glob("*.csv"))

    @functools.cached_property
    def robots(self) -> list[str]:
        """The robots' names, in the order of their rows."""
        return sorted(robot.name for robot in self.scenario.robots)

    @property
    def rows(self) -> list[tuple[int, str]]:
        """The replica and the robot of each row of `arrays`: in the order of `replicas`, then of the robots' names."""
        return [(replica, robot) for replica in self.replicas for robot in self.robots]

    @checked
    def table(self, name: str, *, robot: str | None = None, replica: int | Literal["all"] | None = None) -> Table:
        """The columns of ``<name>.csv`` `(lines,)`, of all robots or of one, in one replica or in all.

        Parameters
        ----------
        name
            Such as ``"poses"`` or ``"sensors/laser"``.
        replica
            Its number, or ``"all"``, distinguished by the column ``replica``. A run of one replica needs none.

        Raises
        ------
        RunError
            If the file cannot be read or is damaged, there is no such robot or replica, or there are several replicas
            and none is named.
        """
        if robot is not None:
            self._check_robot(robot)
        if replica is None and len(self.replicas) > 1:
            raise RunError(
                f"{self.folder}: there are {len(self.replicas)} replicas; say which one with replica=, or "
                'replica="all"; arrays() gives all of them row by row'
            )
        if replica not in (None, "all") and replica not in self.replicas:
            raise RunError(f"{self.folder}: {no_such('replica', replica, self.replicas)}")
        columns = self._read(name)
        chosen: Any = slice(None)
        if "replica" in columns and replica != "all":
            wanted = self.replicas[0] if replica is None else int(replica)
            chosen = self._lines_by_replica(name).get(wanted, np.empty(0, dtype=np.int64))
        if robot is not None:
            robots = self._column(name, columns, "robot")[chosen]
            chosen = np.arange(len(robots))[robots == robot] if isinstance(chosen, slice) else chosen[robots == robot]
        return {key: values[chosen] for key, values in columns.items()}

    @checked
    def arrays(self, name: str, *, robot: str | None = None) -> Table:
        """All replicas of a file at once, as arrays ``(steps, N, ...)`` with a row for each robot of each replica.

        Rows are in the order of `rows`, as those of `Simulation.true_pose` are; with `robot`, a row for each replica.

        ==================  ===================================================================================
        ``poses``           ``true_pose``, ``estimated_pose`` (S, N, 3) [m, m, rad]
        ``velocities``      ``true_twist``, ``estimated_twist`` (S, N, 3); ``true_rates``, ``measured_rates``
                            (S, N, joints) [rad/s]
        ``commands``        ``command`` (S, N, channels)
        ``estimates/NAME``  ``pose`` (S, N, 3), ``covariance`` (S, N, 3, 3)
        ``beliefs/NAME``    each belief by its name, (S, N, ...)
        ``sensors/NAME``    ``true``, ``measured`` (S, N, values) of every sample; ``time``, ``stamp`` (S, N) [s]
        ==================  ===================================================================================

        All but sensors have ``time`` (S,) [s]. What a robot does not have is nan: a sensor, an estimator, samples
        after its last where another's come more often. Of a run that was killed, a step that not all robots have is
        left out.

        Raises
        ------
        RunError
            If the file cannot be read, is damaged, or does not have a line for each robot and step.
        """
        if robot is not None:
            self._check_robot(robot)
        kind = name.partition("/")[0]
        if kind not in ("poses", "velocities", "commands", "estimates", "beliefs", "sensors"):
            raise RunError(
                f"{self.folder}: only poses, velocities, commands, estimates, beliefs and sensors have rows, not "
                f'{name!r}; read it with table({name!r}, replica="all")'
            )
        columns = self._read(name)
        robots = self.robots if robot is None else [robot]
        lines = self._grid(name, columns, robots, is_of_all=kind in ("poses", "velocities", "commands"))
        of = functools.partial(_laid_out, columns, lines)
        if kind == "sensors":
            size = sum(key.startswith("true_") for key in columns)
            values = {channel: of([f"{channel}_{i}" for i in range(size)]) for channel in ("true", "measured")}
            return {"time": of(["time"])[..., 0], "stamp": of(["stamp"])[..., 0], **values}
        found = {"time": self._times(name, columns, lines)}
        if kind == "estimates":
            covariance = of(_COVARIANCE)
            return found | {"pose": of(_POSE), "covariance": covariance.reshape(*covariance.shape[:2], 3, 3)}
        if kind == "beliefs":
            return found | belief_arrays(columns, lines)
        if kind == "commands":
            return found | {"command": of([key for key in columns if key not in ("replica", "time", "robot")])}
        body, what = (_POSE, "pose") if kind == "poses" else (_TWIST, "twist")
        for channel in ("true", "estimated"):
            found[f"{channel}_{what}"] = of([f"{channel}_{key}" for key in body])
        if kind == "velocities":
            joints = self.joints(columns)
            found |= {f"{channel}_rates": of([f"{channel}_{j}" for j in joints]) for channel in ("true", "measured")}
        return found

    @staticmethod
    @checked
    def joints(velocities: Table) -> list[str]:
        """The names of the joints in the columns of ``velocities.csv``."""
        body = {f"true_{key}" for key in _TWIST}
        return [key.removeprefix("true_") for key in velocities if key.startswith("true_") and key not in body]

    # --------------------------------------------------------------------------------------------------- inside

    def _path(self, name: str) -> Path:
        return self.folder / f"{name}.csv"

    def _check_robot(self, robot: str) -> None:
        if robot not in self.robots:
            raise RunError(f"{self.folder}: {no_such('robot', robot, self.robots)}")

    def _read(self, name: str) -> Table:
        if name not in self._columns:
            self._columns[name] = read_columns(self._path(name), name, with_replicas=len(self.replicas) > 1)
        return self._columns[name]

    def _column(self, name: str, columns: Table, key: str) -> AnyArray:
        if key not in columns:
            raise RunError(f"{self._path(name)}, line 1: {no_such('column', key, columns)}")
        return columns[key]

    def _lines_by_replica(self, name: str) -> dict[int, Ints]:
        """Where the lines of each replica lie."""
        if name not in self._by_replica:
            replicas = self._columns[name]["replica"]
            order = np.argsort(replicas, kind="stable")
            numbers, first = np.unique(replicas[order], return_index=True)
            parts = np.split(order, first[1:])
            self._by_replica[name] = dict(zip(numbers.tolist(), parts, strict=False))
        return self._by_replica[name]

    def _grid(self, name: str, columns: Table, robots: list[str], *, is_of_all: bool) -> Ints:
        """The line of each step of each row, `(S, N)`; -1 where there is none."""
        places = {robot: i for i, robot in enumerate(robots)}
        known = set(self.robots)
        column = columns["robot"].tolist()
        for number, robot in enumerate(column, start=2):
            if robot not in known:
                raise RunError(f"{self._path(name)}, line {number}, robot: there is no robot {robot!r}")
        row = np.array([places.get(robot, -1) for robot in column], dtype=np.int64)
        if "replica" in columns:
            order = {replica: i for i, replica in enumerate(self.replicas)}
            replica = np.array([order.get(number, -1) for number in columns["replica"].tolist()], dtype=np.int64)
            if (replica < 0).any():
                number = int(np.argmin(replica))
                raise RunError(
                    f"{self._path(name)}, line {number + 2}, replica: there is no replica {columns['replica'][number]}"
                )
            row = np.where(row < 0, -1, replica * len(robots) + row)
        rows = len(self.replicas) * len(robots)
        lines = np.flatnonzero(row >= 0)
        lines = lines[np.argsort(row[lines], kind="stable")]
        counts = np.bincount(row[lines], minlength=rows)
        if is_of_all and counts.max() - counts.min() > 1:
            least, most = int(np.argmin(counts)), int(np.argmax(counts))
            raise RunError(
                f"{self._path(name)}: is damaged: expected as many lines of each robot in each replica, got "
                f"{counts[least]} of {self._whose(least, robots)} and {counts[most]} of {self._whose(most, robots)}"
            )
        steps = int(counts.min() if is_of_all else counts.max())
        grid = np.full((rows, steps), -1, dtype=np.int64)
        ends = np.cumsum(counts)
        step = np.arange(len(lines)) - np.repeat(ends - counts, counts)
        within = step < steps
        grid[row[lines[within]], step[within]] = lines[within]
        return grid.T

    def _whose(self, row: int, robots: list[str]) -> str:
        replica, robot = divmod(row, len(robots))
        of = f" in replica {self.replicas[replica]}" if len(self.replicas) > 1 else ""
        return f"{robots[robot]!r}{of}"

    def _times(self, name: str, columns: Table, lines: Ints) -> AnyArray:
        """The time of each step `(S,)`, shared by all rows."""
        there = lines >= 0
        first = lines[np.arange(len(lines)), np.argmax(there, axis=1)] if len(lines) else lines[:, 0]
        times = columns["time"][first]
        other = there & (columns["time"][lines] != times[:, None])
        if other.any():
            line = int(lines[other].min())
            raise RunError(
                f"{self._path(name)}, line {line + 2}, time: expected the time of the same step of other robots, got "
                f"{columns['time'][line]:g}"
            )
        return times


def belief_arrays(columns: Table, lines: Ints) -> dict[str, AnyArray]:
    """Beliefs `(S, N, ...)` by name, from the lines `(S, N)`; columns such as ``innovation_0_1`` make one array."""
    places: dict[str, list[tuple[int, ...]]] = {}
    for key in columns:
        if key not in ("replica", "time", "robot"):
            words = key.split("_")
            last = len(words)
            while words[last - 1].isdigit() and last > 1:
                last -= 1
            places.setdefault("_".join(words[:last]), []).append(tuple(map(int, words[last:])))
    found = {}
    for name, indices in places.items():
        shape = tuple(max(index) + 1 for index in zip(*indices, strict=True))
        array = _laid_out(columns, lines, ["_".join((name, *map(str, index))) for index in indices])
        found[name] = array.reshape(*lines.shape, *shape)
    return found


def _laid_out(columns: Table, lines: Ints, keys: Any) -> AnyArray:
    """Columns as an array `(S, N, keys)`; nan where there is no line."""
    found = np.empty((*lines.shape, len(keys)))
    missing = lines < 0
    for i, key in enumerate(keys):
        found[..., i] = columns[key][lines] if len(columns[key]) else np.nan
    found[missing] = np.nan
    return found
