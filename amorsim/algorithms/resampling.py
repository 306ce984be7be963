"""What may be claimed of a difference: bootstrap intervals, permutation tests, effect sizes, Holm's correction.

Random numbers come from a fixed seed, so that the same samples give the same figures.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np
import numpy.typing as npt

from amorsim.core.arguments import numbers, real, whole
from amorsim.core.parameters import ParameterError
from amorsim.core.trouble import in_words

__all__ = ["bootstrap_interval", "holm", "paired_effect", "permutation_p"]

Array = npt.NDArray[np.float64]
Statistic = Callable[..., Array]

RESAMPLES = 9999
_SEED = 20260101
_BLOCK = 1 << 21  # numbers drawn at once
_ALL_UP_TO = 12  # pairs, whose signs are then all tried


def bootstrap_interval(
    samples: Array, *, confidence: float = 0.95, statistic: Statistic | None = None, resamples: int = RESAMPLES
) -> tuple[float, float]:
    """The interval of a statistic of independent samples `(n,)`, n >= 2, by the bootstrap (bias-corrected, BCa).

    Parameters
    ----------
    statistic
        Such as `numpy.median`; called with ``axis=``. Without it, the mean.

    Raises
    ------
    ValueError
        If there are fewer than two samples.
    """
    samples = numbers(samples, "samples", ("n",))
    level = real(confidence, "confidence", "a number between 0 and 1")
    resamples = whole(resamples, "resamples", "a whole number > 0", least=1)
    if not 0.0 < level < 1.0:
        raise ParameterError("confidence", f"expected a number between 0 and 1, got {in_words(confidence)}")
    if not (statistic is None or callable(statistic)):
        raise ParameterError("statistic", f"expected a function such as numpy.median, got {in_words(statistic)}")
    if len(samples) < 2:
        raise ValueError(f"expected two samples at least, got {len(samples)}")
    if samples.min() == samples.max():  # nothing scatters, and BCa is not defined
        value = float(samples[0])
        return value, value
    from scipy.special import ndtr, ndtri

    statistic = np.mean if statistic is None else statistic
    count = len(samples)
    drawn = np.sort(_resampled(samples, statistic, resamples))
    value = float(statistic(samples, axis=0))
    below = np.count_nonzero(drawn < value) + 0.5 * np.count_nonzero(drawn == value)
    bias = float(ndtri(min(max(below / resamples, 0.5 / resamples), 1.0 - 0.5 / resamples)))
    jack = np.array([float(statistic(np.delete(samples, i), axis=0)) for i in range(count)])
    apart = jack.mean() - jack
    size = float(np.sum(apart**2)) ** 1.5
    skew = float(np.sum(apart**3)) / (6.0 * size) if size > 0.0 else 0.0
    ends = []
    for tail in (0.5 * (1.0 - confidence), 0.5 * (1.0 + confidence)):
        z = bias + float(ndtri(tail))
        ends.append(float(ndtr(bias + z / (1.0 - skew * z))))
    low, high = np.quantile(drawn, ends)
    return float(low), float(high)


def _resampled(samples: Array, statistic: Statistic, resamples: int) -> Array:
    """The statistic of a number of samples drawn with replacement."""
    random = np.random.default_rng(_SEED)
    found = []
    for count in _blocks(resamples, len(samples)):
        chosen = random.integers(0, len(samples), (count, len(samples)))
        found.append(statistic(samples[chosen], axis=1))
    return np.concatenate(found)


def permutation_p(differences: Array, *, resamples: int = RESAMPLES) -> float:
    """How probably the mean of paired differences `(n,)` is at least so far from 0 if there is no difference.

    Then each difference is as likely as its negative: all signs are tried up to 12 pairs, `resamples` random ones
    beyond. Two-sided. nan if a difference is nan, as are an interval and an effect then.
    """
    differences = numbers(differences, "differences", ("n",))
    resamples = whole(resamples, "resamples", "a whole number > 0", least=1)
    count = len(differences)
    if not count:
        raise ValueError("expected one difference at least, got none")
    if np.isnan(differences).any():
        return math.nan
    # A sum that is as far from 0 as the real one is counted, whatever rounding did to it.
    wanted = abs(float(np.sum(differences))) * (1.0 - 1e-12)
    if count <= _ALL_UP_TO:
        bits = (np.arange(1 << count)[:, None] >> np.arange(count)) & 1
        sums = np.abs(((1 - 2 * bits) * differences).sum(axis=1))
        return float(np.count_nonzero(sums >= wanted)) / (1 << count)
    random = np.random.default_rng(_SEED)
    more = 0
    for many in _blocks(resamples, count):
        signs = 1.0 - 2.0 * random.integers(0, 2, (many, count), dtype=np.int8)
        more += int(np.count_nonzero(np.abs((signs * differences).sum(axis=1)) >= wanted))
    return (more + 1) / (resamples + 1)


def _blocks(resamples: int, count: int) -> Sequence[int]:
    each = max(1, min(resamples, _BLOCK // count))
    return [min(each, resamples - begun) for begun in range(0, resamples, each)]


def paired_effect(differences: Array) -> float:
    """Cohen's d of paired differences: their mean over their standard deviation; inf if all are alike, and not 0.

    One difference alone has no deviation, and nan as its effect.
    """
    differences = numbers(differences, "differences", ("n",))
    if not len(differences):
        raise ValueError("expected one difference at least, got none")
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
