"""Student's t distribution, and the intervals that are made of it."""

from __future__ import annotations

import functools
import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

__all__ = ["Interval", "mean_interval", "student_t_quantile"]

Array = npt.NDArray[np.float64]

_TINY = 1e-300
_MOST_TERMS = 10_000


class Interval(NamedTuple):
    """A value and how far the interval reaches to either side of it."""

    value: float
    half_width: float

    @property
    def low(self) -> float:
        """The lower end."""
        return self.value - self.half_width

    @property
    def high(self) -> float:
        """The upper end."""
        return self.value + self.half_width

    def covers(self, value: float) -> bool:
        """Whether a value lies in the interval, its ends included."""
        return self.low <= value <= self.high


def mean_interval(samples: Array, confidence: float = 0.95) -> Interval:
    """The mean of independent samples `(n,)` with its interval by Student's t; n >= 2.

    Each sample may be the result of a whole run: then it does not matter how the values within a run hang together.
    """
    count = len(samples)
    error = math.sqrt(float(np.var(samples, ddof=1)) / count)
    return Interval(float(np.mean(samples)), student_t_quantile(0.5 + 0.5 * confidence, count - 1) * error)


@functools.lru_cache(maxsize=1024)
def student_t_quantile(probability: float, degrees: float) -> float:
    """The value that a t-distributed number stays below with this probability.

    Parameters
    ----------
    probability
        Between 0 and 1, both excluded.
    degrees
        Degrees of freedom, > 0; need not be whole.

    Raises
    ------
    ValueError
        Outside of these.
    """
    if not (0.0 < probability < 1.0 and degrees > 0.0):
        raise ValueError(f"expected 0 < probability < 1 and degrees > 0, got {probability!r} and {degrees!r}")
    if probability < 0.5:
        return -student_t_quantile(1.0 - probability, degrees)
    wanted = 1.0 - probability
    low, high = 0.0, 1.0
    while _upper_tail(high, degrees) > wanted:
        low, high = high, 2.0 * high
    # Bisection to neighbouring numbers: slow and sure, for a study asks for few different ones.
    while low < (middle := 0.5 * (low + high)) < high:
        low, high = (middle, high) if _upper_tail(middle, degrees) > wanted else (low, middle)
    return middle


def _upper_tail(t: float, degrees: float) -> float:
    """Probability of more than t >= 0."""
    return 0.5 * _incomplete_beta(degrees / (degrees + t * t), 0.5 * degrees, 0.5)


def _incomplete_beta(x: float, a: float, b: float) -> float:
    """The regularised incomplete beta function I_x(a, b), 0 <= x <= 1."""
    if x <= 0.0 or x >= 1.0:
        return float(x >= 1.0)
    if x > (a + 1.0) / (a + b + 2.0):  # where the fraction converges slowly, it does for the complement
        return 1.0 - _incomplete_beta(1.0 - x, b, a)
    size = math.lgamma(a + b) - math.lgamma(a) - math.lgamma(b) + a * math.log(x) + b * math.log1p(-x)
    return math.exp(size) / (a * _beta_fraction(x, a, b))


def _beta_fraction(x: float, a: float, b: float) -> float:
    """The continued fraction 1 + d1 / (1 + d2 / (1 + ...)) of I_x(a, b), evaluated from its front (Lentz).

    The coefficients are those of DLMF 8.17.22: https://dlmf.nist.gov/8.17#v
    """
    value = c = 1.0
    d = 0.0
    for term in range(1, _MOST_TERMS):
        m = term // 2
        if term % 2:
            top = -(a + m) * (a + b + m) * x / ((a + 2 * m) * (a + 2 * m + 1))
        else:
            top = m * (b - m) * x / ((a + 2 * m - 1) * (a + 2 * m))
        d = 1.0 / ((1.0 + top * d) or _TINY)
        c = (1.0 + top / c) or _TINY
        value *= c * d
        if abs(c * d - 1.0) < 1e-15:
            break
    return value
