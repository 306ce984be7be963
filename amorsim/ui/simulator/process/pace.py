"""The speed of a simulation relative to real time."""

from __future__ import annotations

import collections

__all__ = ["Pace"]

LONGEST_DEBT = 0.25  # [s] of the clock: what a slow machine is behind by more is not made up for
WINDOW = 1.0  # [s] of the clock, over which the achieved speed is taken


class Pace:
    """When the next step is due. All times are those of the wall clock [s], and are given."""

    def __init__(self) -> None:
        self.factor: float | None = 1.0  # none: as fast as possible
        self._due = 0.0
        self._seen: collections.deque[tuple[float, float]] = collections.deque()

    def start(self, now: float) -> None:
        """Begin to run, or go on at another speed: the next step is due at once."""
        self._due = now
        self._seen.clear()
        self._seen.append((now, 0.0))

    def wait(self, now: float) -> float:
        """How long until the next step is due [s]; 0 if it is."""
        return 0.0 if self.factor is None else max(0.0, self._due - now)

    def stepped(self, now: float, dt: float) -> None:
        """Note that a step of `dt` [s] was made."""
        if self.factor is not None:
            self._due = max(self._due + dt / self.factor, now - LONGEST_DEBT)
        time, total = self._seen[-1]
        if now - time < WINDOW / 20.0 and len(self._seen) > 1:
            self._seen[-1] = (time, total + dt)
        else:
            self._seen.append((now, total + dt))
        while len(self._seen) > 2 and now - self._seen[1][0] > WINDOW:
            self._seen.popleft()

    def achieved(self, now: float) -> float:
        """Simulated seconds in a second of the clock, of late."""
        if len(self._seen) < 2:
            return 0.0
        elapsed = now - self._seen[0][0]
        return (self._seen[-1][1] - self._seen[0][1]) / elapsed if elapsed > 0.0 else 0.0
