"""Values in whole steps."""

from __future__ import annotations

from collections.abc import Mapping

import attrs
import numpy as np
import numpy.typing as npt

from amorsim.contracts import Draws, Noise, State, parameter

__all__ = ["Quantize"]

Array = npt.NDArray[np.float64]


@attrs.frozen(kw_only=True)
class Quantize(Noise):
    """Rounds every value to a multiple of a step; inf stays inf.

    Parameters
    ----------
    step
        Between two values that can be told apart, in the sensor's unit.
    rounding
        ``"nearest"``, halfway cases to the even multiple; or ``"floor"``, downwards, as a counter does.
    """

    step: float = parameter(unit="sensor", gt=0, help="between two values that can be told apart")
    rounding: str = parameter(
        "nearest", choices=("nearest", "floor"), static=True, help="to the nearest multiple, or down to one"
    )

    def corrupt(self, values: Array, side: Mapping[str, Array], elapsed: Array, state: State, draws: Draws) -> Array:
        """The values `(N, k)`, rounded."""
        steps = values / self.step
        steps = np.rint(steps, out=steps) if self.rounding == "nearest" else np.floor(steps, out=steps)
        steps *= self.step
        return steps
