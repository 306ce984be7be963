"""The Khepera's infrared sensors: the published table, point by point, and what lies between."""

import math

import numpy as np
import pytest

import amorsim as am
from amorsim.core.parameters import ParameterError
from amorsim.core.shapes import Shape
from amorsim.scenario.spec import Obstacle, Pose
from amorsim.sensors import Infrared
from tests.building import empty, robot, scenario

# O. Michel, Khepera Simulator 2.0: probe points of a sensor [mm] and what each answers.
AHEAD = [(12.0, 900), (20.0, 750), (32.0, 650), (44.0, 160), (58.0, 40)]
BESIDE = [(5.7, 1023), (11.3, 800), (18.9, 600), (29.5, 400), (43.9, 60)]
HAIR = 1e-10  # [m] nearer, for beyond the last point there is no answer
PIN = 1e-4  # [m] radius of a post that one ray meets and no other


def reading(*posts, sensor=None, **changes):
    """What a Khepera's sensor on its rim reads of thin posts at (bearing, distance) from it."""
    elements = (am.Mount(x=0.0275),)
    sensor = sensor or Infrared(elements=elements, **changes)
    shape = Shape.circle(0.0275)
    obstacles = [
        Obstacle(
            name=f"post{i}",
            shape=Shape.circle(PIN),
            pose=Pose(x=0.0275 + (d + PIN) * math.cos(b), y=(d + PIN) * math.sin(b)),
        )
        for i, (b, d) in enumerate(posts)
    ]
    khepera = robot(shape=shape, pose=Pose(), sensors={"ir": sensor}, estimators={})
    sim = am.Simulation(scenario(khepera, map=empty(10.0), obstacles=obstacles))
    return sim.robot("rover").readings["ir"].true


@pytest.mark.parametrize(("millimetres", "counts"), AHEAD)
def test_ahead_it_answers_as_published(millimetres, counts):
    assert reading((0.0, millimetres / 1000.0 - HAIR)) == [pytest.approx(counts, rel=1e-6)]


@pytest.mark.parametrize("side", [1.0, -1.0])
@pytest.mark.parametrize(("millimetres", "counts"), BESIDE)
def test_to_either_side_it_answers_as_published(millimetres, counts, side):
    assert reading((side * math.pi / 6, millimetres / 1000.0 - HAIR)) == [pytest.approx(counts, rel=1e-6)]


def test_between_two_points_the_answer_lies_on_a_line():
    assert reading((0.0, 0.038)) == [pytest.approx((650 + 160) / 2, rel=1e-9)]
    assert reading((0.0, 0.001)) == [900.0]
    assert reading((0.0, 0.0581)) == [0.0]


def test_the_rays_add_up_to_saturation():
    far = [(b, 0.04) for b in (-math.pi / 6, 0.0, math.pi / 6)]
    # 40 mm: ahead between 650 and 160, at the sides between 400 and 60.
    expected = 650 - 490 * 8 / 12 + 2 * (400 - 340 * 10.5 / 14.4)
    assert reading(*far) == [pytest.approx(expected, rel=1e-9)]
    assert reading(*[(b, 0.015) for b, _ in far]) == [1023.0]


def test_a_wall_is_met_as_a_body_is():
    walls = np.array([[1.0205, -1.0, 1.0205, 1.0]])
    world = am.Map.from_segments(walls, resolution=0.001, extent=(-1.0, -1.0, 2.0, 1.0))
    sensor = Infrared(elements=(am.Mount(), am.Mount(heading=math.pi)))
    one = robot(shape=Shape.circle(0.01), pose=Pose(x=1.0 - 0.02), sensors={"ir": sensor}, estimators={})
    values = am.Simulation(scenario(one, map=world)).robot("rover").readings["ir"].true
    # 40 mm to the cell's face; the rays beside it end at 46 mm, where nothing answers any more.
    assert values[0] == pytest.approx(650 - 490 * 8 / 12, abs=1e-6)
    assert values[1] == 0.0


@pytest.mark.parametrize(
    ("change", "name"),
    [
        ({"values": (1.0,)}, "values"),
        ({"distances": (0.02, 0.01), "values": (1.0, 2.0)}, "distances"),
        ({"side_distances": (), "side_values": ()}, "side_distances"),
        ({"elements": ()}, "elements"),
        ({"saturation": 0.0}, "saturation"),
    ],
)
def test_a_table_that_is_none_is_refused_by_name(change, name):
    with pytest.raises(ParameterError, match=name):
        Infrared(**change)
