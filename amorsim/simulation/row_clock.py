"""The time of each row: its replica, episode and tick, in the forms that components and draws need."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from amorsim.contracts import Clock

__all__ = ["RowClock"]


class RowClock:
    """The time of N rows. `counter` is the counter of random draws and changes in place; other arrays are replaced."""

    __slots__ = ("always", "clock", "counter", "dt", "elapsed", "now", "replica", "step", "tick", "time")

    def __init__(self, replica: npt.NDArray[np.int64], dt: float) -> None:
        self.replica = replica
        self.dt = dt
        self.always = np.ones((len(replica), 1), dtype=bool)
        self.step = np.full((len(replica), 1), dt)  # [s] since the previous step, after the first
        self.now = np.zeros((len(replica), 1))  # [s], the age of values of this tick
        self.counter = np.zeros((len(replica), 3), dtype=np.uint32)
        self.counter[:, 0] = replica
        self.set_tick(np.zeros((len(replica), 1), dtype=np.int64))

    def set_tick(self, tick: npt.NDArray[np.int64]) -> None:
        """Put every row to its tick `(N, 1)`."""
        self.tick = tick
        # Multiplied, not summed: the time is still right after a billion steps.
        self.time: npt.NDArray[np.float64] = np.multiply(tick, self.dt, dtype=np.float64)
        self.elapsed = np.where(tick > 0, self.dt, 0.0)  # [s] since the previous step
        self.clock = Clock(tick=tick, time=self.time, dt=self.dt)
        self.counter[:, 2] = tick[:, 0]

    def advance(self) -> None:
        """Put every row to the next tick."""
        tick = self.tick + 1
        self.take(tick, np.multiply(tick, self.dt))
        self.counter[:, 2] = tick[:, 0]

    def take(self, tick: npt.NDArray[np.int64], time: npt.NDArray[np.float64]) -> None:
        """Take the next tick of every row, and its time; the caller updates `counter`."""
        self.tick, self.time, self.elapsed = tick, time, self.step
        self.clock = Clock(tick, time, self.dt)

    def set_episode(self, episode: npt.NDArray[np.int64]) -> None:
        """Put every row to its episode `(N,)`."""
        self.counter[:, 1] = episode
