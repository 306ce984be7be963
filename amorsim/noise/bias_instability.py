"""A zero that wanders about."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import attrs
import numpy as np

from amorsim.array_types import Array
from amorsim.contracts import Context, Draws, Noise, State, parameter
from amorsim.kernels.sensing import noise_elements

__all__ = ["BiasInstability"]


@attrs.frozen(kw_only=True)
class BiasInstability(Noise):
    """Adds a bias that wanders about 0 and forgets where it was: a first-order Gauss-Markov process; inf stays inf.

    The spread is the same from the first sample on. The correlation with the bias a time t later is
    exp(-t / correlation_time), at any rate of samples. Real bias instability is flicker noise: its Allan
    deviation is flat over decades. One such process has a broad hump instead, 0.617 std high at 1.89
    correlation times. Several elements with the same std and correlation times a decade apart come near a
    flat floor.

    Parameters
    ----------
    std
        Standard deviation of the bias, in the sensor's unit.
    correlation_time
        Time after which the correlation has fallen to 1/e [s].
    """

    std: float = parameter(unit="sensor", ge=0, help="standard deviation of the bias")
    correlation_time: float = parameter(unit="s", gt=0, help="after which its correlation has fallen to 1/e")

    def start(self, context: Context) -> State:
        """The process `(N, k)` in standard deviations; its first value is drawn with the first sample."""
        return {"process": np.zeros((context.rows, context.size))}

    def corrupt(self, values: Array, side: Mapping[str, Array], elapsed: Array, state: State, draws: Draws) -> Array:
        """The values `(N, k)` plus the current bias."""
        process, out = draws.normal(values.shape[1]), np.empty(values.shape)
        time: Any = self.correlation_time
        noise_elements.wander(values, state["process"], elapsed, self.std, time, process, out)
        state["process"] = process
        return out
