"""An error in proportion to the value."""

from __future__ import annotations

from collections.abc import Mapping

import attrs
import numpy as np
import numpy.typing as npt

from amorsim.contracts import Draws, Noise, State, parameter

__all__ = ["Scale"]

Array = npt.NDArray[np.float64]


@attrs.frozen(kw_only=True)
class Scale(Noise):
    """Multiplies every value by the same factor; inf stays inf.

    Parameters
    ----------
    factor
        The factor; 1 changes nothing.
    """

    factor: float = parameter(gt=0, help="what every value is multiplied by")

    def corrupt(self, values: Array, side: Mapping[str, Array], elapsed: Array, state: State, draws: Draws) -> Array:
        """The values `(N, k)` times the factor."""
        return values * self.factor
