"""One moment in a run's folder: the numbers of its robots, obstacles, sensors and estimators."""

from __future__ import annotations

import contextlib
import functools
import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path

import numpy as np

from amorsim.analysis.run_files import belief_arrays
from amorsim.array_types import AnyArray, Array
from amorsim.core.errors import RunError
from amorsim.runs.array_files import read_arrays
from amorsim.runs.moments import Cells, TimedLines

__all__ = ["Beliefs", "RecordedFiles"]

Beliefs = Mapping[str, Mapping[str, AnyArray]]

_POSE = ("x", "y", "heading")
_COVARIANCE = ("xx", "xy", "xh", "yy", "yh", "hh")


class RecordedFiles:
    """The files of a run, for reading single moments; a file that is missing or damaged has no numbers.

    Parameters
    ----------
    folder
        Of the run.
    dt
        Its time step [s].
    replicas
        The numbers of its replicas.
    noted
        Called with each problem that is met, once.

    Attributes
    ----------
    replica
        The number of the replica that is read.

    Raises
    ------
    RunError
        If there is no ``poses.csv``, or it is damaged.
    """

    def __init__(self, folder: Path, dt: float, replicas: Sequence[int], noted: Callable[[str], None]) -> None:
        self._folder, self._dt, self._noted = folder, dt, noted
        self._with_replicas = len(replicas) > 1
        self.replica = replicas[0]
        self._files: dict[str, TimedLines | None] = {}
        self._poses = self._opened("poses")
        self._files["poses"] = self._poses
        self._arrays: dict[Path, dict[str, AnyArray]] = {}  # the last that were read, of each estimator
        self._at: dict[str, list[tuple[int, Path]]] = {}

    def close(self) -> None:
        """Close the files."""
        for file in self._files.values():
            if file is not None:
                file.close()

    @property
    def last_tick(self) -> int:
        """The last tick with poses."""
        last = self._poses.last_time
        if last is None:
            raise RunError(f"{self._poses.path}: holds no poses; the run was broken off before its first step")
        return round(last / self._dt)

    def _opened(self, name: str) -> TimedLines:
        return TimedLines(
            self._folder / f"{name}.csv",
            name,
            with_replicas=self._with_replicas,
            damaged=lambda error: self._noted(str(error)),
        )

    def _file(self, name: str) -> TimedLines | None:
        """A file by its name without ``.csv``; None if it is missing, or cannot be read."""
        if name not in self._files:
            self._files[name] = None
            if (self._folder / f"{name}.csv").exists():
                try:
                    self._files[name] = self._opened(name)
                except RunError as error:
                    self._noted(str(error))
        return self._files[name]

    def has(self, name: str) -> bool:
        """Whether there is a file that can be read."""
        return self._file(name) is not None

    def columns(self, name: str) -> list[str]:
        """The names of a file's columns; none if it cannot be read."""
        file = self._file(name)
        return [] if file is None else list(file.columns)

    # ---------------------------------------------------------------------------------------------------------- bodies

    def _of_replica(self, file: TimedLines, cells: Cells) -> bool:
        return not self._with_replicas or cells[file.columns["replica"]] == str(self.replica).encode()

    def _bodies(
        self, name: str, tick: int, key: str, columns: Sequence[str], only: str | None = None
    ) -> dict[str, Array]:
        """Columns of a file at a tick, by the name in the column `key`: for all names, or for those of `only`."""
        file = self._file(name)
        if file is None or not {key, *columns} <= set(file.columns):
            return {}
        places = [file.columns[column] for column in columns]
        wanted = None if only is None else only.encode()
        try:
            lines = file.at(tick * self._dt, 0.5 * self._dt)
        except RunError as error:
            self._noted(str(error))
            return {}
        return {
            cells[file.columns[key]].decode(errors="replace"): np.array(file.numbers(cells, places))
            for cells in lines
            if self._of_replica(file, cells) and (wanted is None or cells[file.columns[key]] == wanted)
        }

    def poses(self, tick: int, only: str | None = None) -> dict[str, Array]:
        """True and estimated poses `(6,)` by robot, of all or of one."""
        columns = [f"{kind}_{part}" for kind in ("true", "estimated") for part in _POSE]
        return self._bodies("poses", tick, "robot", columns, only)

    def covariances(self, estimator: str, tick: int, only: str | None = None) -> dict[str, Array]:
        """xx, xy, xh, yy, yh, hh `(6,)` of an estimator's poses, by robot, of all or of one."""
        return self._bodies(f"estimates/{estimator}", tick, "robot", _COVARIANCE, only)

    def obstacles(self, tick: int) -> dict[str, Array]:
        """True poses `(3,)` by obstacle; those that do not move have rows at the start alone."""
        return self._bodies("obstacles", tick, "obstacle", _POSE)

    def parts(self, tick: int) -> dict[str, Array]:
        """True poses `(3,)` by part, as ``rover.trailer``."""
        return self._bodies("parts", tick, "part", _POSE)

    def values(self, name: str, tick: int, robot: str, columns: Sequence[str]) -> Array:
        """Numbers of a robot in ``velocities`` or ``commands``, as many as columns; nan for those that are missing."""
        there = [column for column in columns if column in self.columns(name)]
        found = dict(zip(there, self._bodies(name, tick, "robot", there, robot).get(robot, ()), strict=False))
        return np.array([found.get(column, math.nan) for column in columns])

    # --------------------------------------------------------------------------------------------------------- sensors

    def reading(self, sensor: str, tick: int, robot: str, size: int) -> tuple[Array, Array, float]:
        """True and measured values `(size,)` of the last reading at a tick, and its age [s]; nan if there is none."""
        nothing = np.full(size, np.nan), np.full(size, np.nan), math.nan
        file = self._file(f"sensors/{sensor}")
        if file is None or f"true_{size - 1}" not in file.columns:
            return nothing
        cells = self._last(file, tick, robot)
        if cells is None:
            return nothing
        true, measured = (
            np.array(file.numbers(cells, [file.columns[f"{kind}_{i}"] for i in range(size)]))
            for kind in ("true", "measured")
        )
        (stamp,) = file.numbers(cells, [file.columns["stamp"]])
        return true, measured, tick * self._dt - stamp

    def _last(self, file: TimedLines, tick: int, robot: str) -> Cells | None:
        name, column = robot.encode(), file.columns["robot"]
        try:
            return file.last(
                (tick + 0.5) * self._dt, lambda cells: cells[column] == name and self._of_replica(file, cells)
            )
        except RunError as error:
            self._noted(str(error))
            return None

    # --------------------------------------------------------------------------------------------------------- beliefs

    def beliefs(self, tick: int, robot: str, first: Sequence[str] = ()) -> Beliefs:
        """Beliefs `(1, ...)` of a robot by estimator, or ``"controller"``; those of `first` come first.

        They are from the last file of the recorder ``arrays`` at or before a tick. Without such files they are from the
        text file of the tick, which holds the small ones.
        """
        names = sorted(self.believers, key=lambda name: (name not in first, name))
        found = {name: self.beliefs_of(name, tick, robot)[1] for name in names}
        return {name: beliefs for name, beliefs in found.items() if beliefs}

    def beliefs_of(self, name: str, tick: int, robot: str) -> tuple[int, Mapping[str, AnyArray]]:
        """The beliefs `(1, ...)` of one estimator of a robot, or ``"controller"``, and their tick."""
        if not self._array_files(name):
            return tick, self._small_beliefs(name, tick, robot)
        files = [(at, path) for at, path in self._array_files(name) if at <= tick]
        newest = files[-1][0] if files else tick
        for at, path in reversed(files):  # robots of several kinds have a file each
            if at < newest:
                break
            arrays = self._read_arrays(path)
            row = self._row(arrays, robot)
            if row is not None:
                return at, {key: array[row : row + 1] for key, array in arrays.items() if array.ndim > 0}
        return newest, {}

    @functools.cached_property
    def believers(self) -> list[str]:
        """The names of estimators and controllers whose beliefs were written."""
        return sorted({path.stem for path in (self._folder / "beliefs").glob("*") if not path.name.startswith(".")})

    def _small_beliefs(self, name: str, tick: int, robot: str) -> dict[str, AnyArray]:
        """Beliefs `(1, ...)` of a robot from a text file; none if it has no line of the tick."""
        columns = [column for column in self.columns(f"beliefs/{name}") if column not in ("replica", "time", "robot")]
        numbers = self._bodies(f"beliefs/{name}", tick, "robot", columns, robot).get(robot)
        if numbers is None:
            return {}
        table = {column: numbers[i : i + 1] for i, column in enumerate(columns)}
        return {key: array[0] for key, array in belief_arrays(table, np.zeros((1, 1), dtype=np.int64)).items()}

    def _array_files(self, estimator: str) -> list[tuple[int, Path]]:
        """The files of an estimator's beliefs, each with its tick, in order."""
        if estimator not in self._at:
            files = []
            for path in sorted((self._folder / "beliefs" / estimator).glob("*.npz")):
                with contextlib.suppress(ValueError):
                    files.append((int(path.stem.split("-")[0]), path))
            self._at[estimator] = files
        return self._at[estimator]

    def has_arrays(self, names: Iterable[str]) -> bool:
        """Whether there are files of the recorder ``arrays`` of any of these estimators, or of ``"controller"``."""
        return any(self._array_files(name) for name in names)

    def _read_arrays(self, path: Path) -> dict[str, AnyArray]:
        if path not in self._arrays:
            arrays: dict[str, AnyArray] = {}
            try:
                arrays = read_arrays(path)
            except RunError as error:
                self._noted(str(error))
            for other in [one for one in self._arrays if one.parent == path.parent]:
                del self._arrays[other]
            self._arrays[path] = arrays
        return self._arrays[path]

    def _row(self, arrays: Mapping[str, AnyArray], robot: str) -> int | None:
        if not {"robot", "replica"} <= set(arrays):
            return None
        rows = np.flatnonzero((arrays["robot"] == robot) & (arrays["replica"] == self.replica))
        return int(rows[0]) if len(rows) else None
