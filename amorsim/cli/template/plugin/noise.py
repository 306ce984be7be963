"""A noise: an error that is larger for larger values."""

from __future__ import annotations

from collections.abc import Mapping

import attrs
import numpy as np
import numpy.typing as npt

import amorsim as am

__all__ = ["Blur"]

Array = npt.NDArray[np.float64]


@attrs.frozen(kw_only=True)
class Blur(am.Noise):
    """Adds normal noise in proportion to each value; inf, which means that nothing returned, stays inf.

    Parameters
    ----------
    share
        Standard deviation per unit of the value's size.
    """

    share: float = am.parameter(0.01, ge=0, help="standard deviation per unit of the value's size")

    def corrupt(
        self, values: Array, side: Mapping[str, Array], elapsed: Array, state: am.State, draws: am.Draws
    ) -> Array:
        """The values `(N, k)` with the error on them."""
        # As many draws in every step, whatever the values are.
        return values * (1.0 + self.share * draws.normal(values.shape[1]))
