"""Values that are lost, drowned, far off, or frozen."""

import math

import numpy as np
import pytest
from scipy.special import ndtr

from amorsim.core.parameters import ParameterError
from amorsim.noise import Dropout, NoiseFloor, Outliers, Stuck
from tests.noise.sampling import (
    ROWS,
    Samples,
    assert_distributed,
    assert_moments,
    assert_share,
    assert_uncorrelated,
)


def test_values_are_lost_with_their_probability_each_by_itself():
    samples = Samples(Dropout(probability=0.1), rows=ROWS)
    lost = [np.isinf(found) for found in samples.series(4, values=2.0)]
    for one in lost:
        assert_share(one, 0.1)
    assert_uncorrelated(*lost)
    assert_uncorrelated(*lost[0].T)


def test_what_is_not_lost_keeps_its_bits_and_what_is_lost_reads_as_set():
    values = np.random.default_rng(1).normal(size=(ROWS, 4))
    found = Samples(Dropout(probability=0.25, report="value", value=8.0), rows=ROWS).take(values)
    assert_share(found == 8.0, 0.25)
    assert (found[found != 8.0] == values[found != 8.0]).all()


def test_a_lost_value_reads_as_the_one_before():
    samples = Samples(Dropout(probability=0.5, report="last"), rows=ROWS)
    assert (samples.take(0.0) == 0.0).all()  # before the first there was none to hold
    for i in (1.0, 2.0, 3.0):
        found = samples.take(i)
    # Held j samples long with probability 2^-(j + 1), and from the start on if all were lost.
    for value, probability in ((3.0, 0.5), (2.0, 0.25), (1.0, 0.125), (0.0, 0.125)):
        assert_share(found == value, probability)


def test_losses_of_all_kinds_are_the_same_losses():
    taken = [
        Samples(noise, rows=100).series(3, values=1.0)
        for noise in (Dropout(probability=0.3), Dropout(probability=0.3, report="value", value=9.0))
    ]
    assert (np.isinf(taken[0]) == (taken[1] == 9.0)).all()


@pytest.mark.parametrize(
    ("given", "problem"),
    [
        ({"report": "value"}, "a number with report"),
        ({"value": 3.0}, "none without report"),
    ],
)
def test_a_value_goes_with_its_report_only(given, problem):
    with pytest.raises(ParameterError, match=problem):
        Dropout(probability=0.1, **given)


def test_values_from_0_up_to_the_level_drown_and_others_keep_their_bits():
    values = np.array([[-1e-300, 0.0, 6.999, 7.0], [math.inf, -7.0, 40.0, 1023.0]])
    found = Samples(NoiseFloor(level=7.0), rows=2).take(values)
    drowned = np.array([[False, True, True, False], [False, False, False, False]])
    np.testing.assert_array_equal(found != values, drowned)
    assert ((found[drowned] >= 0.0) & (found[drowned] <= 7.0)).all()


def test_outliers_are_a_contaminated_normal_distribution():
    samples = Samples(Outliers(probability=0.2, std=3.0), rows=ROWS)
    found = samples.take(1.0)
    off = found != 1.0
    assert_share(off, 0.2)
    assert_moments(found, 3.0 * math.sqrt(0.2), mean=1.0, kurtosis=3.0 / 0.2)
    assert_distributed(found[off], lambda x: ndtr((x - 1.0) / 3.0))
    again = samples.take(1.0)
    assert_uncorrelated(found, again)
    assert_uncorrelated(off, again != 1.0)


def test_outliers_come_at_the_same_places_whatever_their_size():
    small, large = (Samples(Outliers(probability=0.2, std=std), rows=1000).take() for std in (0.5, 2.0))
    np.testing.assert_allclose(large, 4.0 * small, rtol=1e-12)
    assert (
        Samples(Outliers(probability=1.0, std=1.0), rows=1000).take()[small != 0.0] == 2.0 * small[small != 0]
    ).all()


def frozen_after(time, elapsed, scope="value", rate=0.8, duration=0.5):
    """Which values are frozen at the time [s] when time passes in steps of `elapsed` [s]."""
    samples = Samples(Stuck(rate=rate, duration=duration, scope=scope), rows=ROWS)
    first = samples.take(0.0)
    assert (first == 0.0).all()
    steps = round(time / elapsed)
    for i in range(1, steps + 1):
        found = samples.take(float(i), elapsed=elapsed)
    return found != float(steps)


@pytest.mark.parametrize("elapsed", [0.1, 0.4, 1.2])
def test_faults_come_alike_however_often_the_device_reads(elapsed):
    # Of the two-state chain, sound at first: the share that is frozen after a time t.
    both = 0.8 + 1.0 / 0.5
    assert_share(frozen_after(1.2, elapsed), 0.8 / both * (1.0 - math.exp(-both * 1.2)))


def test_faults_take_their_part_of_the_time_and_last_as_long_as_set():
    samples = Samples(Stuck(rate=0.8, duration=0.5), rows=ROWS)
    samples.take()
    samples.take(1.0, elapsed=50.0)
    frozen = samples.state["frozen"].copy()
    assert_share(frozen, 0.8 * 0.5 / (1.0 + 0.8 * 0.5))
    samples.take(2.0, elapsed=0.3)
    later = samples.state["frozen"]
    # What was forgotten after a time t: all but exp(-(0.8 + 2) t) of the present state.
    share, kept = 0.8 / 2.8, math.exp(-2.8 * 0.3)
    assert_share(later[frozen], share + (1.0 - share) * kept)
    assert_share(later[~frozen], share - share * kept)


def test_what_is_frozen_repeats_what_was_said_last():
    samples = Samples(Stuck(rate=1.0, duration=1.0), rows=2000)
    said = samples.take(0.0)
    for i in range(1, 6):
        found = samples.take(float(i))
        frozen = samples.state["frozen"]
        assert frozen.any()
        assert (found == np.where(frozen, said, float(i))).all()
        said = found


def test_all_values_of_a_sensor_freeze_at_once_if_set():
    frozen = frozen_after(1.2, 0.4, scope="sensor")
    assert (frozen == frozen[:, :1]).all()
    both = 0.8 + 1.0 / 0.5
    # One of four as many draws.
    assert_share(frozen[:, 0], 0.8 / both * (1.0 - math.exp(-both * 1.2)))
