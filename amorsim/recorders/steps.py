"""Steps of a group of robots or obstacles as plain numbers, kept until they are worth writing."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from amorsim.contracts import Frame, ObstacleFrame
from amorsim.recorders.lines import Names

__all__ = ["Steps"]

Array = npt.NDArray[np.float64]

_NUMBERS = 1 << 17  # kept of one group before they are written
_MOST_STEPS = 512


class Steps:
    """The last steps of one group: a table of robots or obstacles each, with all that a frame holds, side by side."""

    def __init__(self, frame: Frame | ObstacleFrame) -> None:
        self.first = frame  # what does not change from step to step is read from it
        self.names = Names(frame.names)
        self.count = 0
        self._places: dict[str, slice] = {}
        width = 0
        for key, part in zip(_keys(frame), _parts(frame), strict=True):
            self._places[key] = slice(width, width + part.shape[1])
            width += part.shape[1]
        rows = len(frame.names)
        self.most = max(1, min(_MOST_STEPS, _NUMBERS // max(rows * width, 1)))
        self._table = np.empty((self.most, rows, width))

    @property
    def robots(self) -> Frame:
        """The first frame, of a group of robots."""
        assert isinstance(self.first, Frame)
        return self.first

    def add(self, frame: Frame | ObstacleFrame) -> bool:
        """Keep a step, as it is now; whether there is no room for another."""
        np.concatenate(_parts(frame), axis=1, out=self._table[self.count])
        self.count += 1
        return self.count == self.most

    def __getitem__(self, key: str) -> Array:
        """What the frames held by that name, `(steps, rows, values)`; a part of the table itself."""
        part: Array = self._table[: self.count, :, self._places[key]]
        return part


def _keys(frame: Frame | ObstacleFrame) -> list[str]:
    if isinstance(frame, ObstacleFrame):
        return ["time", "true_pose"]
    found = ["time", "true_pose", "true_twist", "joint_rates", "command"]
    for name in frame.estimates:
        found += [f"pose {name}", f"covariance {name}"]
    for name in frame.readings:
        found += [f"{what} {name}" for what in ("true", "measured", "stamp", "fresh")]
    return found


def _parts(frame: Frame | ObstacleFrame) -> Sequence[npt.NDArray[Any]]:
    if isinstance(frame, ObstacleFrame):
        return frame.time[:, None], frame.true_pose
    found: list[npt.NDArray[Any]] = [
        frame.time[:, None],
        frame.true_pose,
        frame.true_twist,
        frame.joint_rates,
        frame.command,
    ]
    for estimate in frame.estimates.values():
        found += (estimate.pose, estimate.covariance.reshape(-1, 9))
    for true, reading in frame.readings.values():
        found += (true, reading.measured, reading.stamp, reading.fresh)
    return found
