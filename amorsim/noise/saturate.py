"""Values within a device's range."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import attrs
import numpy as np
import numpy.typing as npt

from amorsim.contracts import Draws, Noise, State, parameter
from amorsim.core.parameters import ParameterError
from amorsim.kernels.sensing import noise_elements

__all__ = ["Saturate"]

Array = npt.NDArray[np.float64]
_NO_LEAST, _NO_MOST = np.full((1, 1), -math.inf), np.full((1, 1), math.inf)
_NO_LEAST.flags.writeable = _NO_MOST.flags.writeable = False


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
        least: Any = _NO_LEAST if self.minimum is None else self.minimum
        most: Any = _NO_MOST if self.maximum is None else self.maximum
        held = np.empty(values.shape)
        noise_elements.hold_within(values, least, most, held)
        return held
