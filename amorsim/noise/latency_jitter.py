"""Readings that do not always take the same time to arrive."""

from __future__ import annotations

import attrs
import numpy as np
import numpy.typing as npt

from amorsim.contracts import Draws, Noise, State, parameter

__all__ = ["LatencyJitter"]

Array = npt.NDArray[np.float64]

_CUT = 5.0  # standard deviations; one draw in 1.7 million lies beyond


@attrs.frozen(kw_only=True)
class LatencyJitter(Noise):
    """Lets each reading arrive a random time later or earlier than the sensor's `latency`; leaves the values alone.

    Independent from reading to reading. None arrives before it was taken, nor before one that was taken earlier: a
    reading that would overtake another comes with it. Readings arrive at steps, each at the first one at or after its
    time; of several that arrive at one step, the robot has the latest. So a jitter much below the step moves only
    readings whose arrival lies near a step.

    Parameters
    ----------
    spread
        ``"uniform"``: the jitter lies between -spread and spread [s]; ``"normal"``: its standard deviation [s], cut
        at five of them.
    distribution
        Of the jitter.
    """

    spread: float = parameter(
        unit="s", ge=0, le=10, live=False, help="half the width of a uniform jitter, standard deviation of a normal one"
    )
    distribution: str = parameter("uniform", choices=("uniform", "normal"), static=True, help="of the jitter")

    def delay(self, elapsed: Array, state: State, draws: Draws) -> Array:
        """How much later each row's reading arrives `(N, 1)` [s]."""
        if self.distribution == "uniform":
            return (2.0 * draws.uniform(1) - 1.0) * self.spread
        return np.minimum(np.maximum(draws.normal(1), -_CUT), _CUT) * self.spread

    def longest_delay(self) -> Array:
        """What no delay exceeds `(N, 1)` [s]."""
        return np.asarray(self.spread) * (1.0 if self.distribution == "uniform" else _CUT)
