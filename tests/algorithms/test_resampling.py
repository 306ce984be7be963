"""Intervals cover what they say, p-values are uniform where there is no difference."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from scipy import stats

from amorsim.algorithms.resampling import bootstrap_interval, holm, paired_effect, permutation_p


def studies(count, size, seed, shift=0.0):
    """Differences of synthetic studies, skewed as errors are; their mean is `shift`."""
    random = np.random.default_rng(seed)
    return shift + random.gamma(2.0, 1.0, (count, size)) - random.gamma(2.0, 1.0, (count, size))


def covered(count, size, resamples):
    found = [bootstrap_interval(each, resamples=resamples) for each in studies(count, size, 7, 0.3)]
    return sum(low <= 0.3 <= high for low, high in found)


def test_95_percent_intervals_cover_179_of_200() -> None:
    # The binomial quantile at 0.0005 of 200 tries at 95 %.
    assert covered(200, 60, 999) >= 179


@pytest.mark.long
def test_95_percent_intervals_cover_neither_too_little_nor_too_much() -> None:
    # The band of 99.9 % of a binomial number of 1,000 tries at 95 %; BCa of 100 samples falls short by a percent.
    low, high = stats.binom.ppf([0.0005, 0.9995], 1000, [0.94, 0.95])
    assert low <= covered(1000, 100, 1999) <= high


@pytest.mark.parametrize("size", [8, 40])
def test_p_is_uniform_without_a_difference(size: int) -> None:
    found = [permutation_p(each, resamples=499) for each in studies(400, size, 3)]
    assert stats.kstest(found, "uniform").pvalue > 0.001


def test_p_agrees_with_scipy() -> None:
    differences = studies(1, 10, 5, 0.8)[0]
    theirs = stats.permutation_test(
        (differences, np.zeros(10)), lambda x, y: np.mean(x - y), permutation_type="samples"
    )
    assert permutation_p(differences) == pytest.approx(theirs.pvalue, abs=1e-12)
    many = studies(1, 50, 5, 0.4)[0]
    theirs = stats.permutation_test(
        (many, np.zeros(50)), lambda x, y: np.mean(x - y), permutation_type="samples", n_resamples=2000, rng=1
    )
    assert permutation_p(many) == pytest.approx(theirs.pvalue, abs=0.03)


def test_intervals_agree_with_scipy() -> None:
    samples = studies(1, 50, 9)[0]
    theirs = stats.bootstrap((samples,), np.mean, n_resamples=9999, rng=1).confidence_interval
    assert bootstrap_interval(samples) == pytest.approx((theirs.low, theirs.high), abs=0.05 * samples.std())


def test_the_same_samples_give_the_same_figures() -> None:
    samples = studies(1, 50, 9)[0]
    assert bootstrap_interval(samples) == bootstrap_interval(samples)
    assert permutation_p(samples) == permutation_p(samples)


def test_samples_that_do_not_scatter_have_an_interval_without_width() -> None:
    assert bootstrap_interval(np.full(5, 2.0)) == (2.0, 2.0)
    with pytest.raises(ValueError, match="expected two samples at least, got 1"):
        bootstrap_interval(np.ones(1))


def test_no_difference_at_all_has_p_of_one() -> None:
    assert permutation_p(np.zeros(5)) == 1.0
    assert permutation_p(np.zeros(50)) == 1.0


@pytest.mark.parametrize("count", [2, 50])
def test_of_differences_that_are_not_all_known_nothing_is_said(count: int) -> None:
    differences = np.arange(1.0, count + 1.0)
    differences[-1] = math.nan
    assert math.isnan(permutation_p(differences))


def test_the_effect_is_cohens_d() -> None:
    differences = np.array([1.0, 2.0, 3.0])
    assert paired_effect(differences) == pytest.approx(2.0)
    assert paired_effect(np.full(4, -2.0)) == -math.inf
    assert paired_effect(np.zeros(4)) == 0.0
    assert math.isnan(paired_effect(np.ones(1)))


def test_holm_multiplies_the_least_the_most() -> None:
    assert holm([0.01, 0.04, 0.03]) == pytest.approx([0.03, 0.06, 0.06])
    assert holm([0.5, 0.9]) == [1.0, 1.0]
    assert holm([]) == []
    assert holm([0.04, math.nan, 0.01]) == pytest.approx([0.04, math.nan, 0.02], nan_ok=True)


def test_a_statistic_is_a_function() -> None:
    wrong: Any = "median"
    with pytest.raises(ValueError, match=r"statistic: expected a function such as numpy\.median, got 'median'"):
        bootstrap_interval(np.arange(5.0), statistic=wrong)
