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

_NUMBERS = 1 << 15  # kept of one group before they are written
_MOST_STEPS = 512


class Steps:
    """The last steps of one group: one row of a table each, with all that a frame holds, side by side."""

    def __init__(self, frame: Frame | ObstacleFrame) -> None:
        self.first = frame  # what does not change from step to step is read from it
        self.names = Names(frame.names)
        self.count = 0
        self._places: dict[str, tuple[int, tuple[int, ...]]] = {}
        parts = dict(zip(_keys(frame), _parts(frame), strict=True))
        size = 0
        for key, part in parts.items():
            self._places[key] = (size, part.shape)
            size += part.size
        self.most = max(1, min(_MOST_STEPS, _NUMBERS // max(size, 1)))
        self._table = np.empty((self.most, size))

    @property
    def robots(self) -> Frame:
        """The first frame, of a group of robots."""
        assert isinstance(self.first, Frame)
        return self.first

    def add(self, frame: Frame | ObstacleFrame) -> bool:
        """Keep a step, as it is now; whether there is no room for another."""
        np.concatenate(_parts(frame), axis=None, out=self._table[self.count])
        self.count += 1
        return self.count == self.most

    def __getitem__(self, key: str) -> Array:
        """What the frames held by that name, a step each along the first axis; a part of the table itself."""
        first, shape = self._places[key]
        size = int(np.prod(shape))
        part: Array = self._table[: self.count, first : first + size].reshape(self.count, *shape)
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
        return frame.time, frame.true_pose
    found: list[npt.NDArray[Any]] = [
        frame.time,
        frame.true_pose,
        frame.true_twist,
        frame.joint_rates,
        frame.command,
    ]
    for estimate in frame.estimates.values():
        found += (estimate.pose, estimate.covariance)
    for true, reading in frame.readings.values():
        found += (true, reading.measured, reading.stamp, reading.fresh)
    return found
