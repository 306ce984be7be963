"""Values that freeze for a while."""

from __future__ import annotations

from collections.abc import Mapping

import attrs
import numpy as np

from amorsim.array_types import Array
from amorsim.contracts import Context, Draws, Noise, State, parameter
from amorsim.kernels import elementary

__all__ = ["Stuck"]


@attrs.frozen(kw_only=True)
class Stuck(Noise):
    """Freezes a value now and then: for a while the device goes on reporting what it reported last.

    Faults come at random, `rate` of them a second on average, and last for an exponentially distributed time. Each
    value is thus a sampled Markov chain of two states in continuous time. It is frozen for the fraction
    rate * duration / (1 + rate * duration) of the time, at any rate of samples. The first sample is always sound.

    Parameters
    ----------
    rate
        Faults a second, of a value that is sound.
    duration
        Mean time that a fault lasts [s].
    scope
        What freezes at once: each ``"value"`` by itself, or all values of the ``"sensor"``.
    """

    rate: float = parameter(unit="1/s", ge=0, help="faults a second")
    duration: float = parameter(unit="s", gt=0, help="mean time that a fault lasts")
    scope: str = parameter(
        "value", choices=("value", "sensor"), static=True, help="what freezes at once: each value, or the sensor"
    )

    def start(self, context: Context) -> State:
        """State: which values are frozen `(N, k)`, and the last reported ones `(N, k)`."""
        shape = (context.rows, context.size)
        return {"frozen": np.zeros(shape, dtype=bool), "last": np.zeros(shape)}

    def corrupt(self, values: Array, side: Mapping[str, Array], elapsed: Array, state: State, draws: Draws) -> Array:
        """The values `(N, k)`, with the last reported ones in place of those that are frozen."""
        k = values.shape[1]
        chance = draws.uniform(k if self.scope == "value" else 1)
        recovery = 1.0 / self.duration
        both = self.rate + recovery
        # Transition of a two-state chain over the elapsed time, including faults that began and ended within it.
        moved = -elementary.expm1(-both * elapsed) / both
        frozen = np.where(state["frozen"], chance >= recovery * moved, chance < self.rate * moved)
        reported = np.where(frozen, state["last"], values)
        state["frozen"] = frozen
        state["last"] = reported
        return reported
