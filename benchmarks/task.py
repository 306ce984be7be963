"""What every side of a fleet's contest has to do: the same robots, from the same poses, along the same ways."""

from __future__ import annotations

import math

import attrs
import numpy as np
import numpy.typing as npt

from benchmarks.worlds import World

__all__ = ["BEAMS", "DT", "FOV", "RADIUS", "RANGE_MAX", "RANGE_STD", "Task", "Track"]

Array = npt.NDArray[np.float64]

BEAMS = 181
FOV = math.pi  # rad, centred about the heading
RANGE_MAX = 8.0  # m
RANGE_STD = 0.005  # m
RADIUS = 0.3  # m, of the discs that stand for robots
DT = 0.1  # s


@attrs.frozen(kw_only=True, eq=False)
class Track:
    """What amorsim's robots did, by step: the measure of all others.

    `mean_range` `(T + 1,)` [m] is that of the scans at the start and after each step; `way` and `stopped` `(T,)` are
    each step's mean way of a robot [m] and the share of robots that neither drove nor turned.
    """

    mean_range: Array
    way: Array
    stopped: Array


@attrs.frozen(kw_only=True, eq=False)
class Task:
    """The robots of a contest: where they start `(N, 3)`, and their twists `(T, N, 2)` [m/s, rad/s], step by step."""

    world: World
    starts: Array
    twists: Array

    @property
    def rows(self) -> int:
        """How many robots there are."""
        return len(self.starts)
