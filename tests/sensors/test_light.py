"""Ambient light: the Khepera's published answer, illuminance, and what is in a lamp's way."""

import math

import numpy as np
import pytest

import amorsim as am
from amorsim.core.parameters import ParameterError
from amorsim.core.shapes import Shape
from amorsim.scenario.spec import Light as Lamp
from amorsim.scenario.spec import Obstacle, Pose
from amorsim.sensors import Light
from tests.building import empty, robot, scenario


def reading(*lamps, sensor=None, obstacles=(), world=None, pose=Pose()):  # noqa: B008 - frozen
    khepera = robot(shape=Shape.circle(0.0275), pose=pose, sensors={"eye": sensor or Light()}, estimators={})
    made = scenario(khepera, map=world or empty(10.0), lights=lamps, obstacles=obstacles)
    return am.Simulation(made).robot("rover").readings["eye"].true


def published(*lamps):
    """What the Khepera Simulator 2.0 says of lamps at (mm, angle off the axis): its formula, in its units."""
    value = 500.0
    for millimetres, angle in lamps:
        closeness = (250.0 - millimetres) / 250.0
        if closeness > 0.0 and abs(angle) < math.pi / 3.0:
            value -= math.cos(1.5 * angle) * closeness * 450.0
    return max(value, 50.0)


@pytest.mark.parametrize(
    "lamps",
    [
        [],
        [(100.0, 0.0)],
        [(100.0, 0.5)],
        [(100.0, -1.04)],
        [(100.0, 1.05)],
        [(249.0, 0.2)],
        [(251.0, 0.2)],
        [(60.0, 0.3), (120.0, -0.8)],
        [(40.0, 0.1), (50.0, -0.1)],  # brighter than it can tell
    ],
)
def test_it_answers_as_published(lamps):
    placed = [Lamp(x=d / 1000.0 * math.cos(a), y=d / 1000.0 * math.sin(a)) for d, a in lamps]
    assert reading(*placed) == [pytest.approx(published(*lamps), rel=1e-12)]


def test_with_inverse_squares_it_reads_illuminance():
    meter = Light(falloff="inverse_square", half_angle=math.pi / 2, dark=0.0, gain=1.0, bright=None)
    lamps = [Lamp(x=2.0, y=1.0, intensity=100.0), Lamp(x=0.5, y=-0.5, intensity=3.0), Lamp(x=-1.0, intensity=50.0)]
    # E = I cos(b) / d^2, with cos(b) = x / d
    expected = 100.0 * 2.0 / 5.0**1.5 + 3.0 * 0.5 / 0.5**1.5
    assert reading(*lamps, sensor=meter) == [pytest.approx(expected, rel=1e-12)]


def test_walls_and_bodies_are_in_a_lamps_way_and_what_is_behind_it_is_not():
    lamp = Lamp(x=0.1)
    lit = published((100.0, 0.0))
    post = {"name": "post", "shape": Shape.circle(0.005)}
    assert reading(lamp, obstacles=[Obstacle(**post, pose=Pose(x=0.05))]) == [500.0]
    assert reading(lamp, obstacles=[Obstacle(**post, pose=Pose(x=0.12))]) == [pytest.approx(lit)]
    for x, expected in ((0.07, 500.0), (0.13, lit)):
        world = am.Map.from_segments(np.array([[x, -1.0, x, 1.0]]), resolution=0.001, extent=(-1, -1, 1, 1))
        assert reading(lamp, world=world) == [pytest.approx(expected)]


def test_each_element_looks_its_own_way():
    ring = Light(elements=tuple(am.Mount(heading=h) for h in (0.0, math.pi / 2, math.pi)))
    values = reading(Lamp(x=-0.05, y=0.1), sensor=ring, pose=Pose(heading=math.pi / 2))
    d = math.hypot(50.0, 100.0)
    expected = [published((d, math.atan2(50, 100))), published((d, math.atan2(50, 100) - math.pi / 2)), 500.0]
    np.testing.assert_allclose(values, expected, rtol=1e-12)


@pytest.mark.parametrize("falloff", ["linear", "inverse_square"])
def test_of_many_lamps_each_adds_what_it_adds_alone_however_many_are_looked_at_together(falloff, monkeypatch):
    random = np.random.default_rng(5)
    ring = Light(
        elements=tuple(am.Mount(x=0.1, heading=h) for h in (-0.5, 0.4, 2.0)),
        falloff=falloff,
        reach=2.5,
        dark=0.0,
        gain=1.0,
        bright=None,
    )
    robots = [
        robot(
            name=f"r{i}",
            shape=Shape.circle(0.15),
            pose=Pose(x=x, y=y, heading=6.0 * x),
            sensors={"eye": ring},
            estimators={},
        )
        for i, (x, y) in enumerate([(1.0, 1.0), (2.0, 1.4), (2.2, 3.0), (4.5, 2.5)])
    ]
    lamps = [Lamp(x=x, y=y, intensity=i) for x, y, i in random.uniform(0.2, 4.8, (12, 3)).tolist()]

    def read(lights):
        sim = am.Simulation(scenario(*robots, lights=lights))
        return np.array([sim.robot(f"r{i}").readings["eye"].true for i in range(4)])

    together = read(lamps)
    alone = [read([lamp]) for lamp in lamps]
    total = np.zeros_like(together)
    for one in alone:
        total = total + one
    np.testing.assert_array_equal(together, total)
    assert (together > 0.0).sum() > 4
    monkeypatch.setattr("amorsim.sensors.light._MOST_RAYS", 25)
    np.testing.assert_array_equal(read(lamps), together)


@pytest.mark.parametrize(("change", "name"), [({"bright": 900.0}, "bright"), ({"elements": ()}, "elements")])
def test_what_makes_no_sense_is_refused_by_name(change, name):
    with pytest.raises(ParameterError, match=name):
        Light(**change)
