"""Now and then a value that is far off."""

from __future__ import annotations

from collections.abc import Mapping

import attrs
import numpy as np

from amorsim.array_types import Array
from amorsim.contracts import Draws, Noise, State, parameter

__all__ = ["Outliers"]


@attrs.frozen(kw_only=True)
class Outliers(Noise):
    """Adds to each value, with a probability, a normal error of mean 0 and large spread; inf stays inf.

    With white noise before it in the chain, values follow the contaminated normal distribution of J. W. Tukey
    ("A survey of sampling from contaminated distributions", 1960).

    Parameters
    ----------
    probability
        Probability of an outlier, independent for each value and sample.
    std
        Standard deviation of an outlier's error, in the sensor's unit.
    """

    probability: float = parameter(ge=0, le=1, help="that a value is an outlier")
    std: float = parameter(unit="sensor", ge=0, help="standard deviation of an outlier's error")

    def corrupt(self, values: Array, side: Mapping[str, Array], elapsed: Array, state: State, draws: Draws) -> Array:
        """The values `(N, k)`, some of them far off."""
        k = values.shape[1]
        is_outlier = draws.uniform(k) < self.probability
        error = np.where(is_outlier, draws.normal(k) * self.std, 0.0)
        # Subtracting +0.0 keeps the sign of a zero; adding it would not.
        return values - (0.0 - error)
