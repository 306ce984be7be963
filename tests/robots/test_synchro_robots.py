"""Rings of infrared and bumpers of the robots on synchro drives, against the drivers that their figures are from."""

import math
from typing import Any

import attrs
import numpy as np
import pytest

import amorsim as am
from amorsim.core.shapes import Shape
from amorsim.scenario.reading import read
from amorsim.scenario.spec import Obstacle
from tests.building import empty


@pytest.fixture
def build(tmp_path):
    (tmp_path / "room.wld").write_text("0 0 9000 0\n9000 0 9000 9000\n9000 9000 0 9000\n0 9000 0 0\n")

    def built(model: str, *posts: tuple[float, float], **commands: float) -> am.Simulation:
        """A robot of this model at the middle of an empty map, with thin posts at (distance of the face, bearing)."""
        document = {
            "format": 1,
            "world": {"map": "room.wld"},
            "robots": [{"name": "it", "model": model, "pose": {"x": 4.0, "y": 4.0}}],
        }
        robot = attrs.evolve(read.loads(document, tmp_path).robots[0], pose=am.Pose())
        obstacles = []
        for i, (distance, bearing) in enumerate(posts):
            far = distance + 0.01
            place = am.Pose(x=far * math.cos(bearing), y=far * math.sin(bearing))
            obstacles.append(Obstacle(name=f"post{i}", shape=Shape.circle(0.01), pose=place))
        return am.Simulation(am.Scenario(map=empty(20.0), robots=[robot], obstacles=obstacles))

    return built


def reading(sim: am.Simulation, name: str) -> Any:
    return sim.robot("it").readings[name]


@pytest.mark.parametrize("metres", [0.1, 0.2, 0.33, 0.6, 0.799])
def test_the_driver_of_a_b21r_makes_the_range_of_what_a_device_answers(build, metres):
    # Player's rflex.cc takes the byte b for 4000 / b^2; straight lines between points are off by 0.5 % at most.
    found = reading(build("b21r", (0.25 + metres, math.radians(7.5))), "infrared")
    (seen,) = np.flatnonzero(found.true)
    assert seen == 11
    assert 4000.0 / found.true[seen] ** 2 == pytest.approx(metres, rel=0.005)
    assert found.measured[seen] == np.rint(found.true[seen])


def test_a_b21r_sees_nothing_by_infrared_beyond_what_its_driver_tells(build):
    assert not reading(build("b21r", (0.25 + 0.801, math.radians(7.5))), "infrared").true.any()


@pytest.mark.parametrize(
    ("bearing", "pressed"),
    # Player's bumper_def: six of 60 degrees from 150 on downwards; eight of 45, of which the first are at the back.
    [(170, (0, 7)), (100, (1, 8)), (50, (2, 9)), (10, (2, 10)), (-10, (3, 11)), (-100, (4, 13)), (-170, (5, 6))],
)
def test_a_b21r_feels_a_post_with_two_of_its_panels(build, bearing, pressed):
    bumper = reading(build("b21r", (0.261, math.radians(bearing))), "bumper")
    assert len(bumper.true) == 14
    assert tuple(np.flatnonzero(bumper.true)) == pressed


@pytest.mark.parametrize("bearing", [5.0, 9.0, 40.0, 100.0, 185.0, -50.0])
def test_a_nomad_feels_a_post_with_two_of_its_twenty_panels(build, bearing):
    # Player's nomad.cc: number i at 18 i degrees, a tenth of the rim long each.
    bumper = reading(build("nomad200", (0.266, math.radians(bearing))), "bumper")
    off = (np.arange(20) * 18.0 - bearing + 180.0) % 360.0 - 180.0
    np.testing.assert_array_equal(bumper.true, np.abs(off) < 18.0)


def test_a_nomad_ranges_by_infrared_in_whole_inches(build):
    sim = build("nomad200", (0.225 + 0.30, 0.0), (0.225 + 0.62, math.radians(90.0)))
    found = reading(sim, "infrared")
    assert found.true[0] == pytest.approx(0.30, abs=1e-9)
    assert found.measured[0] == pytest.approx(12 * 0.0254)
    assert np.isinf(found.true[1:]).all()


@pytest.mark.parametrize(
    ("model", "counts"),
    [("b21r", [35000.0, 103000.0 * 0.05]), ("nomad200", [1800.0 / math.pi, 0.05 / 0.00254, 1800.0 / math.pi])],
)
def test_every_joint_is_counted_as_its_driver_says(build, model, counts):
    group = build(model)._fleet.groups[0]
    encoder = group.sensors["encoder"].sensor
    np.testing.assert_allclose(encoder.counts_per_revolution[0] / (2.0 * math.pi), counts, rtol=1e-4)
