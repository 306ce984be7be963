"""The interval of a mean, and its p-value: one computation for all that prints an interval."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from amorsim.array_types import Array
from amorsim.core.arguments import numbers, real
from amorsim.core.error_text import in_words
from amorsim.core.parameters import ParameterError

__all__ = ["Interval", "mean_interval", "welch_half_width"]

FEWEST_FOR_SKEWNESS = 10
"""Fewer samples do not show how skewed their distribution is."""


class Interval(NamedTuple):
    """A value and its interval; nan where there are too few samples for one.

    Attributes
    ----------
    p
        How probable a mean at least this far from 0 is if the true one is 0; two-sided. It is below 0.05 exactly where
        the 95 % interval excludes 0.
    """

    value: float
    low: float
    high: float
    p: float = math.nan

    @property
    def half_width(self) -> float:
        """Half of the distance between the ends."""
        return 0.5 * (self.high - self.low)

    def covers(self, value: float) -> bool:
        """Whether a value lies in the interval, its ends included."""
        return self.low <= value <= self.high

    @property
    def excludes_zero(self) -> bool:
        """Whether the interval lies on one side of 0."""
        return self.low > 0.0 or self.high < 0.0


def mean_interval(samples: npt.ArrayLike, confidence: float = 0.95) -> Interval:
    """The mean of independent samples `(n,)` with its interval; the ends are nan for fewer than two samples.

    Student's t. From ten samples on, each end is the farther one of Student's t and of t corrected for the samples'
    skewness (Hall 1992), so that the interval also covers the means of skewed distributions, such as those of errors.
    Samples that are all alike have an interval without width.

    Each sample may be the result of a whole run. Correlation within a run then does not matter.

    Raises
    ------
    ValueError
        If `samples` are not a list of numbers, or `confidence` is not between 0 and 1.
    """
    given = numbers(samples, "samples", ("n",))
    level = real(confidence, "confidence", "a number between 0 and 1")
    if not 0.0 < level < 1.0:
        raise ParameterError("confidence", f"expected a number between 0 and 1, got {in_words(confidence)}")
    count = len(given)
    if count < 2:
        return Interval(float(given[0]) if count else math.nan, math.nan, math.nan)
    if given.min() == given.max():
        value = float(given[0])
        return Interval(value, value, value, 0.0 if value else 1.0)
    from scipy.special import stdtr, stdtrit

    with np.errstate(all="ignore"):  # infinite and huge samples have no interval
        mean, spread = float(np.mean(given)), float(np.std(given, ddof=1))
    if not 0.0 < spread < math.inf:
        return Interval(mean, math.nan, math.nan)
    error = spread / math.sqrt(count)
    bend = _skewness(given, mean, spread) / math.sqrt(count) if count >= FEWEST_FOR_SKEWNESS else 0.0
    quantile = float(stdtrit(count - 1, 0.5 + 0.5 * level))
    low = mean - error * max(quantile, _uncorrected(quantile, bend))
    high = mean - error * min(-quantile, _uncorrected(-quantile, bend))
    scores = mean / error, _corrected(mean / error, bend)
    beyond = max(min(scores), -max(scores), 0.0)
    return Interval(mean, low, high, 2.0 * float(stdtr(count - 1, -beyond)))


def _skewness(samples: Array, mean: float, spread: float) -> float:
    """The skewness of samples, as their own third moment gives it."""
    third = float(np.mean(((samples - mean) / spread) ** 3))
    return third * math.sqrt(len(samples) / (len(samples) - 1)) ** 3


def _corrected(score: float, bend: float) -> float:
    """Hall's transformation, after which a studentized mean is nearly t-distributed; `bend` is skewness / sqrt(n).

    P. Hall, "On the removal of skewness by transformation", J. R. Statist. Soc. B 54 (1992) 221-228. It is monotone and
    has a closed inverse.
    """
    return score + bend * (score**2 / 3.0 + bend * score**3 / 27.0 + 1.0 / 6.0)


def _uncorrected(score: float, bend: float) -> float:
    """The inverse of `_corrected`."""
    if abs(bend) < 1e-8:  # the correction is smaller than its rounding
        return score
    return 3.0 * (math.cbrt(1.0 + bend * (score - bend / 6.0)) - 1.0) / bend


def welch_half_width(variances: Sequence[float], counts: Sequence[int], confidence: float = 0.95) -> float:
    """Half the width of the interval of a sum or difference of two independent parts (Welch and Satterthwaite).

    Parameters
    ----------
    variances
        Of the two parts, each estimated from as many samples as `counts` has, two at least.
    """
    from scipy.special import stdtrit

    total = float(sum(variances))
    if total == 0.0:
        return 0.0
    # As shares of the total, whose squares do not vanish when it is small.
    degrees = 1.0 / sum((part / total) ** 2 / (count - 1) for part, count in zip(variances, counts, strict=True))
    return float(stdtrit(degrees, 0.5 + 0.5 * confidence)) * math.sqrt(total)
