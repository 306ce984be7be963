"""Maps of MobileSim and ARIA: walls, points, home, goals and areas; and rows that are broken."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import amorsim as am
from amorsim.core.errors import MapError, ScenarioError
from amorsim.foreign.mobilesim import MobileSim, MobileSimMap, read_robot_map
from amorsim.testing import check_component
from tests.examples import settings

MAPS = Path(__file__).resolve().parents[3] / "shared" / "maps" / "mobilesim"

ROOM = """\
2D-Map
MapInfo: Floor "one"
LineMinPos: 0 0
LineMaxPos: 4000 3000
NumLines: 5
Cairn: RobotHome 1000 1500 90 "" ICON "Home"
Cairn: GoalWithHeading 3000 2000 180 "by the door" ICON "lunch room"
Cairn: ForbiddenArea 0 0 0 "" ICON "pit" 2000 500 3000 1000
Cairn: ForbiddenArea 0 0 90 "" ICON "" 500 -1000 1500 -500
Cairn: ForbiddenLine 0 0 0 "" ICON "" 500 2500 1500 2500
Cairn: Sim.BoxObstacle 0 0 0 "" ICON "box" 3200 200 3600 500
Cairn: Sector 0 0 0 "" ICON ""
LINES
0 0 4000 0
4000 0 4000 3000
4000 3000 0 3000
0 3000 0 0
DATA
"""


@pytest.fixture
def write(tmp_path):
    def written(text: str, name: str = "lab.map") -> Path:
        (tmp_path / name).write_text(text)
        return tmp_path / name

    return written


@pytest.mark.parametrize(
    ("name", "size", "home"),
    [
        ("MapLab", (9.08, 7.8), (-1.522, -2.116, -38.2063)),
        ("office", (18.76, 14.0), (1.0, 1.498, 0.0)),
        ("triangle", (10.26, 10.08), (5.09, 3.58, 54.0)),
    ],
)
def test_real_maps_have_their_size_and_their_home(name: str, size, home) -> None:
    path = MAPS / f"{name}.map"
    if not path.is_file():
        pytest.skip(f"no {path}")
    scenario = am.load(path)
    assert scenario.map.size == pytest.approx(size, abs=1e-9)
    (robot,) = scenario.robots
    assert (robot.pose.x, robot.pose.y, math.degrees(robot.pose.heading)) == pytest.approx(home)
    lines = [line for line in path.read_text().splitlines() if len(line.split()) == 4 and ":" not in line]
    assert len(scenario.map.segments) == len(lines)
    check_component(MobileSim, path=path)


def test_a_map_becomes_a_scenario(write) -> None:
    scenario = am.load(write(ROOM))
    (robot,) = scenario.robots
    assert robot.model == "pioneer2dx"
    assert (robot.pose.x, robot.pose.y, robot.pose.heading) == pytest.approx((1.0, 1.5, math.pi / 2))
    goal, pit, turned, line = scenario.zones
    assert (goal.name, goal.pose.x, goal.pose.y) == ("lunch_room", 3.0, 2.0)
    assert goal.pose.heading == pytest.approx(math.pi)
    assert (pit.name, pit.pose.x, pit.pose.y, pit.shape.area) == ("pit", 2.5, 0.75, pytest.approx(0.5))
    # Its corners are turned by 90 degrees about the origin: (1, -0.75) comes to (0.75, 1).
    assert turned.outline.min(axis=0) == pytest.approx([0.5, 0.5])
    assert turned.outline.max(axis=0) == pytest.approx([1.0, 1.5])
    assert line.outline.max(axis=0) == pytest.approx([1.5, 2.525])
    (box,) = scenario.obstacles
    assert (box.name, box.pose.x, box.pose.y) == ("box", 3.4, 0.35)
    assert scenario.remarks == ("cairns that are left out: Sector",)
    assert scenario.map.warnings == ("NumLines says 5, and there are 4", "left out: MapInfo")


def test_a_home_without_room_is_left_for_a_place_where_the_robot_fits(write) -> None:
    scenario = am.load(write(ROOM.replace("1000 1500 90", "100 100 90")))
    assert scenario.robots[0].pose.x > 0.3


def test_points_are_cells(write) -> None:
    world = MobileSimMap(resolution=0.1).load(write("2D-Map\nNumPoints: 3\nDATA\n50 50\n950 50\n150 450\n"))
    cells = world.to_array()
    assert cells.sum() == 3
    assert world.occupied([[0.05, 0.05], [0.95, 0.05], [0.15, 0.45], [0.5, 0.25]]).tolist() == [True, True, True, False]


def test_points_say_how_fine_the_map_is(write) -> None:
    text = "2D-Map\nResolution: 50\nLINES\n0 0 1000 0\nDATA\n0 1000\n"
    assert MobileSimMap().load(write(text)).resolution == 0.05
    assert MobileSimMap().load(write(text.replace("0 1000\n", ""))).resolution == 0.01


def test_a_right_count_is_not_remarked_on(write) -> None:
    """1001 / 1000 * 1000 is not 1001."""
    points = "".join(f"{50 * number} 0\n" for number in range(1001))
    read = read_robot_map(write(f"2D-Map\nNumPoints: 1001\nLINES\nDATA\n{points}"))
    assert read.remarks == ()


def test_a_heading_is_the_files_number(write) -> None:
    text = '2D-Map\nCairn: Goal 0 0 63.7 "" ICON "g"\nLINES\n0 0 1000 0\nDATA\n'
    assert read_robot_map(write(text)).things[0].degrees == 63.7


def test_a_map_too_far_away_is_not_written(tmp_path) -> None:
    world = am.Map.from_segments([(1e6, 0.0, 1e6 + 2.0, 1.0)], resolution=0.5)
    with pytest.raises(MapError, match=r"it reaches to 1000002 m from the origin; expected 1e\+06 m at most"):
        am.save_map(world, tmp_path / "far.map", use="mobilesim")
    assert not list(tmp_path.iterdir())


def test_every_broken_row_is_reported_with_its_line(write) -> None:
    text = ROOM.replace("4000 0 4000 3000", "4000 0 4000").replace("0 3000 0 0", "0 3000 0 x")
    text = text.replace("180 ", "").replace("200 3600 500", "200 3600")
    with pytest.raises(ScenarioError) as caught:
        read_robot_map(write(text + "1 2 3\n1 1e12\n"))
    found = [f"{fault.line}: {fault.message}" for fault in caught.value.faults]
    assert [message.partition(":")[0] for message in found] == ["7", "11", "15", "17", "19", "20"]
    assert found[2] == "15: expected 4 numbers, got 3: '4000 0 4000'"
    assert found[5] == "20: expected a number of at most 1e+09 mm, got '1e12'"


def test_other_files_are_refused(write) -> None:
    with pytest.raises(ScenarioError, match="1: expected 2D-Map in the first line, got 'type octile'"):
        read_robot_map(write("type octile\nheight 1\n"))
    assert not MobileSim.sniff(b"type octile\n")
    with pytest.raises(MapError, match="neither a line nor a point"):
        MobileSimMap().load(write("2D-Map\nLINES\nDATA\n"))


def test_a_map_of_other_programs_is_still_a_map_alone(write) -> None:
    # `.map` is also MovingAI's: its first line decides.
    assert am.open_document(write(ROOM)).get("world.use") == "mobilesim"


@given(
    st.lists(st.tuples(*[st.integers(-5000, 5000)] * 4), min_size=1, max_size=20),
    st.lists(st.tuples(*[st.integers(-5000, 5000)] * 2), max_size=20),
)
@settings(max_examples=40)
def test_what_is_written_is_read(tmp_path_factory, lines, points) -> None:
    path = tmp_path_factory.mktemp("maps") / "any.map"
    rows = "".join(f"{' '.join(map(str, line))}\n" for line in lines)
    path.write_text(f"2D-Map\r\nLINES\n{rows}DATA\n" + "".join(f"{x} {y}\n" for x, y in points))
    read = read_robot_map(path)
    assert np.array_equal(read.segments, np.array(lines) / 1000)
    assert np.array_equal(read.points, np.array(points).reshape(-1, 2) / 1000)
    world = MobileSimMap(resolution=0.05).load(path)
    ends = np.array(lines).reshape(-1, 2) / 1000
    inside = np.clip(ends, np.array(world.origin[:2]) + 1e-6, np.array(world.origin[:2]) + np.array(world.size) - 1e-6)
    assert world.occupied(inside).all()
