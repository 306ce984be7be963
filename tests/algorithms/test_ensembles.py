"""Figures of many replicas are those of each time by itself."""

from __future__ import annotations

import math

import numpy as np
import pytest

from amorsim.algorithms.ensembles import ensemble
from amorsim.algorithms.intervals import mean_interval


def test_figures_of_a_time_are_those_of_its_values() -> None:
    values = np.random.default_rng(1).gamma(2.0, 1.0, (5, 21))
    values[2, 4:9] = math.nan
    found = ensemble(values)
    for step, here in enumerate(values):
        there = here[~np.isnan(here)]
        interval = mean_interval(there)
        assert found.counts[step] == len(there)
        assert (found.mean[step], found.low[step]) == pytest.approx((interval.value, interval.low))
        assert found.high[step] == pytest.approx(interval.high)
        assert found.rms[step] == pytest.approx(math.sqrt(np.mean(there**2)))
        assert (found.median[step], found.lower[step], found.upper[step]) == pytest.approx(
            (np.median(there), np.quantile(there, 0.25), np.quantile(there, 0.75))
        )


def test_the_interquartile_mean_leaves_out_a_quarter_at_each_end() -> None:
    found = ensemble([[1000.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, -1000.0]])
    assert found.interquartile_mean[0] == pytest.approx((2.0 + 3.0 + 4.0 + 5.0) / 4.0)


def test_too_few_values_have_no_figures() -> None:
    found = ensemble([[math.nan, math.nan], [2.0, math.nan]])
    assert found.counts.tolist() == [0, 1]
    assert np.isnan(found.mean[0])
    assert found.mean[1] == found.median[1] == found.interquartile_mean[1] == 2.0
    assert np.isnan(found.low[1])


def test_intervals_cover_as_often_as_they_say() -> None:
    """Of 2,000 means 95 % within 1.96 deviations of the binomial distribution, and a tenth more."""
    found = ensemble(np.random.default_rng(7).normal(3.0, 2.0, (2000, 10)))
    share = np.mean((found.low <= 3.0) & (found.high >= 3.0))
    assert abs(share - 0.95) < 1.1 * 1.96 * math.sqrt(0.95 * 0.05 / 2000)


@pytest.mark.parametrize(("values", "confidence", "words"), [([1.0], 0.95, "shape"), ([[1.0]], 1.0, "confidence")])
def test_wrong_arguments_are_refused(values: list[float], confidence: float, words: str) -> None:
    with pytest.raises(ValueError, match=words):
        ensemble(values, confidence=confidence)
