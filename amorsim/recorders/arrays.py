"""Beliefs of estimators and intentions of controllers as arrays: all that is too large for a text file."""

from __future__ import annotations

import io
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import attrs
import numpy as np

from amorsim.contracts import Frame, Recorder, RunInfo, parameter
from amorsim.core.errors import RunError, did_you_mean
from amorsim.core.files.atomic_files import write_bytes

__all__ = ["Arrays"]


@attrs.define(kw_only=True, eq=False)
class Arrays(Recorder):
    """Writes all beliefs of estimators and of the controller into ``beliefs/NAME/TICK.npz``, one file for each time.

    A file has each belief by its name, first axis the row, and ``time`` [s], ``robot`` and ``replica`` of each row.
    With robots of several kinds each has a file, ``TICK-0.npz`` and on. ``numpy.load`` reads them.

    Parameters
    ----------
    every
        Time between two files [s]; the first is of the start.
    of
        Names of the estimators whose beliefs are written, and ``"controller"`` for what the controller intends; without
        any name, all.
    """

    every: float = parameter(1.0, unit="s", gt=0, help="time between two files")
    of: tuple[str, ...] = parameter((), help='names of estimators, or "controller"; empty: all')

    _run: RunInfo | None = attrs.field(default=None, init=False)
    _next: float = attrs.field(default=0.0, init=False)

    def open(self, run: RunInfo, frames: Sequence[Frame]) -> None:
        """Write the beliefs at the start.

        Raises
        ------
        RunError
            If `of` names what has no beliefs.
        """
        known = sorted({name for frame in frames for name in frame.beliefs})
        for name in self.of:
            if name not in known:
                raise RunError(
                    f"recorder arrays, of: {name!r} has no beliefs; those that have: {', '.join(known) or 'none'}."
                    f"{did_you_mean(name, known)}"
                )
        self._run = run
        self.write(frames, ())

    def write(self, frames: Sequence[Frame], events: Sequence[Any]) -> None:
        """Write the beliefs if it is time."""
        if self._run is None or not frames:
            return
        tick = int(frames[0].tick[0])
        if tick * self._run.dt < self._next - 1e-9:
            return
        self._next += self.every
        folder = Path(self._run.folder) / "beliefs"
        for number, frame in enumerate(frames):
            part = f"-{number}" if len(frames) > 1 else ""
            for name in frame.beliefs:
                if self.of and name not in self.of:
                    continue
                beliefs = frame.beliefs[name]
                if not beliefs:
                    continue
                data = io.BytesIO()
                names: Any = np.array(list(frame.names))
                whole: dict[str, Any] = {**beliefs, "time": frame.time, "robot": names, "replica": frame.replica}
                np.savez_compressed(data, **whole)
                (folder / name).mkdir(parents=True, exist_ok=True)
                write_bytes(folder / name / f"{tick:09d}{part}.npz", data.getvalue())

    def close(self) -> None:
        """Does nothing: no file is open."""
