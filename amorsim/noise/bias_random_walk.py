"""A zero that wanders off."""

from __future__ import annotations

from collections.abc import Mapping

import attrs
import numpy as np

from amorsim.array_types import Array
from amorsim.contracts import Context, Draws, Noise, State, parameter

__all__ = ["BiasRandomWalk"]


@attrs.frozen(kw_only=True)
class BiasRandomWalk(Noise):
    """Adds a bias that starts at 0 and walks at random with time, a walk of its own for each value; inf stays inf.

    Between two samples the bias changes by normal noise. The variance is proportional to the time between them,
    so the walk does not depend on the rate of samples. For a gyro this is the rate random walk K of IEEE Std 952,
    with an Allan deviation of K sqrt(t / 3).

    Parameters
    ----------
    std
        Standard deviation of the bias one second after the start, in the sensor's unit; it grows with the
        square root of the time.
    """

    std: float = parameter(unit="sensor", ge=0, help="standard deviation of the bias after 1 s, per root second")

    def start(self, context: Context) -> State:
        """A bias `(N, k)` of 0."""
        return {"bias": np.zeros((context.rows, context.size))}

    def corrupt(self, values: Array, side: Mapping[str, Array], elapsed: Array, state: State, draws: Draws) -> Array:
        """The values `(N, k)` plus the current bias."""
        bias = state["bias"] + draws.normal(values.shape[1]) * (np.sqrt(elapsed) * self.std)
        state["bias"] = bias
        # Subtracting +0.0 keeps the sign of a zero; adding it would not.
        return values - (0.0 - bias)
