"""A scan that takes its time while the robot moves."""

from __future__ import annotations

import attrs
import numpy as np

from amorsim.array_types import Array
from amorsim.contracts import Aim, Context, Draws, Noise, State, parameter

__all__ = ["MotionDistortion"]


@attrs.frozen(kw_only=True)
class MotionDistortion(Noise):
    """Lets a scan take time: its last beam looks now, its first looked `sweep` before, from where the robot was then.

    The values in between are spread evenly over that time, in their order. During the sweep the robot is assumed to
    move with its mean velocity of the last step; other moving things stay at their current poses. A robot that takes
    all beams at the reading's stamp sees straight walls bent. For lasers, and for rings of sonars whose elements then
    fire one after another.

    Parameters
    ----------
    sweep
        Time from the first value of a reading to the last [s].
    """

    sweep: float = parameter(unit="s", ge=0, help="time from the first value of a reading to the last")

    def start(self, context: Context) -> State:
        """Time at which each value is taken `(N, k)`, in sweeps relative to the last value: from -1 to 0."""
        k = context.size
        order = np.arange(k - 1, -1, -1, dtype=np.float64) / max(k - 1, 1)
        return {"order": np.tile(-order, (context.rows, 1))}

    def aim(self, aim: Aim, elapsed: Array, state: State, draws: Draws) -> Aim:
        """The aim, with each beam at its own time `(N, k)` [s]."""
        time = state["order"] * self.sweep
        return aim._replace(time=time if aim.time is None else aim.time + time)
