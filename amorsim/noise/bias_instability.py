"""A zero that wanders about."""

from __future__ import annotations

from collections.abc import Mapping

import attrs
import numpy as np
import numpy.typing as npt

from amorsim.contracts import Context, Draws, Noise, State, parameter

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
        ratio = elapsed / self.correlation_time
        # Over a time without end at the first sample: what is remembered is nothing.
        remembered = np.where(elapsed > 0.0, np.exp(-ratio), 0.0)
        fresh = np.where(elapsed > 0.0, np.sqrt(-np.expm1(-2.0 * ratio)), 1.0)
        process = state["process"] * remembered + draws.normal(values.shape[1]) * fresh
        state["process"] = process
        # Taking +0.0 away keeps even the sign of a zero, which adding it would not.
        return values - (0.0 - process * self.std)
