"""Many replicas over time: their mean, their spread, and the interval of the mean."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from amorsim.algorithms.intervals import mean_interval
from amorsim.array_types import Array, Ints
from amorsim.core.arguments import numbers, real
from amorsim.core.parameters import ParameterError

__all__ = ["Ensemble", "ensemble"]


class Ensemble(NamedTuple):
    """Figures of replicas at each time, `(S,)` each; nan where too few replicas have a value.

    Attributes
    ----------
    counts
        How many replicas have a value.
    mean, low, high
        The mean, and its interval (`mean_interval`).
    rms
        The root of the mean square.
    median, lower, upper
        The median and the quartiles: half of the replicas lie between these.
    interquartile_mean
        The mean of the middle half, which a few replicas that went astray do not move.
    """

    counts: Ints
    mean: Array
    low: Array
    high: Array
    rms: Array
    median: Array
    lower: Array
    upper: Array
    interquartile_mean: Array


def ensemble(values: npt.ArrayLike, *, confidence: float = 0.95) -> Ensemble:
    """Figures of values `(S, R)` of R replicas at S times; nan is not a value.

    Parameters
    ----------
    confidence
        Of the interval of the mean.

    Raises
    ------
    ValueError
        If the values have another shape, or the confidence is not between 0 and 1.
    """
    given = numbers(values, "values", ("times", "replicas"))
    expected = "a number between 0 and 1"
    if not 0.0 < real(confidence, "confidence", expected) < 1.0:
        raise ParameterError("confidence", f"expected {expected}, got {confidence!r}")
    figures = np.full((8, len(given)), math.nan)
    counts = np.count_nonzero(~np.isnan(given), axis=1)
    for step, here in enumerate(given):
        there = np.sort(here[~np.isnan(here)])
        if not len(there):
            continue
        mean = mean_interval(there, confidence)
        cut = len(there) // 4
        middle = there[cut : len(there) - cut].tolist()
        quartiles = np.quantile(there, (0.5, 0.25, 0.75)).tolist()
        rms = math.sqrt(math.fsum((there**2).tolist()) / len(there))
        figures[:, step] = *mean[:3], rms, *quartiles, math.fsum(middle) / len(middle)
    return Ensemble(counts, *figures)
