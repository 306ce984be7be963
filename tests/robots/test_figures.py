"""Figures of the robots, against the drivers, models and manuals that they are from."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

import amorsim as am
from tests import building

FILES = sorted(Path(am.__file__).parent.glob("robots/*.toml")) + sorted(Path(am.__file__).parent.glob("devices/*.toml"))


@pytest.fixture
def load(tmp_path):
    def loaded(model: str) -> am.Robot:
        """A robot of this model as it ships."""
        (tmp_path / "room.wld").write_text("0 0 9000 0\n9000 0 9000 9000\n9000 9000 0 9000\n0 9000 0 0\n")
        path = tmp_path / "scenario.toml"
        path.write_text(
            'format = 1\n[world]\nmap = "room.wld"\n[[robots]]\nname = "it"\n'
            f'model = "{model}"\npose = {{ x = 4.0, y = 4.0 }}\n'
        )
        return am.load(path).robots[0]

    return loaded


def test_wheels_of_a_pioneer_3dx_are_330_mm_apart(load):
    # Webots' Pioneer3dx.proto: joints 165 mm to either side; CoppeliaSim's model: 0.330 m.
    assert load("pioneer3dx").drive.track == pytest.approx(0.33, abs=1e-12)


def test_a_youbot_has_the_wheels_of_its_driver(load):
    # youbot_driver, config/youbot-base.cfg.
    drive = load("youbot").drive
    for wheel in ("front_left", "front_right", "rear_left", "rear_right"):
        assert getattr(drive, f"wheel_radius_{wheel}") == 0.0475
    assert drive.wheelbase == 0.47
    assert drive.track == 0.30


def test_a_youbot_counts_by_the_gear_of_its_driver(load):
    # GearRatio 364 / 9405, 4000 encoder ticks a turn of the motor.
    encoder = load("youbot").sensors["encoder"].sensor
    np.testing.assert_allclose(encoder.counts_per_revolution, 4000.0 * 9405.0 / 364.0, rtol=1e-9)


def test_a_turtlebot3_has_a_beam_straight_ahead_and_one_every_degree(load):
    # hls_lfcd_lds_driver: from 0 by 2 pi / 360, 360 ranges.
    bearings = np.degrees(load("turtlebot3_burger").sensors["laser"].sensor.bearings()[0])
    np.testing.assert_allclose(bearings, np.arange(-180.0, 180.0), atol=1e-9)


def test_the_laser_of_the_car_sits_to_the_left_of_its_middle(load):
    # Victoria Park: a = 3.78 m ahead of the rear axle, b = 0.50 m to the left.
    car = load("car")
    mount = car.sensors["laser"].mount
    assert (mount.x, mount.y, mount.heading) == (3.78, 0.5, 0.0)
    drive = car.drive
    assert (drive.wheelbase, drive.track) == (2.83, 2 * 0.76)


@pytest.mark.parametrize("metres", [0.1, 0.2, 0.4, 0.8])
def test_both_calibrations_of_a_b21r_agree(load, metres):
    # Player's rflex.cc: range = 4000 b^-2 m in its later version, (0.0005456 b)^-2.086 mm in its earlier one. They
    # differ by 5.3 % of the value at most, at the far end.
    sensor = load("b21r").sensors["infrared"].sensor
    value = np.interp(metres, sensor.distances, sensor.values)
    assert value == pytest.approx(math.sqrt(4000.0 / metres), rel=0.003)
    assert value == pytest.approx((1000.0 * metres) ** (-1.0 / 2.086) / 0.0005456, rel=0.055)


def test_a_khepera_that_sees_nothing_reads_whole_counts_from_0_to_6_evenly(load):
    # The Khepera Simulator's robot.c: a value below 7 becomes Rnd(7).
    scenario = building.scenario(load("khepera"), map=building.empty(10.0))
    sim = am.Simulation(scenario, seed=4, replicas=500)
    values = []
    for _ in range(10):
        sim.step()
        assert not sim.readings["infrared"].true.any()
        values.append(sim.readings["infrared"].measured)
    assert np.shape(values) == (10, 500, 8)
    found, counts = np.unique(values, return_counts=True)
    np.testing.assert_array_equal(found, np.arange(7.0))
    # 40,000 draws into 7 bins: chi-squared with 6 degrees of freedom is above 27.9 once in 10,000.
    expected = counts.sum() / 7.0
    assert ((counts - expected) ** 2 / expected).sum() < 27.9


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_every_file_says_what_rests_on_how_many_sources(path):
    head = path.read_text(encoding="utf-8").split("\nformat = 1")[0]
    assert "Sources" in head
    assert "no second source was found" in head.replace("\n# ", " ")
