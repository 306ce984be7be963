"""Readings that do not always take the same time to arrive."""

from __future__ import annotations

import attrs
import numpy as np

from amorsim.array_types import Array
from amorsim.contracts import Draws, Noise, State, parameter

__all__ = ["LatencyJitter"]


_CUT = 5.0  # standard deviations; one draw in 1.7 million lies beyond


@attrs.frozen(kw_only=True)
class LatencyJitter(Noise):
    """Lets each reading arrive a random time later or earlier than the sensor's `latency`; leaves the values alone.

    The jitter is independent from reading to reading. No reading arrives before it was taken, nor before an earlier
    reading: one that would overtake another arrives with it. A reading arrives at the first step at or after its time.
    Of several that arrive in one step, the robot gets the latest. A jitter much shorter than the step thus moves only
    readings whose arrival lies near a step.

    Parameters
    ----------
    spread
        ``"uniform"``: the jitter lies between -spread and spread [s]; ``"normal"``: its standard deviation [s], cut
        at five of them.
    distribution
        Distribution of the jitter.
    """

    spread: float = parameter(
        unit="s", ge=0, le=10, live=False, help="half the width of a uniform jitter, standard deviation of a normal one"
    )
    distribution: str = parameter("uniform", choices=("uniform", "normal"), static=True, help="of the jitter")

    def delay(self, elapsed: Array, state: State, draws: Draws) -> Array:
        """Additional delay `(N, 1)` [s] of each row's reading."""
        if self.distribution == "uniform":
            return (2.0 * draws.uniform(1) - 1.0) * self.spread
        return np.minimum(np.maximum(draws.normal(1), -_CUT), _CUT) * self.spread

    def longest_delay(self) -> Array:
        """Upper bound of the delay `(N, 1)` [s]."""
        return np.asarray(self.spread) * (1.0 if self.distribution == "uniform" else _CUT)
