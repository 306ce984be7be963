"""A constant error."""

from __future__ import annotations

from collections.abc import Mapping

import attrs
import numpy as np
import numpy.typing as npt

from amorsim.contracts import Draws, Noise, State, parameter

__all__ = ["Bias"]

Array = npt.NDArray[np.float64]


@attrs.frozen(kw_only=True)
class Bias(Noise):
    """Adds the same to every value; inf stays inf.

    Parameters
    ----------
    value
        What is added, in the sensor's unit.
    """

    value: float = parameter(unit="sensor", help="what is added")

    def corrupt(self, values: Array, side: Mapping[str, Array], elapsed: Array, state: State, draws: Draws) -> Array:
        """The values `(N, k)` and the bias."""
        # Taking +0.0 away keeps even the sign of a zero, which adding it would not.
        return values - (0.0 - self.value)
