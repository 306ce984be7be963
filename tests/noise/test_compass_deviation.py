"""What iron does to a compass, heading by heading."""

import math

import numpy as np
import pytest

import amorsim as am
from amorsim.noise import CompassDeviation
from tests import building
from tests.noise.sampling import Samples

COEFFICIENTS = {"a": 0.02, "b": -0.15, "c": 0.1, "d": 0.04, "e": -0.03}


def test_the_deviation_is_the_sum_of_its_cycles():
    headings = np.linspace(-math.pi, math.pi, 1000)[None, :]
    found = Samples(CompassDeviation(**COEFFICIENTS), k=1000).take(headings)
    for h, measured in zip(headings[0].tolist(), found[0].tolist(), strict=True):
        expected = 0.02 - 0.15 * math.sin(h) + 0.1 * math.cos(h) + 0.04 * math.sin(2 * h) - 0.03 * math.cos(2 * h)
        assert measured - h == pytest.approx(expected, abs=1e-12)


@pytest.mark.parametrize("name", COEFFICIENTS)
def test_a_swing_recovers_each_coefficient(name):
    """Projected on its own cycle, over headings spread evenly on the circle, the deviation gives the coefficient."""
    h = np.arange(360) * (2.0 * math.pi / 360)
    deviation = Samples(CompassDeviation(**COEFFICIENTS), k=360).take(h[None, :])[0] - h
    cycles = {"b": np.sin(h), "c": np.cos(h), "d": np.sin(2 * h), "e": np.cos(2 * h)}
    found = deviation.mean() if name == "a" else 2.0 * (deviation * cycles[name]).mean()
    assert found == pytest.approx(COEFFICIENTS[name], abs=1e-12)


def test_a_robots_compass_is_off_by_the_deviation_of_its_heading():
    unit = am.MountedSensor(sensor=am.sensors.Compass(), noise=(CompassDeviation(b=0.2),))
    robot = building.robot(estimators={}, sensors={"compass": unit}, pose=am.Pose(x=2.0, y=2.0, heading=0.7))
    reading = am.Simulation(building.scenario(robot)).robot("rover").readings["compass"]
    assert reading.measured[0] == pytest.approx(0.7 + 0.2 * math.sin(0.7), abs=1e-12)
