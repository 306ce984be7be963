"""Trajectories in the plane: from runs, and from and to files of other programs (TUM, KITTI, CSV)."""

from __future__ import annotations

import csv
import math
import os
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

import attrs
import numpy as np

from amorsim.analysis.run_files import RunFiles
from amorsim.array_types import Array
from amorsim.core.arguments import check_kind, checked, path_of
from amorsim.core.errors import AnalysisError, RunError
from amorsim.core.files.atomic_files import write_text
from amorsim.core.files.reading import read_bytes, reason
from amorsim.core.unknown_names import no_such

__all__ = [
    "Trajectory",
    "read_csv",
    "read_kitti",
    "read_tum",
    "run_trajectories",
    "write_csv",
    "write_kitti",
    "write_tum",
    "yaw",
]


_CSV = ("time", "x", "y", "heading")
_ROUNDED = 1e-3  # what rounding to a few digits may do to the length of a quaternion; it is read as it is written


@checked
@attrs.frozen(kw_only=True, eq=False)
class Trajectory:
    """Poses over time.

    Attributes
    ----------
    time
        Increasing, `(T,)` [s].
    poses
        (x [m], y [m], heading [rad]), `(T, 3)`.
    name
        For messages.
    """

    time: Array
    poses: Array
    name: str = "trajectory"

    def __attrs_post_init__(self) -> None:
        time, poses = np.asarray(self.time, np.float64), np.asarray(self.poses, np.float64)
        object.__setattr__(self, "time", time)
        object.__setattr__(self, "poses", poses)
        if time.ndim != 1 or poses.shape != (len(time), 3):
            raise AnalysisError(
                f"{self.name}: expected times (T,) and poses (T, 3), got shapes {time.shape} and {poses.shape}"
            )
        if not (np.isfinite(time).all() and np.isfinite(poses).all()):
            raise AnalysisError(f"{self.name}: expected finite times and poses, got nan or inf")
        if (np.diff(time) <= 0.0).any():
            place = int(np.argmax(np.diff(time) <= 0.0))
            raise AnalysisError(
                f"{self.name}: expected increasing times, got {float(time[place + 1])!r} after {float(time[place])!r}"
            )

    def __len__(self) -> int:
        return len(self.time)

    def __repr__(self) -> str:
        if not len(self):
            return f"<{self.name}: no poses>"
        return f"<{self.name}: {len(self)} poses from {self.time[0]:g} to {self.time[-1]:g} s>"


@checked
def run_trajectories(
    run: str | os.PathLike[str] | RunFiles,
    *,
    robot: str | None = None,
    replica: int | None = None,
    estimator: str | None = None,
) -> tuple[Trajectory, Trajectory]:
    """The true and the estimated trajectory of a robot in a run's folder.

    Parameters
    ----------
    robot
        Its name; without it, the first.
    replica
        Its number; a run of one replica needs none.
    estimator
        Whose estimate; without it, the one that the controller received.

    Raises
    ------
    RunError
        If the folder is not a run's, a file in it is damaged, or there is no such robot, replica or estimator.
    """
    files = run if isinstance(run, RunFiles) else RunFiles(run)
    robot = files.robots[0] if robot is None else robot
    poses = files.table("poses", robot=robot, replica=replica)
    of = f"{files.folder} ({robot})"
    true = np.stack([poses[f"true_{key}"] for key in _CSV[1:]], axis=1)
    made = Trajectory(time=poses["time"], poses=true, name=f"true trajectory of {of}")
    if estimator is None:
        believed = np.stack([poses[f"estimated_{key}"] for key in _CSV[1:]], axis=1)
        return made, Trajectory(time=poses["time"], poses=believed, name=f"estimate of {of}")
    if estimator not in files.estimators:
        raise RunError(f"{files.folder}: {no_such('estimator', estimator, files.estimators)}")
    table = files.table(f"estimates/{estimator}", robot=robot, replica=replica)
    believed = np.stack([table[key] for key in _CSV[1:]], axis=1)
    return made, Trajectory(time=table["time"], poses=believed, name=f"estimate of {of} by {estimator}")


# ------------------------------------------------------------------------------------------------------------- reading


def read_tum(path: str | os.PathLike[str]) -> Trajectory:
    """A trajectory in the format of the TUM RGB-D benchmark, projected to the plane z = 0.

    Lines are ``timestamp tx ty tz qx qy qz qw``; those that begin with ``#`` are comments. The heading is the yaw of
    the quaternion.

    Raises
    ------
    AnalysisError
        If it cannot be read, with the line.
    """
    table = _numbers(path, 8)
    heading = [yaw(*row) for row in table[:, 4:].tolist()]
    return Trajectory(time=table[:, 0], poses=np.column_stack((table[:, 1:3], heading)), name=str(path))


@checked
def read_kitti(
    path: str | os.PathLike[str], times: str | os.PathLike[str] | None = None, *, plane: str = "xy"
) -> Trajectory:
    """A trajectory in the format of KITTI's odometry benchmark: lines of 12 numbers, the rows of a 3 x 4 matrix.

    Parameters
    ----------
    times
        A file with the time [s] of each pose, a line each; without it, poses are a second apart.
    plane
        ``"xy"``, or ``"zx"`` for poses of a camera that looks along z, with x to its right, as KITTI's own.

    Raises
    ------
    AnalysisError
        If a file cannot be read, with the line.
    """
    if plane not in ("xy", "zx"):
        raise AnalysisError(f"plane: expected 'xy' or 'zx', got {plane!r}")
    matrices = _numbers(path, 12).reshape(-1, 3, 4)
    when = np.arange(float(len(matrices))) if times is None else _numbers(times, 1)[:, 0]
    if len(when) != len(matrices):
        raise AnalysisError(f"{times}: expected a time for each of {len(matrices)} poses, got {len(when)}")
    if plane == "xy":
        x, y, along, left = matrices[:, 0, 3], matrices[:, 1, 3], matrices[:, 0, 0], matrices[:, 1, 0]
    else:
        x, y, along, left = matrices[:, 2, 3], -matrices[:, 0, 3], matrices[:, 2, 2], -matrices[:, 0, 2]
    return Trajectory(time=when, poses=np.column_stack((x, y, np.arctan2(left, along))), name=str(path))


def read_csv(path: str | os.PathLike[str]) -> Trajectory:
    """A trajectory in a CSV file with columns ``time``, ``x``, ``y``, ``heading`` [s, m, m, rad], among others.

    Raises
    ------
    AnalysisError
        If it cannot be read, with the line.
    """
    lines = _lines(path)
    rows = list(csv.reader(text for _, text in lines))
    if not rows:
        raise AnalysisError(f"{path}: expected a line with the columns {', '.join(_CSV)}, got nothing")
    header = [name.strip().removeprefix("\N{BOM}") for name in rows[0]]
    for name in _CSV:
        if name not in header:
            raise AnalysisError(f"{path}, line {lines[0][0]}: {no_such('column', name, header)}")
    places = [header.index(name) for name in _CSV]
    found = np.empty((len(rows) - 1, 4))
    for i, ((number, _), cells) in enumerate(zip(lines[1:], rows[1:], strict=True)):
        if len(cells) != len(header):
            raise AnalysisError(f"{path}, line {number}: expected {len(header)} cells, got {len(cells)}")
        found[i] = _parsed(path, number, [cells[place] for place in places])
    return Trajectory(time=found[:, 0], poses=found[:, 1:], name=str(path))


def _numbers(path: str | os.PathLike[str], count: int) -> Array:
    """The lines of a file of numbers apart by blanks or commas, `(lines, count)`; without comments."""
    rows = []
    for number, text in _lines(path):
        if text.startswith("#"):
            continue
        cells = text.replace(",", " ").split()
        if len(cells) != count:
            raise AnalysisError(f"{path}, line {number}: expected {count} numbers, got {len(cells)}")
        rows.append(_parsed(path, number, cells))
    return np.array(rows, dtype=np.float64).reshape(-1, count)


def _parsed(path: str | os.PathLike[str], number: int, cells: Sequence[str]) -> list[float]:
    values = []
    for cell in cells:
        try:
            value = float(cell)
        except ValueError:
            value = math.nan
        if not math.isfinite(value):
            raise AnalysisError(f"{path}, line {number}: expected a finite number, got {cell[:60]!r}")
        values.append(value)
    return values


def _lines(path: str | os.PathLike[str]) -> list[tuple[int, str]]:
    """The lines of a text file that hold something, with their numbers."""
    file = path_of(path, "path", "the path of a trajectory's file")
    try:
        text = read_bytes(file).decode()
    except UnicodeDecodeError as error:
        raise AnalysisError(f"{path}: not a text file in UTF-8: byte {error.start}") from None
    except (OSError, ValueError) as error:
        raise AnalysisError(f"{path}: cannot be read: {reason(error)}") from None
    return [(number, line.strip()) for number, line in enumerate(text.split("\n"), start=1) if line.strip()]


def yaw(x: float, y: float, z: float, w: float) -> float:
    """The heading [rad] of a quaternion; one that is longer or shorter than 1 is scaled, zeros alone are heading 0."""
    length = math.hypot(x, y, z, w)
    if abs(length - 1.0) > _ROUNDED and length > 0.0:
        x, y, z, w = x / length, y / length, z / length, w / length
    return math.atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))


# ------------------------------------------------------------------------------------------------------------- writing


@checked
def write_tum(trajectory: Trajectory, path: str | os.PathLike[str], *, within: Path | None = None) -> None:
    """Write a trajectory in the format of the TUM benchmark, z = 0; `read_tum` reads the same poses, but for rounding.

    Parameters
    ----------
    within
        A folder in which the file must stay: links in it are replaced. Without it, a link is followed.

    Raises
    ------
    RunError
        If it cannot be written.
    """
    _write(
        path,
        trajectory,
        lambda time, x, y, heading: (time, x, y, 0.0, 0.0, 0.0, math.sin(0.5 * heading), math.cos(0.5 * heading)),
        "# timestamp tx ty tz qx qy qz qw\n",
        within=within,
    )


@checked
def write_kitti(trajectory: Trajectory, path: str | os.PathLike[str], *, within: Path | None = None) -> None:
    """Write a trajectory in KITTI's format, in the plane xy; times are lost. As `write_tum`."""

    def row(_: float, x: float, y: float, heading: float) -> tuple[float, ...]:
        cos, sin = math.cos(heading), math.sin(heading)
        return cos, -sin, 0.0, x, sin, cos, 0.0, y, 0.0, 0.0, 1.0, 0.0

    _write(path, trajectory, row, within=within)


@checked
def write_csv(trajectory: Trajectory, path: str | os.PathLike[str], *, within: Path | None = None) -> None:
    """Write a trajectory as ``time,x,y,heading`` [s, m, m, rad], to the bit. As `write_tum`."""
    _write(path, trajectory, lambda *row: row, ",".join(_CSV) + "\n", ",", within=within)


def _write(
    path: str | os.PathLike[str],
    trajectory: Trajectory,
    row: Callable[[float, float, float, float], tuple[float, ...]],
    head: str = "",
    between: str = " ",
    *,
    within: Path | None,
) -> None:
    check_kind(trajectory, Trajectory, "trajectory", "a Trajectory, as am.analysis.read_tum('true.tum')")
    lines = (f"{between.join(map(repr, row(*each)))}\n" for each in _rows(trajectory))
    write_text(path, head + "".join(lines), within=within)


def _rows(trajectory: Trajectory) -> Iterator[tuple[float, float, float, float]]:
    for time, (x, y, heading) in zip(trajectory.time.tolist(), trajectory.poses.tolist(), strict=True):
        yield time, x, y, heading
