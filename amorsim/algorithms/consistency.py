"""Whether a filter's errors fit its covariance: NEES, NIS, their bands, and a verdict in words.

The normalised estimation error squared (NEES) of a filter whose covariance is right has the chi-squared distribution
with as many degrees of freedom as the state has numbers; the normalised innovation squared (NIS) that of the
measurement (Bar-Shalom, Li and Kirubarajan 2001, section 5.4). The mean of n independent ones has the distribution with
n times as many degrees, over n.
"""

from __future__ import annotations

import math

import attrs
import numpy as np

from amorsim.array_types import Array
from amorsim.core.arguments import is_numeric, real, whole
from amorsim.core.error_text import in_words
from amorsim.core.parameters import LARGEST, ParameterError

__all__ = ["Consistency", "chi_squared_band", "nees", "nis", "verdict"]


@attrs.frozen(kw_only=True)
class Consistency:
    """A verdict over independent values of NEES or NIS.

    Attributes
    ----------
    verdict
        ``"consistent"``; ``"overconfident"``, if errors are larger than the covariance; ``"underconfident"``, if
        they are smaller; ``"unknown"`` without any value.
    mean
        Of the values.
    low, high
        The band that the mean of a consistent filter lies in.
    degrees
        Degrees of freedom of a value, whose expectation that is.
    count
        Number of values.
    confidence
        How probably a consistent filter's mean lies in the band.
    """

    verdict: str
    mean: float
    low: float
    high: float
    degrees: int
    count: int
    confidence: float

    def __str__(self) -> str:
        if self.verdict == "unknown":
            return "unknown: there are no values"
        band = f"the mean of {self.count} values is {self.mean:.3f}, and a consistent filter's lies with "
        band += f"{100 * self.confidence:g} % between {self.low:.3f} and {self.high:.3f}"
        if self.verdict == "consistent":
            return f"consistent: {band}"
        factor = math.sqrt(self.mean / self.degrees)
        if self.verdict == "overconfident":
            return f"overconfident: {band}; errors are {factor:.3g} times as large as the covariance says"
        return f"underconfident: {band}; errors are {factor:.3g} times as large as the covariance says, so less"


def nees(errors: Array, covariances: Array) -> Array:
    """The normalised estimation error squared `(...,)` of errors `(..., d)` with covariances `(..., d, d)`.

    Estimated less true; a heading's difference is to be wrapped by the caller. nan where a covariance is not positive
    definite.
    """
    return _normalised(errors, covariances)


def nis(innovations: Array, covariances: Array) -> Array:
    """The normalised innovation squared `(...,)` of innovations `(..., d)` with their covariances `(..., d, d)`."""
    return _normalised(innovations, covariances)


def verdict(values: Array, degrees: int, *, confidence: float = 0.95) -> Consistency:
    """The verdict over independent values of NEES or NIS; those that are nan are left out.

    Values of one run follow one another and are not independent: take those of replicas at one time, or those of
    innovations, which are independent if the filter is consistent.

    Parameters
    ----------
    degrees
        How many numbers the error or innovation has.

    Raises
    ------
    ValueError
        If `degrees` is below 1, or `confidence` is not between 0 and 1.
    """
    degrees = whole(degrees, "degrees", "a whole number >= 1")
    if not 1 <= degrees <= LARGEST or not 0.0 < real(confidence, "confidence", "a number between 0 and 1") < 1.0:
        got = f"{in_words(degrees)} and {in_words(confidence)}"
        problem = f"expected degrees >= 1 and <= {LARGEST:g}, 0 < confidence < 1, got {got}"
        raise ParameterError("degrees, confidence", problem)
    try:
        there = np.asarray(values, dtype=np.float64).ravel()
    except (TypeError, ValueError, OverflowError):
        raise ParameterError("values", f"expected numbers, got {in_words(values)}") from None
    there = there[~np.isnan(there)]
    if not len(there):
        return Consistency(
            verdict="unknown",
            mean=math.nan,
            low=math.nan,
            high=math.nan,
            degrees=degrees,
            count=0,
            confidence=confidence,
        )
    low, high = chi_squared_band(degrees, len(there), confidence)
    mean = float(np.mean(there))
    word = "consistent" if low <= mean <= high else "overconfident" if mean > high else "underconfident"
    return Consistency(
        verdict=word, mean=mean, low=low, high=high, degrees=degrees, count=len(there), confidence=confidence
    )


def chi_squared_band(degrees: int, count: int = 1, confidence: float = 0.95) -> tuple[float, float]:
    """The band that the mean of `count` chi-squared values lies in with this probability, as much below as above."""
    from scipy.special import chdtri

    tail = 0.5 * (1.0 - confidence)
    freedom = degrees * count
    return float(chdtri(freedom, 1.0 - tail)) / count, float(chdtri(freedom, tail)) / count


def _normalised(vectors: Array, covariances: Array) -> Array:
    """V' C^-1 v by Cholesky, one number after another, so that no row depends on how many there are."""
    for name, given in (("vectors", vectors), ("covariances", covariances)):
        if not is_numeric(given):
            raise ParameterError(name, f"expected numbers, got {in_words(given)}")
    vectors, covariances = np.asarray(vectors), np.asarray(covariances)
    size = vectors.shape[-1] if vectors.ndim else 0
    if vectors.dtype.kind not in "fiu" or covariances.dtype.kind not in "fiu" or covariances.shape[-2:] != (size, size):
        shapes = f"{vectors.shape} and {covariances.shape}"
        raise ParameterError(
            "covariances", f"expected vectors (..., d) with covariances (..., d, d), got those of the shapes {shapes}"
        )
    lower: list[list[Array]] = []
    solved: list[Array] = []
    total = np.zeros(vectors.shape[:-1])
    with np.errstate(invalid="ignore", divide="ignore"):
        for i in range(size):
            row: list[Array] = []
            for j in range(i + 1):
                left = covariances[..., i, j].astype(np.float64)
                for k in range(j):
                    left = left - row[k] * (lower[j][k] if j < i else row[k])
                row.append(np.sqrt(np.where(left > 0.0, left, np.nan)) if j == i else left / lower[j][j])
            lower.append(row)
            rest = vectors[..., i].astype(np.float64)
            for k in range(i):
                rest = rest - row[k] * solved[k]
            solved.append(rest / row[i])
            total = total + solved[i] * solved[i]
    return total
