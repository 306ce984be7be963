"""Elements of noise against the array expressions that say what they do, bit by bit."""

import numpy as np
import pytest

from amorsim.kernels import elementary
from amorsim.kernels.sensing import noise_elements

ROWS, SIZE = 60, 5


def column(low, high, seed):
    """A parameter over rows, as components have it: not to be written to."""
    found = np.random.default_rng(seed).uniform(low, high, (ROWS, 1))
    found.flags.writeable = False
    return found


@pytest.fixture
def rng():
    return np.random.default_rng(7)


@pytest.fixture
def values(rng):
    some = rng.normal(size=(ROWS, SIZE)) * 3.0
    some[rng.random(some.shape) < 0.1] = np.inf
    some[rng.random(some.shape) < 0.1] = -0.0
    return some


@pytest.fixture
def elapsed(rng):
    return np.where(rng.random((ROWS, 1)) < 0.2, 0.0, rng.uniform(0.01, 0.5, (ROWS, 1)))


def test_white_noise_of_a_density(rng, values, elapsed):
    noise, density = rng.normal(size=values.shape), column(0.0, 2.0, 1)
    counts = elapsed > 0.0
    std = np.where(counts, density / np.sqrt(np.where(counts, elapsed, 1.0)), 0.0)
    expected = values - (0.0 - noise * std)
    noise_elements.spread(values, density, elapsed, noise)
    assert noise.tobytes() == expected.tobytes()


def test_a_wandering_bias(rng, values, elapsed):
    before, noise = rng.normal(size=values.shape), rng.normal(size=values.shape)
    std, time, out = column(0.0, 2.0, 1), column(0.1, 5.0, 2), np.empty(values.shape)
    ratio = elapsed / time
    remembered = np.where(elapsed > 0.0, elementary.exp(-ratio), 0.0)
    fresh = np.where(elapsed > 0.0, np.sqrt(-elementary.expm1(-2.0 * ratio)), 1.0)
    process = before * remembered + noise * fresh
    expected = values - (0.0 - process * std)
    noise_elements.wander(values, before, elapsed, std, time, noise, out)
    assert noise.tobytes() == process.tobytes()
    assert out.tobytes() == expected.tobytes()


def test_noise_that_grows_with_the_way(rng):
    travels, noise, variance = rng.normal(size=(ROWS, SIZE)), rng.normal(size=(ROWS, SIZE)), column(0.0, 1e-3, 1)
    travels[:, 0] = -0.0
    expected = travels - (0.0 - np.sqrt(np.abs(travels) * variance) * noise)
    noise_elements.diffuse(travels, variance, noise)
    assert noise.tobytes() == expected.tobytes()


def test_a_compass_deviates(rng, values):
    values = values * rng.choice((1.0, 10.0, 1000.0), values.shape)
    a, b, c, d, e = (column(-0.3, 0.3, seed) for seed in range(5))
    heading = np.where(np.isfinite(values), values, 0.0)
    once, twice = b * np.sin(heading) + c * np.cos(heading), d * np.sin(2.0 * heading) + e * np.cos(2.0 * heading)
    out = np.empty(values.shape)
    noise_elements.deviate(values, a, b, c, d, e, out)
    np.testing.assert_array_equal(out, values - (0.0 - (a + once + twice)))


def test_wheels_slip_for_the_part_of_a_step_that_it_lasts(rng, elapsed):
    travels, steps = rng.normal(size=(ROWS, SIZE)), rng.integers(0, 9, (ROWS, 1))
    at, duration, factor = column(0.0, 1.0, 1), column(0.0, 1.0, 2), column(0.0, 1.5, 3)
    slips = rng.integers(0, 2, travels.shape).astype(float)
    begin = steps * elapsed
    covered = np.minimum(begin + elapsed, at + duration) - np.maximum(begin, at)
    part = np.where(elapsed > 0.0, covered / np.where(elapsed > 0.0, elapsed, 1.0), 0.0)
    part = np.minimum(np.maximum(part, 0.0), 1.0)
    out = np.empty(travels.shape)
    noise_elements.slip(travels, steps, elapsed, at, duration, factor, slips, out)
    assert out.tobytes() == (travels * (1.0 - (1.0 - factor) * part * slips)).tobytes()
    assert ((part > 0.0) & (part < 1.0)).any()
