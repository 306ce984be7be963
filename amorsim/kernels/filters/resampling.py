"""How many particles a filter needs, the effective number of its weights, and which particles are kept.

Sources: D. Fox, "Adapting the sample size in particle filters through KLD-sampling", IJRR 22 (2003); J. S. Liu,
R. Chen, "Blind deconvolution via sequential imputations", JASA 90 (1995), for the effective sample size; S. Thrun,
W. Burgard, D. Fox, "Probabilistic Robotics" (2005), 4.3 (low-variance resampling) and 8.3 (augmented recovery).
"""

from __future__ import annotations

import math

from amorsim.array_types import Array, Ints
from amorsim.kernels.compile import kernel

__all__ = ["average", "effective_size", "kld_size", "recovery_probability", "resample"]


@kernel
def kld_size(bins: int, error: float, quantile: float) -> float:
    """Particles that keep the distance of Kullback and Leibler to a distribution over `bins` bins below `error`.

    By Fox (2003), equation 7; `quantile` is that of the normal distribution at the probability wanted. 1 for one bin.
    """
    if bins < 2:
        return 1.0
    b = 2.0 / (9.0 * (bins - 1))
    root_ = 1.0 - b + math.sqrt(b) * quantile
    return float(math.ceil((bins - 1) / (2.0 * error) * root_ * root_ * root_))


@kernel
def effective_size(weights: Array) -> float:
    """The effective sample size of weights, whose sum may be any."""
    total = 0.0
    squares = 0.0
    for i in range(weights.shape[0]):
        total += weights[i]
        squares += weights[i] * weights[i]
    return total * total / squares if squares > 0.0 else 0.0


@kernel
def average(mean: float, averages: Array, slow: float, fast: float) -> None:
    """Update the slow and the fast average (2,) with a mean weight and these gains; the first weight is both."""
    if averages[0] != averages[0]:
        averages[0] = mean
        averages[1] = mean
        return
    averages[0] += slow * (mean - averages[0])
    averages[1] += fast * (mean - averages[1])


@kernel
def recovery_probability(averages: Array) -> float:
    """The probability with which a particle is drawn at random: it grows as the fast average falls."""
    if not averages[0] > 0.0:
        return 0.0
    return float(max(0.0, 1.0 - averages[1] / averages[0]))


@kernel
def resample(weights: Array, offset: float, picks: Ints) -> None:
    """Write which particles are kept (n,), by low-variance sampling with an `offset` in (0, 1)."""
    last = 0  # the last particle with any weight: rounding must not go beyond it
    total = 0.0
    for i in range(weights.shape[0]):
        total += weights[i]
        if weights[i] > 0.0:
            last = i
    n = picks.shape[0]
    i = 0
    up_to = weights[0]
    for m in range(n):
        at = (m + offset) / n * total
        while up_to < at and i < last:
            i += 1
            up_to += weights[i]
        picks[m] = i
