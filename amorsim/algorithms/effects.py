"""Effect sizes of paired differences, and the correction of p-values for their number."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from amorsim.array_types import Array
from amorsim.core.arguments import numbers
from amorsim.core.parameters import ParameterError

__all__ = ["holm", "paired_effect"]


def paired_effect(differences: Array) -> float:
    """Cohen's d of paired differences: their mean over their standard deviation; inf if all are alike, and not 0.

    One difference alone has no deviation, and nan as its effect.
    """
    differences = numbers(differences, "differences", ("n",))
    if not len(differences):
        raise ParameterError("differences", "expected one at least, got none")
    if len(differences) == 1:
        return math.nan
    mean = float(np.mean(differences))
    spread = float(np.std(differences, ddof=1))
    if spread <= 1e-12 * abs(mean):
        return math.copysign(math.inf, mean) if mean else 0.0
    return mean / spread


def holm(p_values: Sequence[float]) -> list[float]:
    """p-values corrected for their number (Holm 1979): below 0.05, they are significant together at 5 %.

    A nan is of no test: it stays, and does not count.
    """
    p_values = numbers(p_values, "p_values", ("n",)).tolist()
    tests = [place for place, value in enumerate(p_values) if not math.isnan(value)]
    corrected, largest = [math.nan] * len(p_values), 0.0
    for rank, place in enumerate(sorted(tests, key=p_values.__getitem__)):
        largest = max(largest, min(1.0, (len(tests) - rank) * p_values[place]))
        corrected[place] = largest
    return corrected
