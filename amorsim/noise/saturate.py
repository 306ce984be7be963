"""Values within a device's range."""

from __future__ import annotations

import math
from collections.abc import Mapping

import attrs
import numpy as np
import numpy.typing as npt

from amorsim.contracts import Draws, Noise, State, parameter
from amorsim.core.parameters import ParameterError

__all__ = ["Saturate"]

Array = npt.NDArray[np.float64]


@attrs.frozen(kw_only=True)
class Saturate(Noise):
    """Values beyond the range of a device read as its end; inf stays inf, for it says that nothing returned.

    Parameters
    ----------
    minimum, maximum
        The ends of the range, in the sensor's unit; none for no end.
    """

    minimum: float | None = parameter(None, unit="sensor", help="lowest value; none for no end")
    maximum: float | None = parameter(None, unit="sensor", help="highest value; none for no end")

    def __attrs_post_init__(self) -> None:
        low, high = self.minimum, self.maximum
        if low is not None and high is not None and low > high:
            raise ParameterError("minimum", f"expected no more than maximum {high!r}, got {low!r}")

    def corrupt(self, values: Array, side: Mapping[str, Array], elapsed: Array, state: State, draws: Draws) -> Array:
        """The values `(N, k)`, none beyond the ends."""
        held = values
        if self.minimum is not None:
            held = np.where(held < self.minimum, self.minimum, held)
        if self.maximum is not None:
            held = np.where((held > self.maximum) & (held < math.inf), self.maximum, held)
        return held
