"""Devices on the bench: each error that was put in is found, and the intervals cover it as often as they say."""

from __future__ import annotations

import math
import tracemalloc
from typing import Any

import attrs
import numpy as np
import pytest

import amorsim as am
from amorsim.noise.bias import Bias
from amorsim.noise.gaussian import Gaussian
from amorsim.noise.latency_jitter import LatencyJitter
from amorsim.noise.quantize import Quantize
from amorsim.noise.scale import Scale
from amorsim.scenario.spec import Deviation, MountedSensor, Scenario
from amorsim.sensors.compass import Compass
from amorsim.sensors.gyro import Gyro
from amorsim.sensors.laser import Laser
from amorsim.studies.calibration import calibrate_compass, calibrate_gyro, calibrate_range
from tests import building

# Fewer than 33 of 40 come with a probability of 0.001 if each covers with 0.95.
TRIALS, ENOUGH = 40, 33
assert sum(math.comb(TRIALS, k) * 0.95**k * 0.05 ** (TRIALS - k) for k in range(ENOUGH)) < 2e-3


def _scenario(name: str, sensor: Any, *noise: Any, seed: int = 1, errors: Any = None, **mounted: Any) -> Scenario:
    unit = MountedSensor(sensor=sensor, noise=building.chain(*noise), **mounted)
    robot = building.robot(sensors={"encoder": building.encoder(), name: unit}, errors=errors or {})
    return building.scenario(robot, seed=seed)


def test_a_gyro_without_noise_shows_its_scale_and_bias() -> None:
    name, found = calibrate_gyro(_scenario("gyro", Gyro(), Scale(factor=1.03), Bias(value=0.02)), runs=2)
    assert name == "gyro"
    assert found["scale"].value == pytest.approx(1.03, abs=1e-9)
    assert found["bias"].value == pytest.approx(0.02, abs=1e-9)
    assert max(interval.half_width for interval in found.values()) < 1e-9


def test_readings_that_come_seldom_and_late_are_of_the_turns_they_are_of() -> None:
    scenario = _scenario("gyro", Gyro(), Scale(factor=0.98), Bias(value=-0.01), rate=4.0, latency=0.35)
    _, found = calibrate_gyro(scenario, runs=2)
    assert found["scale"].value == pytest.approx(0.98, abs=1e-9)
    assert found["bias"].value == pytest.approx(-0.01, abs=1e-9)


@pytest.mark.long
def test_a_gyros_intervals_cover_what_was_put_in() -> None:
    hits = np.zeros(2, dtype=int)
    for seed in range(TRIALS):
        noise = (Scale(factor=1.01), Bias(value=0.005), Gaussian(std=0.004))
        _, found = calibrate_gyro(_scenario("gyro", Gyro(), *noise, seed=seed), runs=4)
        hits += (found["scale"].covers(1.01), found["bias"].covers(0.005))
        assert found["bias"].half_width < 0.004
    assert hits.min() >= ENOUGH


def test_a_compass_shows_the_deviation_it_has() -> None:
    from amorsim.noise.compass_deviation import CompassDeviation

    put = {"a": 0.02, "b": 0.1, "c": -0.15, "d": 0.01, "e": -0.03}
    name, found = calibrate_compass(_scenario("compass", Compass(), CompassDeviation(**put)), runs=2)
    assert name == "compass"
    assert {key: interval.value for key, interval in found.items()} == pytest.approx(put, abs=1e-9)


def test_a_compass_that_is_mounted_askew_and_late_shows_it_in_a() -> None:
    errors = {"sensors.compass.mount.heading": Deviation(add=0.03)}
    scenario = _scenario(
        "compass", Compass(), Bias(value=0.01), errors=errors, mount=am.Mount(heading=3.0), rate=3.0, latency=0.2
    )
    _, found = calibrate_compass(scenario, runs=2)
    assert found["a"].value == pytest.approx(0.04, abs=1e-9)
    for key in "bcde":
        assert found[key].value == pytest.approx(0.0, abs=1e-9)


@pytest.mark.long
def test_a_compass_intervals_cover_what_was_put_in() -> None:
    from amorsim.noise.compass_deviation import CompassDeviation

    put = {"a": 0.02, "b": 0.1, "c": -0.15, "d": 0.01, "e": -0.03}
    hits = dict.fromkeys(put, 0)
    for seed in range(TRIALS):
        scenario = _scenario("compass", Compass(), CompassDeviation(**put), Gaussian(std=0.01), seed=seed)
        for key, interval in calibrate_compass(scenario, runs=3)[1].items():
            hits[key] += interval.covers(put[key])
    assert min(hits.values()) >= ENOUGH


def test_only_the_tested_beam_is_kept() -> None:
    scenario = _scenario("laser", Laser(beams=721, range_max=8.0))
    calibrate_range(scenario, runs=2)  # what is kept for good is made now
    tracemalloc.start()
    try:
        calibrate_range(scenario, runs=8)
        most = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    assert most < 200 * 8 * 721 * 8  # [bytes] of all beams of 200 readings in 8 runs


@pytest.mark.long
def test_a_range_sensors_bias_and_spread_are_found() -> None:
    hits = np.zeros(2, dtype=int)
    for seed in range(TRIALS // 4):
        laser = _scenario("laser", Laser(beams=19, range_max=8.0), Bias(value=0.02), Gaussian(std=0.01), seed=seed)
        name, element, found = calibrate_range(laser, runs=5)
        assert (name, element) == ("laser", 9)
        # Within a cell of the wall.
        assert [at.distance for at in found] == pytest.approx([2.0, 4.0, 6.0], abs=1.1e-3)
        assert all(at.returned == 1.0 for at in found)
        for at in found:
            hits += (at.bias.covers(0.02), at.sigma.covers(0.01))
            assert at.sigma.half_width < 0.003
    # Of 30, fewer than 24 come with a probability of 0.0005.
    assert hits.min() >= 24


def test_without_noise_a_range_has_no_spread_and_the_bias_of_its_mount_and_rounding() -> None:
    errors = {"sensors.laser.mount.x": Deviation(add=0.05)}
    laser = _scenario("laser", Laser(beams=19, range_max=8.0), errors=errors, mount=am.Mount(x=0.1, heading=1.0))
    for at in calibrate_range(laser, runs=2)[2]:
        assert at.sigma[:3] == (0.0, 0.0, 0.0)
        # The mount's frame is the robot's, the beam looks 1 rad to its left.
        assert at.bias.value == pytest.approx(-0.05 * math.cos(1.0), abs=1e-3)
    rounded = _scenario("laser", Laser(beams=19, range_max=8.0), Quantize(step=0.5))
    assert [at.bias.value for at in calibrate_range(rounded, runs=2)[2]] == pytest.approx([0.0] * 3, abs=1.1e-3)


def test_another_element_and_another_sensor_can_be_named() -> None:
    ring = _scenario("sonar", building.ring(4), Bias(value=0.03))
    name, element, found = calibrate_range(ring, sensor="sonar", element=2, runs=2)
    assert (name, element) == ("sonar", 2)
    assert [at.distance for at in found] == pytest.approx([1.25, 2.5, 3.75], abs=1.1e-3)
    assert [at.bias.value for at in found] == pytest.approx([0.03] * 3, abs=1e-9)


def test_distances_have_draws_of_their_own() -> None:
    laser = _scenario("laser", Laser(beams=3, range_max=8.0), Gaussian(std=0.01))
    assert len({at.bias.value for at in calibrate_range(laser, runs=3)[2]}) == 3


@pytest.mark.parametrize("spread", [0.05, 0.3])
def test_readings_that_arrive_at_other_times_in_each_run_are_of_the_headings_they_are_of(spread: float) -> None:
    jitter = LatencyJitter(spread=spread)
    _, turning = calibrate_gyro(_scenario("gyro", Gyro(), Scale(factor=0.98), jitter, latency=0.3), runs=3)
    assert turning["scale"].value == pytest.approx(0.98, abs=1e-9)
    assert turning["bias"].value == pytest.approx(0.0, abs=1e-9)
    _, deviation = calibrate_compass(_scenario("compass", Compass(), jitter, latency=0.3), runs=3)
    assert max(abs(interval.value) + interval.half_width for interval in deviation.values()) < 1e-9
    _, _, ranges = calibrate_range(_scenario("laser", Laser(beams=19, range_max=8.0), Bias(value=0.02), jitter), runs=3)
    assert [found.bias.value for found in ranges] == pytest.approx([0.02] * 3, abs=1e-9)
    assert [found.returned for found in ranges] == [1.0] * 3


@pytest.mark.parametrize("name", ["kidnapped", "find-yourself"])
def test_the_bench_is_where_the_robot_stays(name: str) -> None:
    """However it starts in its scenario, whatever it knows of that, and wherever it is carried there."""
    scenario = am.load(name)
    assert calibrate_range(scenario, runs=2)[2][0].returned == 1.0
    gyro = {"gyro": MountedSensor(sensor=Gyro(), noise=building.chain(Bias(value=0.02)))}
    robot = attrs.evolve(scenario.robots[0], sensors={**scenario.robots[0].sensors, **gyro})
    _, found = calibrate_gyro(attrs.evolve(scenario, robots=[robot]), runs=2)
    assert found["bias"].value == pytest.approx(0.02, abs=1e-9)


@pytest.mark.long
def test_what_is_not_there_is_refused() -> None:
    scenario = _scenario("gyro", Gyro())
    with pytest.raises(am.AmorsimError, match="robot 'rover': expected a compass; it has: none"):
        calibrate_compass(scenario)
    with pytest.raises(am.AmorsimError, match="expected a gyro, and 'encoder' is none; it has: gyro"):
        calibrate_gyro(scenario, sensor="encoder")
    with pytest.raises(am.AmorsimError, match=r"has no sensor 'gyr'; of that kind it has: gyro.*Did you mean 'gyro'"):
        calibrate_gyro(scenario, sensor="gyr")
    with pytest.raises(am.AmorsimError, match="runs: expected 2 at least"):
        calibrate_gyro(scenario, runs=1)
    with pytest.raises(am.AmorsimError, match="expected an element from 0 to 18, got 19"):
        calibrate_range(_scenario("laser", Laser(beams=19)), element=19)
    slow = _scenario("gyro", Gyro(), rate=1e-3)
    with pytest.raises(am.AmorsimError, match="too few readings"):
        calibrate_gyro(slow)
