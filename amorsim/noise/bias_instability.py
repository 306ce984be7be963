"""A zero that wanders about."""

from __future__ import annotations

from collections.abc import Mapping

import attrs
import numpy as np
import numpy.typing as npt

from amorsim.contracts import Context, Draws, Noise, State, parameter
from amorsim.kernels.sensing import noise_elements

__all__ = ["BiasInstability"]

Array = npt.NDArray[np.float64]


@attrs.frozen(kw_only=True)
class BiasInstability(Noise):
    """Adds a bias that wanders about 0 and forgets where it was: a first-order Gauss-Markov process; inf stays inf.

    It has the same spread from the first sample on, and a correlation of exp(-t / correlation_time) with itself
    a time t later, however often the device reads. Real bias instability is flicker noise, with an Allan
    deviation that is flat over decades; one such process has a broad hump instead, 0.617 std high at 1.89
    correlation times. Several elements with correlation times a decade apart, and one std, come near a flat
    floor.

    Parameters
    ----------
    std
        Standard deviation of the bias, in the sensor's unit.
    correlation_time
        After which the correlation has fallen to 1/e [s].
    """

    std: float = parameter(unit="sensor", ge=0, help="standard deviation of the bias")
    correlation_time: float = parameter(unit="s", gt=0, help="after which its correlation has fallen to 1/e")

    def start(self, context: Context) -> State:
        """The process `(N, k)` in standard deviations; its first value is drawn with the first sample."""
        return {"process": np.zeros((context.rows, context.size))}

    def corrupt(self, values: Array, side: Mapping[str, Array], elapsed: Array, state: State, draws: Draws) -> Array:
        """The values `(N, k)` and the bias of now."""
        ratio = -elapsed / self.correlation_time
        process, out = draws.normal(values.shape[1]), np.empty(values.shape)
        noise_elements.wander(
            values, state["process"], elapsed, np.exp(ratio), np.expm1(2.0 * ratio), self.std, process, out
        )
        state["process"] = process
        return out
