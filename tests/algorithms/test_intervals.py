"""Student's t, against tables and SciPy, and what the intervals made of it promise."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy import stats

from amorsim.algorithms.intervals import Interval, mean_interval, student_t_quantile


@pytest.mark.parametrize("degrees", [0.5, 1.0, 2.0, 3.7, 4.0, 8.0, 30.0, 199.0, 1e4])
@pytest.mark.parametrize("probability", [1e-6, 0.025, 0.3, 0.5, 0.9, 0.975, 0.9995])
def test_quantiles_are_those_of_scipy(degrees: float, probability: float) -> None:
    wanted = float(stats.t.ppf(probability, degrees))
    assert student_t_quantile(probability, degrees) == pytest.approx(wanted, rel=1e-9, abs=1e-12)


def test_one_degree_of_freedom_is_cauchys_distribution() -> None:
    for probability in (0.1, 0.6, 0.99):
        wanted = math.tan(math.pi * (probability - 0.5))
        assert student_t_quantile(probability, 1.0) == pytest.approx(wanted, rel=1e-12)


@pytest.mark.parametrize(("probability", "degrees"), [(0.0, 4.0), (1.0, 4.0), (0.9, 0.0), (math.nan, 4.0)])
def test_what_is_no_probability_is_refused(probability: float, degrees: float) -> None:
    with pytest.raises(ValueError, match="expected 0 < probability < 1"):
        student_t_quantile(probability, degrees)


@pytest.mark.long
def test_intervals_of_means_cover_as_often_as_they_say() -> None:
    samples = np.random.default_rng(1).normal(3.0, 2.0, size=(4000, 5))
    covered = sum(mean_interval(row).covers(3.0) for row in samples)
    # Binomial with p = 0.95; four standard deviations.
    assert abs(covered - 3800) < 4 * math.sqrt(4000 * 0.95 * 0.05)


def test_an_interval_knows_its_ends() -> None:
    interval = Interval(2.0, 0.5)
    assert (interval.low, interval.high) == (1.5, 2.5)
    assert interval.covers(1.5)
    assert not interval.covers(2.6)
