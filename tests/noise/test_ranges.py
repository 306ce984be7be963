"""The beam model's four parts, and echoes that are lost."""

import math

import numpy as np
import pytest
from scipy.special import ndtr

import amorsim as am
from amorsim.core.errors import ComponentError
from amorsim.core.parameters import ParameterError
from amorsim.noise import BeamModel, SpecularLoss
from amorsim.sensors.sonar import Sonar
from amorsim.testing import check_component
from tests import building
from tests.noise.sampling import ROWS, Samples, assert_distributed, assert_share, assert_uncorrelated

RANGE = 5.0


def taken(value=3.0, **parts):
    return Samples(BeamModel(range_max=RANGE, **parts), rows=ROWS).take(value)


def test_the_mixture_is_the_sum_of_its_parts():
    """Everything but no return, against the mixture's distribution function."""
    z, std, rate = 3.0, 0.1, 0.7
    found = taken(z, hit=0.6, short=0.2, max=0.05, random=0.15, std=std, short_rate=rate)
    assert_share(np.isinf(found), 0.05)

    def cumulative(x):
        hit = ndtr((x - z) / std)
        short = np.where(x < z, np.expm1(-rate * np.minimum(x, z)) / math.expm1(-rate * z), 1.0)
        return (0.6 * hit + 0.2 * short + 0.15 * x / RANGE) / 0.95

    assert_distributed(found[np.isfinite(found)], cumulative)


def test_each_part_alone_has_its_own_distribution():
    assert_distributed(taken(hit=1.0, std=0.1), lambda x: ndtr((x - 3.0) / 0.1))
    short = taken(hit=0.0, short=1.0, short_rate=2.0)
    assert short.max() <= 3.0
    assert_distributed(short, lambda x: np.expm1(-2.0 * x) / math.expm1(-6.0))
    assert_distributed(taken(hit=0.0, random=1.0), lambda x: x / RANGE)
    assert np.isinf(taken(hit=0.0, max=1.0)).all()


def test_where_nothing_returned_things_in_front_may_be_anywhere():
    found = taken(math.inf, hit=0.5, short=0.3, max=0.1, random=0.1, short_rate=1.0, std=0.2)
    assert_share(np.isinf(found), 0.6)
    share = np.isfinite(found)
    assert_distributed(
        found[share], lambda x: 0.75 * np.expm1(-x) / math.expm1(-RANGE) + 0.25 * np.minimum(x / RANGE, 1.0)
    )


def test_a_hit_stays_within_the_range():
    near = taken(0.05, hit=1.0, std=0.1)
    assert_share(near == 0.0, float(ndtr(-0.5)))
    far = taken(4.95, hit=1.0, std=0.1)
    assert_share(far == RANGE, float(ndtr(-0.5)))


def test_beams_and_scans_are_independent():
    samples = Samples(BeamModel(range_max=RANGE, hit=0.7, random=0.3, std=0.1), rows=ROWS)
    first, second = samples.take(3.0), samples.take(3.0)
    assert_uncorrelated(first, second)
    assert_uncorrelated(*first.T)
    assert_uncorrelated(*np.abs(first - 3.0).T)


def test_a_part_that_is_taken_leaves_the_noise_of_the_others():
    """Common random numbers: a beam that is a hit in both has the same noise."""
    pure = taken(hit=1.0, std=0.1)
    mixed = taken(hit=0.5, random=0.5, std=0.1)
    assert_share(pure == mixed, 0.5)


def test_the_weights_must_sum_to_one():
    with pytest.raises(ParameterError, match=r"sum to 1, got 1\.2"):
        BeamModel(range_max=RANGE, hit=0.7, short=0.5)
    BeamModel(range_max=RANGE, hit=0.7, short=0.1, max=0.1, random=0.1)


def test_the_beam_model_keeps_its_contract_with_all_parts_in_play():
    parts = {"hit": 0.4, "short": 0.2, "max": 0.2, "random": 0.2, "std": 0.05, "short_rate": 0.5}
    check_component(BeamModel(range_max=8.0, **parts), values_of="laser", inf="changed")


def test_returns_beyond_the_critical_angle_are_lost():
    incidence = np.array([[0.0, 0.29, 0.3, 0.31]])
    found = Samples(SpecularLoss(critical=0.3)).take(2.0, side={"incidence": incidence})
    assert found.tolist() == [[2.0, 2.0, 2.0, math.inf]]


def test_a_sensor_that_tells_no_incidence_is_refused():
    with pytest.raises(ComponentError, match="angle of incidence"):
        Samples(SpecularLoss(critical=0.3)).take(2.0)
    robot = building.robot(
        estimators={}, sensors={"gyro": am.MountedSensor(sensor=am.sensors.Gyro(), noise=(SpecularLoss(critical=0.3),))}
    )
    with pytest.raises(ComponentError, match="angle of incidence"):
        am.Simulation(building.scenario(robot))


@pytest.mark.parametrize(("heading", "returns"), [(0.0, True), (20.0, True), (32.0, True), (38.0, False)])
def test_a_sonar_hears_a_wall_until_it_is_too_slanting(heading, returns):
    """Half a cone of 10 degrees: at 32 degrees the nearest return meets the wall at 22, at 38 at 28."""
    sonar = am.MountedSensor(
        sensor=Sonar(half_angle=math.radians(10.0)), noise=(SpecularLoss(critical=math.radians(25.0)),)
    )
    robot = building.robot(
        estimators={}, sensors={"sonar": sonar}, pose=am.Pose(x=4.5, y=2.5, heading=math.radians(heading))
    )
    reading = am.Simulation(building.scenario(robot)).robot("rover").readings["sonar"]
    assert np.isfinite(reading.true).all()
    assert bool(np.isfinite(reading.measured).all()) is returns
