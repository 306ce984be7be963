"""White noise, on each sample or accumulating."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import attrs
import numpy as np

from amorsim.array_types import Array
from amorsim.contracts import Context, Draws, Noise, NoiseStep, State, parameter
from amorsim.kernels.sensing import readings

__all__ = ["Gaussian"]


@attrs.frozen(kw_only=True)
class Gaussian(Noise):
    """Adds normal noise of mean 0, independent from sample to sample and from value to value; inf stays inf.

    Parameters
    ----------
    std
        Standard deviation, in the sensor's unit.
    proportional
        A further standard deviation per unit of the value's size, or with ``per = "increment"`` of its change; the
        two are added.
    per
        ``"sample"``: every sample is the value plus fresh noise. ``"increment"``: each change from sample to sample
        adds noise that stays. The error is then a random walk: slip of a counter, drift of a zero. The first sample
        has none.
    """

    std: float = parameter(0.0, unit="sensor", ge=0, help="standard deviation")
    proportional: float = parameter(0.0, ge=0, help="further standard deviation per unit of the value's size")
    per: str = parameter(
        "sample",
        choices=("sample", "increment"),
        static=True,
        help="whether each sample has its own, or it adds up",
    )

    def start(self, context: Context) -> State:
        """The walk so far `(N, k)` and the last values, if the noise accumulates."""
        if self.per == "sample":
            return {}
        shape = (context.rows, context.size)
        return {"walk": np.zeros(shape), "last": np.zeros(shape)}

    def steps(self) -> Sequence[NoiseStep]:
        """Scatter each sample, unless the noise accumulates."""
        return [NoiseStep.scatter(self.std, self.proportional)] if self.per == "sample" else ()

    def corrupt(self, values: Array, side: Mapping[str, Array], elapsed: Array, state: State, draws: Draws) -> Array:
        """The values `(N, k)` with noise on them."""
        if self.per == "sample":
            return super().corrupt(values, side, elapsed, state, draws)
        noise = draws.normal(values.shape[1])
        walk = state["walk"]
        finite = np.isfinite(values)
        # Without a previous value, or without a return, the change is 0.
        change = np.where((elapsed > 0.0) & finite, values - state["last"], 0.0)
        readings.scatter(walk, change, self.std, self.proportional, noise)
        walk = np.where(elapsed > 0.0, noise, walk)
        state["walk"] = walk
        state["last"] = np.where(finite, values, state["last"])
        return np.where(walk == 0.0, values, values + walk)
