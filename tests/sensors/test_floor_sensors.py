"""What sensors that look down find on the floor: lines, areas and drops."""

import math

import attrs
import numpy as np
import pytest

import amorsim as am
from amorsim.core.parameters import ParameterError
from amorsim.sensors import Cliff, Line
from amorsim.testing import check_component
from tests import building

ROW = tuple(am.Mount(y=0.03 - 0.01 * i) for i in range(7))
FLOOR = am.Floor(
    reflectance=0.9,
    markings=[
        am.Marking(points=((1.0, 1.0), (3.0, 1.0), (3.0, 3.0)), width=0.02, reflectance=0.1),
        am.Marking(shape=am.Shape.circle(0.2), pose=am.Pose(x=2.0, y=1.0), reflectance=0.5),
        am.Marking(points=((2.0, 0.9), (2.0, 1.1)), width=0.02, reflectance=0.2),
    ],
    drops=[
        am.Drop(shape=am.Shape.rectangle(0.5, 0.5), pose=am.Pose(x=3.0, y=3.2, heading=0.4), depth=0.1),
        am.Drop(shape=am.Shape.rectangle(0.1, 0.1), pose=am.Pose(x=1.0, y=3.0), depth=0.02),
    ],
)


def reading(sensor, x, y, heading=0.0, floor=FLOOR):
    rover = building.robot(sensors={"eye": sensor}, estimators={}, pose=am.Pose(x=x, y=y, heading=heading))
    sim = am.Simulation(building.scenario(rover, floor=floor))
    return sim.robot("rover").readings["eye"].true.tolist()


def test_a_row_of_elements_finds_the_line_below_it():
    bare, line = 0.9, 0.1
    # The line is 1 cm to either side of y = 1; of the elements at its edges half a spot, as 32 places go.
    found = reading(Line(elements=ROW, spot=0.004), 1.5, 1.0)
    assert found[:2] == found[5:] == pytest.approx([bare, bare])
    assert found[3] == pytest.approx(line)
    assert found[2] == pytest.approx((bare + line) / 2.0, abs=(bare - line) * 2.0 / 32.0)
    assert found[4] == pytest.approx((bare + line) / 2.0, abs=(bare - line) * 2.0 / 32.0)
    turned = reading(Line(elements=ROW, spot=0.0), 1.5, 1.005, math.pi)
    assert turned == pytest.approx([bare, bare, line, line, bare, bare, bare])


@pytest.mark.parametrize("beside", [0.0, 0.0012, -0.003, 0.0049, 0.006])
def test_a_spot_reads_the_share_of_it_that_is_marked(beside):
    radius = 0.005
    found = reading(Line(elements=(am.Mount(),), spot=2.0 * radius), 1.5, 1.01 + beside)
    # A circle's segment beyond a chord so far from its centre.
    off = min(max(beside / radius, -1.0), 1.0)
    share = (math.acos(off) - off * math.sqrt(1.0 - off * off)) / math.pi
    assert found == pytest.approx([0.9 - 0.8 * share], abs=0.8 * 2.0 / 32.0)


def test_what_was_marked_last_is_on_top_and_a_drop_before_all():
    point = Line(elements=(am.Mount(),), spot=0.0)
    assert reading(point, 1.9, 1.0) == pytest.approx([0.5])
    assert reading(point, 2.0, 1.0) == pytest.approx([0.2])
    assert reading(point, 3.0, 2.5) == pytest.approx([0.1])
    assert reading(point, 3.0, 2.99) == pytest.approx([0.0])  # there the line would be
    assert reading(point, 3.0, 1.0) == pytest.approx([0.1])  # its corner
    assert reading(point, 3.005, 0.9949) == pytest.approx([0.1])  # which is round
    assert reading(point, 3.0075, 0.9925) == pytest.approx([0.9])


def test_a_closed_line_goes_back_to_its_first_point():
    point = Line(elements=(am.Mount(),), spot=0.0)
    corners = ((1.0, 1.0), (3.0, 1.0), (3.0, 3.0))
    for closed, expected in ((True, 0.05), (False, 0.8)):
        floor = am.Floor(markings=[am.Marking(points=corners, closed=closed)])
        assert reading(point, 2.0, 2.0, floor=floor) == pytest.approx([expected])


def test_a_cliff_sensor_tells_drops_that_are_deep_enough():
    pair = (am.Mount(x=0.1, y=0.05), am.Mount(x=0.1, y=-0.3))
    assert reading(Cliff(elements=pair), 2.85, 3.1) == [1.0, 0.0]
    assert reading(Cliff(elements=pair, depth_min=0.11), 2.85, 3.1) == [0.0, 0.0]
    assert reading(Cliff(), 1.0, 3.0) == [0.0]
    assert reading(Cliff(depth_min=0.02), 1.0, 3.0) == [1.0]


def test_a_floor_that_nobody_marked_is_even():
    assert reading(Line(), 2.0, 2.0, floor=am.Floor()) == pytest.approx([0.8, 0.8])
    assert reading(Cliff(), 2.0, 2.0, floor=am.Floor()) == [0.0]


@pytest.mark.parametrize("kind", [Line, Cliff])
def test_they_keep_their_contract(kind):
    check_component(kind(elements=ROW))
    with pytest.raises(ParameterError, match="expected one element at least"):
        kind(elements=())


def test_rows_do_not_depend_on_each_other():
    rovers = [
        building.robot(
            name=f"r{i}",
            shape=am.Shape.circle(0.05),
            sensors={"line": am.MountedSensor(sensor=Line(elements=ROW, spot=0.003 + 0.001 * i))},
            estimators={},
            pose=am.Pose(x=1.2 + 0.3 * i, y=1.0, heading=0.3 * i),
        )
        for i in range(5)
    ]
    together = am.Simulation(building.scenario(*rovers, floor=FLOOR), replicas=3)
    for rover in rovers:
        alone = am.Simulation(building.scenario(rover, floor=FLOOR), replicas=[2])
        expected = alone.robot(rover.name, 2).readings["line"].true
        assert together.robot(rover.name, 2).readings["line"].true.tobytes() == expected.tobytes()


def test_a_view_tells_the_floor_at_places():
    @attrs.frozen(kw_only=True)
    class Asks(am.Sensor):
        unit = "m"

        def size(self, drive):
            return 4

        def sense(self, view, aim, state, draws):
            found = view.floor(np.array([[(1.5, 1.0), (3.0, 3.2)]]))
            return np.concatenate((found.reflectance, found.depth), axis=1), {}

    assert reading(Asks(), 1.0, 1.0) == pytest.approx([0.1, 0.0, 0.0, 0.1])
