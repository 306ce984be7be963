"""Noise of rates and zeros over time: angle random walk, rate random walk, bias instability."""

import math

import numpy as np
import pytest
from scipy.special import ndtr

from amorsim.noise import AngleRandomWalk, BiasInstability, BiasRandomWalk
from tests.noise.sampling import (
    ROWS,
    SIGMAS,
    K,
    N,
    Samples,
    assert_allan,
    assert_distributed,
    assert_moments,
    assert_uncorrelated,
)

CLUSTERS = (1, 2, 5, 10)


def test_white_noise_of_a_rate_has_the_spread_of_its_density():
    samples = Samples(AngleRandomWalk(density=0.02), rows=ROWS)
    assert (samples.take(1.5) == 1.5).all()  # a first sample stands for no time
    found = samples.take(1.5, elapsed=0.04)
    assert_moments(found, 0.02 / math.sqrt(0.04), mean=1.5)
    assert_distributed(found, lambda x: ndtr((x - 1.5) / 0.1))


@pytest.mark.parametrize("elapsed", [0.05, 0.25, 1.0])
def test_the_angle_walks_alike_however_often_the_rate_is_read(elapsed):
    samples = Samples(AngleRandomWalk(density=0.02), rows=ROWS)
    samples.take()
    angle = np.zeros((ROWS, K))
    for _ in range(round(2.0 / elapsed)):
        angle += samples.take(elapsed=elapsed) * elapsed
    assert_moments(angle, 0.02 * math.sqrt(2.0))


def test_the_allan_deviation_of_an_angle_random_walk_falls_with_the_root_of_time():
    samples = Samples(AngleRandomWalk(density=0.02), rows=ROWS)
    samples.take()
    series = samples.series(20)
    for m in CLUSTERS:
        assert_allan(series, m, 0.02**2 / (0.1 * m))


@pytest.mark.parametrize("elapsed", [0.05, 0.25, 1.0])
def test_a_bias_walks_alike_however_often_it_is_read(elapsed):
    samples = Samples(BiasRandomWalk(std=0.3), rows=ROWS)
    assert (samples.take(2.0) == 2.0).all()
    for _ in range(round(2.0 / elapsed)):
        last = samples.take(2.0, elapsed=elapsed)
    assert_moments(last, 0.3 * math.sqrt(2.0), mean=2.0)
    assert_distributed(last, lambda x: ndtr((x - 2.0) / (0.3 * math.sqrt(2.0))))


def test_a_bias_walks_by_each_rows_own_time():
    samples = Samples(BiasRandomWalk(std=0.3), rows=ROWS)
    samples.take()
    elapsed = np.where(np.arange(ROWS)[:, None] % 2 == 0, 0.1, 0.4)
    found = samples.take(elapsed=elapsed)
    assert_moments(found[::2], 0.3 * math.sqrt(0.1))
    assert_moments(found[1::2], 0.3 * math.sqrt(0.4))


def test_the_steps_of_a_bias_are_independent_and_its_allan_deviation_grows():
    series = Samples(BiasRandomWalk(std=0.3), rows=ROWS).series(20)
    assert_uncorrelated(*np.diff(series[:5], axis=0))
    for m in CLUSTERS:
        # The mean over m samples of a walk, against the next one's: K^2 t / 3 but for the sampling.
        assert_allan(series, m, 0.3**2 * (0.1 * m) / 3.0 * (1.0 + 0.5 / m**2))


def gauss_markov_allan(std, ratio, m):
    """Allan variance of sampled noise with the autocorrelation exp(-ratio |i - j|), summed pair by pair."""
    lags = np.arange(2 * m)
    covariance = std**2 * np.exp(-ratio * np.abs(lags[:, None] - lags[None, :]))
    weights = np.repeat((-1.0 / m, 1.0 / m), m)
    return 0.5 * float((weights[:, None] * covariance * weights[None, :]).sum())


def test_bias_instability_keeps_its_spread_from_the_first_sample_on():
    samples = Samples(BiasInstability(std=0.2, correlation_time=0.5), rows=ROWS)
    for found in (samples.take(1.0), samples.take(1.0), samples.take(1.0, elapsed=100.0)):
        assert_moments(found, 0.2, mean=1.0)
        assert_distributed(found, lambda x: ndtr((x - 1.0) / 0.2))


@pytest.mark.parametrize("elapsed", [0.02, 0.1, 0.3])
def test_bias_instability_forgets_alike_however_often_it_is_read(elapsed):
    samples = Samples(BiasInstability(std=0.2, correlation_time=0.5), rows=ROWS)
    first = samples.take()
    for _ in range(round(0.6 / elapsed)):
        last = samples.take(elapsed=elapsed)
    expected = math.exp(-0.6 / 0.5)
    # The correlation of n normal pairs has the standard deviation (1 - r^2) / sqrt(n).
    found = np.corrcoef(first.ravel(), last.ravel())[0, 1]
    assert abs(found - expected) < SIGMAS * (1.0 - expected**2) / math.sqrt(N)


def test_bias_instability_forgets_from_sample_to_sample_by_its_time_constant():
    """Regressed on the one before, over n pairs, a sample gives the factor to sqrt((1 - factor^2) / n)."""
    series = Samples(BiasInstability(std=0.2, correlation_time=0.5), rows=ROWS).series(20)
    before, after = series[:-1].ravel(), series[1:].ravel()
    expected = math.exp(-0.1 / 0.5)
    found = (before * after).sum() / (before**2).sum()
    assert abs(found - expected) < SIGMAS * math.sqrt((1.0 - expected**2) / before.size)


def test_bias_instability_has_the_allan_deviation_of_its_autocorrelation():
    series = Samples(BiasInstability(std=0.2, correlation_time=0.5), rows=ROWS).series(20)
    for m in CLUSTERS:
        assert_allan(series, m, gauss_markov_allan(0.2, 0.1 / 0.5, m))


def test_the_hump_of_bias_instability_is_where_the_docstring_says():
    heights = {m: math.sqrt(gauss_markov_allan(1.0, 0.01, m)) for m in range(150, 240, 3)}  # 100 samples in a time
    peak = max(heights, key=heights.get)
    assert peak / 100 == pytest.approx(1.89, abs=0.04)
    assert heights[peak] == pytest.approx(0.617, abs=1e-3)


@pytest.mark.long
def test_a_long_series_of_a_gyro_shows_all_three_slopes():
    """White noise, instability and walk together: the Allan variances add up, over three decades of time."""
    parts = {
        "white": AngleRandomWalk(density=0.05),
        "instability": BiasInstability(std=0.03, correlation_time=5.0),
        "walk": BiasRandomWalk(std=0.004),
    }
    rows, count = 500, 2000
    chain = [Samples(noise, rows=rows, name=name) for name, noise in parts.items()]
    for element in chain:
        element.take()
    series = np.zeros((count, rows, K))
    for i in range(count):
        for element in chain:
            series[i] = element.take(series[i])
    for m in (1, 10, 100, 1000):
        expected = (
            0.05**2 / (0.1 * m)
            + gauss_markov_allan(0.03, 0.1 / 5.0, m)
            + 0.004**2 * (0.1 * m) / 3.0 * (1.0 + 0.5 / m**2)
        )
        assert_allan(series, m, expected)
