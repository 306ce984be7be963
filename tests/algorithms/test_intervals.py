"""Intervals of means cover as often as they say, and their p-values say the same as they do."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats

from amorsim.algorithms.intervals import Interval, mean_interval, welch_half_width
from tests.algorithms.coverage import DISTRIBUTIONS, PAGE, SIZES, TRIES, covered, page_rows
from tests.examples import settings


def test_few_samples_have_students_t() -> None:
    samples = np.random.default_rng(1).normal(3.0, 2.0, 9)
    theirs = stats.ttest_1samp(samples, 0.0)
    found = mean_interval(samples)
    assert found[1:] == pytest.approx((*theirs.confidence_interval(0.95), theirs.pvalue), rel=1e-9)


def test_no_interval_is_narrower_than_students_t() -> None:
    for seed in range(200):
        samples = np.random.default_rng(seed).lognormal(0.0, 0.1 + 0.01 * seed, 10 + seed % 40)
        low, high = stats.ttest_1samp(samples, 0.0).confidence_interval(0.95)
        found = mean_interval(samples)
        assert found.low <= low + 1e-12
        assert found.high >= high - 1e-12


def test_the_correction_is_that_of_hall() -> None:
    """Of skewed samples the upper end is where the transformed score equals the quantile, by search."""
    samples = np.random.default_rng(3).exponential(1.0, 30)
    skew = float(stats.skew(samples)) / math.sqrt(30)

    def score(mean: float) -> float:
        t = (samples.mean() - mean) / (samples.std(ddof=1) / math.sqrt(30))
        return float(t + skew * t**2 / 3 + skew**2 * t**3 / 27 + skew / 6)

    assert score(mean_interval(samples).high) == pytest.approx(stats.t.ppf(0.025, 29), abs=1e-9)


SAMPLES = st.lists(st.floats(-5.0, 5.0), min_size=2, max_size=60)


@settings(max_examples=300)
@given(samples=SAMPLES, level=st.floats(0.5, 0.999))
def test_the_interval_excludes_0_exactly_where_p_is_below_its_level(samples: list[float], level: float) -> None:
    found = mean_interval(samples, level)
    if math.isnan(found.low) or abs(found.p - (1.0 - level)) < 1e-9:
        return
    assert found.excludes_zero == (found.p < 1.0 - level)


@settings(max_examples=100)
@given(samples=SAMPLES, away=st.floats(-10.0, 10.0))
def test_an_interval_moves_with_its_samples_and_turns_with_their_sign(samples: list[float], away: float) -> None:
    array = np.round(samples, 3)
    found, moved, turned = (mean_interval(each) for each in (array, array + away, -array))
    assert moved[:3] == pytest.approx([end + away for end in found[:3]], abs=1e-7, nan_ok=True)
    assert turned[:3] == pytest.approx((-found.value, -found.high, -found.low), abs=1e-9, nan_ok=True)
    assert turned.p == pytest.approx(found.p, abs=1e-9, nan_ok=True)


def test_samples_that_are_alike_have_an_interval_without_width() -> None:
    assert mean_interval(np.full(5, 0.1)) == (0.1, 0.1, 0.1, 0.0)
    assert mean_interval(np.zeros(50)) == (0.0, 0.0, 0.0, 1.0)


@pytest.mark.parametrize("samples", [[], [2.0], [1.0, math.nan], [1.0, math.inf], [1e300, -1e300]])
def test_what_has_no_interval_has_none(samples: list[float]) -> None:
    found = mean_interval(samples)
    assert math.isnan(found.low)
    assert not found.excludes_zero
    assert not found.covers(2.0)


def test_an_interval_knows_its_ends() -> None:
    interval = Interval(2.0, 1.5, 2.7)
    assert interval.half_width == pytest.approx(0.6)
    assert interval.covers(1.5)
    assert not interval.covers(2.8)
    assert interval.excludes_zero
    assert not Interval(2.0, 0.0, 4.0).excludes_zero


def test_two_parts_have_welchs_interval() -> None:
    random = np.random.default_rng(2)
    one, other = random.normal(0.0, 1.0, 8), random.normal(1.0, 5.0, 13)
    theirs = stats.ttest_ind(one, other, equal_var=False).confidence_interval(0.9)
    half = welch_half_width([each.var(ddof=1) / len(each) for each in (one, other)], [8, 13], 0.9)
    assert half == pytest.approx(0.5 * (theirs.high - theirs.low), rel=1e-9)
    assert welch_half_width([0.0, 0.0], [3, 3]) == 0.0


def least(promised: float, tries: int) -> int:
    """What a count of covered means falls below in one of 10,000 tries if intervals cover as often as promised."""
    return int(stats.binom.ppf(1e-4, tries, promised))


def test_normal_differences_are_covered() -> None:
    """From ten samples on the interval contains that of Student's t, which covers 95 % of normal means exactly."""
    for size in (5, 20):
        assert covered("normal", size, 1000) >= least(0.95, 1000)


@pytest.mark.long
@pytest.mark.parametrize("name", DISTRIBUTIONS)
def test_the_page_says_how_well_intervals_cover(name: str) -> None:
    """Its table was made by `python -m tests.algorithms.coverage`; another NumPy may draw other samples.

    Two shares of 0.95 of independent tries differ by less than four of their deviations but for one of 10,000.
    """
    shares = [covered(name, size, TRIES) / TRIES for size in SIZES]
    said = page_rows()[name]
    for share, cell in zip(shares, said, strict=True):
        assert abs(share - cell / 100.0) < 4.0 * math.sqrt(2.0 * share * (1.0 - share) / TRIES) + 0.0006, PAGE


@pytest.mark.long
@pytest.mark.parametrize("name", ["normal", "Rayleigh, difference of two", "heavy tails (Student's t of 3)"])
def test_symmetric_differences_are_covered_at_every_size(name: str) -> None:
    """As often as promised and, from ten samples on, hardly more: the correction of skewness costs at most 2 %."""
    for size in SIZES:
        count = covered(name, size, TRIES)
        assert least(0.945, TRIES) <= count <= stats.binom.ppf(1.0 - 1e-4, TRIES, 0.97), size


@pytest.mark.long
@pytest.mark.parametrize(("name", "size"), [("Rayleigh", 10), ("exponential", 20), ("log-normal (σ = 1)", 100)])
def test_skewed_means_are_covered_from_a_size_on(name: str, size: int) -> None:
    for each in SIZES[SIZES.index(size) :]:
        assert covered(name, each, TRIES) >= least(0.945, TRIES), each


@pytest.mark.long
def test_differences_that_are_none_are_seldom_claimed() -> None:
    for size in SIZES:
        samples = DISTRIBUTIONS["normal"].draw(np.random.default_rng(size), (TRIES, size))
        claimed = sum(mean_interval(each).p < 0.05 for each in samples)
        assert claimed <= TRIES - least(0.95, TRIES), size
