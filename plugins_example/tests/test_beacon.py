"""The beacon's bearing against trigonometry, and what hides it."""

import math

import amorsim_example as example
import numpy as np
import pytest
from example_world import open_ground, robot, simulation

import amorsim as am


def reading(sim: am.Simulation, name: str = "lift") -> float:
    return float(sim.robot(name).readings["beacon"].true[0])


def lift(x: float, y: float, heading: float, *, name: str = "lift", mount: am.Mount | None = None) -> am.Robot:
    beacon = am.MountedSensor(sensor=example.Beacon(x=3.0, y=4.0, range_max=10.0), mount=mount or am.Mount())
    return robot(name=name, sensors={"beacon": beacon}, estimators={}, pose=am.Pose(x=x, y=y, heading=heading))


@pytest.mark.parametrize(
    ("x", "y", "heading", "expected"),
    [
        (0.0, 0.0, 0.0, math.atan2(4.0, 3.0)),
        (3.0, -2.0, 0.0, math.pi / 2),
        (6.0, 8.0, 0.3, math.atan2(-4.0, -3.0) - 0.3),
        (6.0, 8.0, 3.0, math.atan2(-4.0, -3.0) - 3.0 + 2 * math.pi),
    ],
)
def test_bearing_is_that_of_the_triangle(x: float, y: float, heading: float, expected: float) -> None:
    assert reading(simulation(lift(x, y, heading))) == pytest.approx(expected, abs=1e-12)


def test_it_is_seen_from_the_mount() -> None:
    # The mount is at (0, 0.5) in the world and looks along y.
    sim = simulation(lift(0.0, 0.0, math.pi / 2, mount=am.Mount(x=0.5, heading=0.2)))
    assert reading(sim) == pytest.approx(math.atan2(3.5, 3.0) - math.pi / 2 - 0.2, abs=1e-12)


def test_a_wall_between_hides_it_and_one_behind_does_not() -> None:
    assert reading(simulation(lift(0.0, 0.0, 0.0), map=open_ground((0.0, 3.0, 5.0, 3.0)))) == math.inf
    behind = open_ground((0.0, 4.5, 5.0, 4.5))
    assert reading(simulation(lift(0.0, 0.0, 0.0), map=behind)) == pytest.approx(math.atan2(4.0, 3.0))


def test_another_robot_between_hides_it() -> None:
    sim = simulation(lift(0.0, 0.0, 0.0), lift(1.5, 2.0, 0.0, name="other"))
    assert reading(sim) == math.inf
    assert math.isfinite(reading(sim, "other"))


@pytest.mark.parametrize(("x", "seen"), [(-6.9, True), (-7.1, False)])
def test_it_is_seen_as_far_as_its_range(x: float, seen: bool) -> None:
    assert math.isfinite(reading(simulation(lift(x, 4.0, 0.0)))) is seen


def test_noise_leaves_a_hidden_beacon_hidden() -> None:
    noisy = am.MountedSensor(
        sensor=example.Beacon(x=3.0, y=4.0, range_max=4.0),
        noise=(
            am.NoiseElement(name="drift", noise=example.Drift(std=0.1)),
            am.NoiseElement(name="gaussian", noise=am.noise.Gaussian(std=0.1)),
        ),
    )
    sim = simulation(robot(sensors={"beacon": noisy}, estimators={}))
    sim.run(1.0)
    np.testing.assert_array_equal(sim.readings["beacon"].measured, [[np.inf]])
