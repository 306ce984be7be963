"""A recorder: the fastest speed of each robot, in a file of its own."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import attrs
import numpy as np

import amorsim as am

__all__ = ["TopSpeed"]


@attrs.define(kw_only=True)
class TopSpeed(am.Recorder):
    """Writes ``top-speed.csv`` at the end of a run: the fastest speed [m/s] of each robot in each replica.

    Select it with ``also = [{ use = ... }]`` under ``[recording]``.
    """

    decimals: int = am.parameter(3, ge=0, le=9, help="of the speeds in the file")
    _file: Path | None = attrs.field(default=None, init=False)
    _fastest: dict[tuple[int, str], float] = attrs.field(factory=dict, init=False)

    def open(self, run: am.RunInfo, frames: Sequence[am.Frame]) -> None:
        """Note where the file will be; the frames are those of the start."""
        self._file = run.folder / "top-speed.csv"
        self.write(frames, ())

    def write(self, frames: Sequence[am.Frame], events: Sequence[Any]) -> None:
        """Look at a step."""
        for frame in frames:
            speeds = np.hypot(frame.true_twist[:, 0], frame.true_twist[:, 1]).tolist()
            for replica, name, speed in zip(frame.replica.tolist(), frame.names, speeds, strict=True):
                self._fastest[replica, name] = max(speed, self._fastest.get((replica, name), 0.0))

    def close(self) -> None:
        """Write the file, also of a run that was broken off."""
        if self._file is None:  # never opened
            return
        lines = [f"{replica},{name},{speed:.{self.decimals}f}\n" for (replica, name), speed in self._fastest.items()]
        self._file.write_text("".join(["replica,robot,speed\n", *lines]), encoding="utf-8")
