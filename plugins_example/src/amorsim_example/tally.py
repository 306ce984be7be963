"""A recorder that counts: one line a robot, how far it drove and how often it hit something."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import attrs
import numpy as np

import amorsim as am


@attrs.define(kw_only=True)
class Tally(am.Recorder):
    """Writes ``tally.csv`` at the end of a run: the distance and the collisions of each robot in each replica.

    Select it with ``also = [{ use = "tally" }]`` under ``[recording]``.
    """

    decimals: int = am.parameter(3, ge=0, le=9, help="of the distances in the file")
    _file: Path | None = attrs.field(default=None, init=False)
    _dt: float = attrs.field(default=0.0, init=False)
    _distance: dict[tuple[int, str], float] = attrs.field(factory=dict, init=False)
    _collisions: dict[tuple[int, str], int] = attrs.field(factory=dict, init=False)

    def open(self, run: am.RunInfo, frames: Sequence[am.Frame]) -> None:
        """Note where the file will be, and every robot there is."""
        self._file, self._dt = run.folder / "tally.csv", run.dt
        for frame in frames:
            for replica, name in zip(frame.replica.tolist(), frame.names, strict=True):
                self._distance[replica, name] = 0.0
                self._collisions[replica, name] = 0

    def write(self, frames: Sequence[am.Frame], events: Sequence[Any]) -> None:
        """Add a step."""
        for frame in frames:
            steps = self._dt * np.hypot(frame.true_twist[:, 0], frame.true_twist[:, 1])
            for replica, name, step in zip(frame.replica.tolist(), frame.names, steps.tolist(), strict=True):
                self._distance[replica, name] += step
        for event in events:
            who = event.replica, event.name
            if event.kind == "collision" and who in self._collisions:  # an obstacle may hit something too
                self._collisions[who] += 1

    def close(self) -> None:
        """Write the file, also of a run that was broken off."""
        if self._file is None:  # never opened
            return
        lines = [
            f"{replica},{name},{distance:.{self.decimals}f},{self._collisions[replica, name]}\n"
            for (replica, name), distance in self._distance.items()
        ]
        self._file.write_text("".join(["replica,robot,distance,collisions\n", *lines]), encoding="utf-8")
