"""Recorded motion: a table of times and places to follow."""

from __future__ import annotations

import csv
import functools
import math
import os
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import attrs
import numpy as np

from amorsim.array_types import Array
from amorsim.contracts import Context, Draws, Motion, State, View, parameter
from amorsim.core.errors import ComponentError, did_you_mean
from amorsim.core.files.reading import read_text, reason
from amorsim.core.parameters import ParameterError
from amorsim.core.poses import wrap_angle
from amorsim.motions.ways import displacement, facing

__all__ = ["Recorded", "Track", "read_track"]


_COLUMNS = ("time", "x", "y")
_HEADING = "heading_deg"
_ANGLES = ("heading", "heading_rad", "theta", "yaw", "angle")


class Recorded(NamedTuple):
    """The content of a file: increasing times [s] from 0 on, places [m], unwrapped headings [rad] or none."""

    time: Array  # (T,)
    x: Array
    y: Array
    heading: Array | None

    @property
    def fastest(self) -> float:
        """The largest speed [m/s] between two of its lines."""
        way = np.sqrt(np.diff(self.x) ** 2 + np.diff(self.y) ** 2)
        return float((way / np.diff(self.time)).max())


def read_track(path: str | os.PathLike[str]) -> Recorded:
    """The track in a CSV file headed ``time,x,y`` or ``time,x,y,heading_deg``, in any order.

    Its first time counts as 0.

    Raises
    ------
    ParameterError
        If the file is wrong; the message names `file`, the line and what is expected.
    """
    try:
        text = read_text(path, encoding="utf-8-sig")
    except FileNotFoundError:
        raise ParameterError("file", f"expected a track to be there, got no such file as {str(path)!r}") from None
    except (OSError, ValueError) as error:
        raise ParameterError(
            "file", f"expected a text file, but {str(path)!r} cannot be read: {reason(error)}"
        ) from None
    rows = [(number, row) for number, row in enumerate(csv.reader(text.splitlines()), start=1) if any(row)]
    header = [cell.strip() for cell in rows[0][1]] if rows else []
    missing = [name for name in _COLUMNS if name not in header]
    if missing:
        raise ParameterError(
            "file", f"{path}: expected a first line such as time,x,y,heading_deg, got {','.join(header)[:80]!r}"
        )
    known = (*_COLUMNS, _HEADING)
    strange = [name for i, name in enumerate(header) if name not in known or name in header[:i]]
    if strange:
        turned = strange[0] in _ANGLES
        hint = f" An angle is given in degrees, as {_HEADING}." if turned else did_you_mean(strange[0], known)
        raise ParameterError(
            "file", f"{path}: expected no columns but {', '.join(known)}, each once, got also {strange[0]!r}.{hint}"
        )
    wanted = [*_COLUMNS, *([_HEADING] if _HEADING in header else [])]
    values = np.array([_numbers(path, number, header, row, wanted) for number, row in rows[1:]]).reshape(
        -1, len(wanted)
    )
    if len(values) < 2:
        raise ParameterError("file", f"{path}: expected two lines at least below the first, got {len(values)}")
    late = np.flatnonzero(np.diff(values[:, 0]) <= 0.0)
    if len(late):
        before, time = values[late[0] : late[0] + 2, 0].tolist()
        number = rows[2 + int(late[0])][0]
        raise ParameterError("file", f"{path}, line {number}: expected a time above {before:.9g}, got {time:.9g}")
    heading = np.unwrap(np.radians(values[:, 3])) if _HEADING in header else None
    return Recorded(values[:, 0] - values[0, 0], values[:, 1].copy(), values[:, 2].copy(), heading)


def _numbers(path: object, number: int, header: list[str], row: list[str], wanted: list[str]) -> list[float]:
    if len(row) != len(header):
        raise ParameterError("file", f"{path}, line {number}: expected {len(header)} cells, got {len(row)}")
    found = []
    for name in wanted:
        cell = row[header.index(name)].strip()
        try:
            value = float(cell)
        except ValueError:
            value = math.nan
        if not abs(value) < 1e12:  # nor nan
            raise ParameterError("file", f"{path}, line {number}: expected a finite {name}, got {cell!r}")
        found.append(value)
    return found


@functools.lru_cache(maxsize=256)
def _known(path: str, _stamp: int) -> Recorded:
    return read_track(path)


@attrs.frozen(kw_only=True)
class Track(Motion):
    """Repeats a recorded track: at each time where the recording has it, straight on between its lines.

    The file is CSV, headed ``time,x,y`` or ``time,x,y,heading_deg``, times in seconds, places in metres of the world.
    Without headings the body faces its direction of motion. An obstacle without a pose starts where the track starts.
    From elsewhere, and after it was blocked, it moves to its place on the track at `speed_max`.
    """

    file: str = parameter(file=True, static=True, help="the CSV file of the track")
    repeat: bool = parameter(False, help="whether the track starts again at its end, by way of its start")
    speed_max: float | None = parameter(
        None, unit="m/s", gt=0, help="at most this fast, when it is late; none: as fast as the track's fastest part"
    )
    turn_rate: float = parameter(3.0, unit="rad/s", ge=0, help="how fast it turns, while it goes on")
    blocked: str = parameter(
        "wait",
        choices=("wait", "skip"),
        help="when something is in the way: the recording waits meanwhile, or runs on, and what was missed is skipped",
    )

    def __attrs_post_init__(self) -> None:
        read_track(self.file)

    def default_start(self) -> tuple[float, float, float]:
        """Where the track begins."""
        track = read_track(self.file)
        heading = float(track.heading[0]) if track.heading is not None else 0.0
        return float(track.x[0]), float(track.y[0]), heading

    def goal_points(self) -> Sequence[tuple[str, float, float]]:
        """The places of the recording."""
        track = read_track(self.file)
        return [("file", x, y) for x, y in zip(track.x.tolist(), track.y.tolist(), strict=True)]

    def start(self, context: Context) -> State:
        """The recording's time [s], and its file's age: a file changed meanwhile is not read again.

        Raises
        ------
        ComponentError
            If the file is gone meanwhile, or is no longer a track.
        """
        rows = context.rows
        try:
            stamp = Path(self.file).stat().st_mtime_ns
            _known(self.file, stamp)
        except (OSError, ParameterError) as error:  # it was valid when this object was made
            raise ComponentError(f"track {self.file!r} is there no more, or not as it was: {error}") from error
        return {
            "time": np.zeros((rows, 1)),
            "step": np.zeros((rows, 1)),
            "stamp": np.full((rows, 1), stamp, dtype=np.int64),
        }

    def propose(self, view: View, dt: float, state: State, draws: Draws) -> Array:
        """Towards the recording's place at the end of the step."""
        track = _known(self.file, int(state["stamp"][0, 0]))
        time = state["time"]
        if self.blocked == "wait":
            # A blocked body has gone only part of the way, and the recording's time with it.
            time = time - state["step"] * (1.0 - view.free)
        state["time"], state["step"] = time + dt, np.full_like(time, dt)
        last = float(track.time[-1])
        now = state["time"]
        now = now - np.floor(now / last) * last if self.repeat else np.minimum(now, last)
        dx = np.interp(now, track.time, track.x) - view.body_pose[:, :1]
        dy = np.interp(now, track.time, track.y) - view.body_pose[:, 1:2]
        distance = np.sqrt(dx * dx + dy * dy)
        far = (track.fastest if self.speed_max is None else self.speed_max) * dt * (1.0 + 1e-9)
        share = np.where(distance > far, far / np.where(distance > far, distance, 1.0), 1.0)
        dx, dy = share * dx, share * dy
        most = np.asarray(self.turn_rate * dt)
        if track.heading is None:
            turn = facing(view, dx, dy, most)
        else:
            wanted = np.interp(now, track.time, track.heading) - view.body_pose[:, 2:]
            turn = np.clip(wrap_angle(wanted), -most, most)
        return displacement(view, dx, dy, turn)
