"""The time of each row: its replica, episode and tick, in the forms that components and draws need."""

from __future__ import annotations

import numpy as np

from amorsim.array_types import Ints
from amorsim.contracts import Clock
from amorsim.kernels.clock import advance_clocks

__all__ = ["RowClock"]


class RowClock:
    """The time of N rows. Its arrays change in place, except `elapsed`, which is replaced."""

    __slots__ = ("always", "counter", "dt", "elapsed", "now", "replica", "step", "tick", "time")

    def __init__(self, replica: Ints, dt: float) -> None:
        self.replica = replica
        self.dt = dt
        self.always = np.ones((len(replica), 1), dtype=bool)
        self.step = np.full((len(replica), 1), dt)  # [s] since the previous step, after the first
        self.now = np.zeros((len(replica), 1))  # [s], the age of values of this tick
        self.tick = np.zeros((len(replica), 1), dtype=np.int64)
        self.time = np.zeros((len(replica), 1))
        self.elapsed = self.now  # [s] since the previous step
        self.counter = np.zeros((len(replica), 3), dtype=np.uint32)  # of random draws
        self.counter[:, 0] = replica

    @property
    def clock(self) -> Clock:
        """The time for components, in copies."""
        return Clock(tick=self.tick.copy(), time=self.time.copy(), dt=self.dt)

    def set_tick(self, tick: Ints) -> None:
        """Put every row to its tick `(N, 1)`."""
        self.tick[...] = tick - 1
        self.advance()
        self.elapsed = np.where(tick > 0, self.dt, 0.0)

    def advance(self) -> None:
        """Advance every row to the next tick."""
        advance_clocks(self.tick, self.dt, self.time, self.counter)
        self.elapsed = self.step

    def set_episode(self, episode: Ints) -> None:
        """Put every row to its episode `(N,)`."""
        self.counter[:, 1] = episode
