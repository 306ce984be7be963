"""The floor of a scenario, from files and in Python."""

import re
import tomllib

import pytest

import amorsim as am
from amorsim.core.errors import ScenarioError
from amorsim.core.parameters import ParameterError
from amorsim.scenario.files.resolved import resolved_table
from amorsim.scenario.files.write import table_text
from amorsim.scenario.reading.read import loads
from tests import building

TEXT = """
[floor]
reflectance = 0.7
[[floor.markings]]
points = [[0, 0], [1, 0], [1, 2]]
closed = true
width = 0.015
reflectance = 0.1
colour = "navy"
[[floor.markings]]
shape = { rectangle = [0.2, 0.1] }
pose = { x = 1.0, y = 2.0, heading_deg = 30.0 }
[[floor.drops]]
shape = { circle = 0.3 }
depth = 0.25
"""


def read(text, folder):
    (folder / "room.wld").write_text("width 6000\nheight 5000\n")
    document = {"format": 1, "world": {"map": "room.wld"}, "robots": [{"name": "rover", "model": "pioneer2dx"}]}
    document["robots"][0]["pose"] = {"x": 3.0, "y": 3.0}
    return loads(document | tomllib.loads(text), folder)


def test_a_file_says_what_is_on_the_floor(tmp_path):
    floor = read(TEXT, tmp_path).floor
    line = am.Marking(points=((0.0, 0.0), (1.0, 0.0), (1.0, 2.0)), closed=True, width=0.015, reflectance=0.1)
    assert floor.reflectance == 0.7
    assert floor.markings[0].points == line.points
    assert (floor.markings[0].closed, floor.markings[0].colour) == (True, "navy")
    assert floor.markings[1].shape == am.Shape.rectangle(0.2, 0.1)
    assert floor.markings[1].pose.heading == pytest.approx(0.5235987755982988)
    assert floor.markings[1].reflectance == 0.05
    assert floor.drops == (am.Drop(shape=am.Shape.circle(0.3), depth=0.25),)
    assert read("", tmp_path).floor == am.Floor()


def test_what_is_written_reads_the_same(tmp_path):
    scenario = read(TEXT, tmp_path)
    text = table_text(resolved_table(scenario))
    assert loads(tomllib.loads(text), tmp_path).floor == scenario.floor
    assert "floor" not in resolved_table(read("", tmp_path))


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("[floor]\nreflectance = 2", r"floor\.reflectance: .*<= 1"),
        ("[floor]\ncolour = 'red'", r"floor\.colour: unknown key"),
        ("[[floor.markings]]\nwidth = 0.1", "the points of a line or the shape of an area"),
        ("[[floor.markings]]\npoints = [[0, 0]]", r"floor\.markings\.0\.points: expected two points at least, got 1"),
        (
            "[[floor.markings]]\npoints = [[0, 0], [1, 0]]\nclosed = true",
            "expected three points of a closed line at least, got 2",
        ),
        ("[[floor.markings]]\npoints = [[0, 0], [0, 0]]", "each point to differ from the one before"),
        (
            "[[floor.markings]]\npoints = [[0, 0], [1, 0]]\nshape = { circle = 1 }",
            "the points of a line or the shape of an area, one of the two",
        ),
        ("[[floor.markings]]\npoints = [[0, 0], [1, 0]]\ncolour = 'blak'", r"colour: expected a colour's name"),
        ("[[floor.drops]]\ndepth = 1.0", r"floor\.drops\.0\.shape: missing"),
        ("[[floor.drops]]\nshape = { circle = 1 }\ndepth = 0", r"floor\.drops\.0\.depth: "),
        ("[[floor.marking]]\nwidth = 1", r"floor\.marking: unknown key.*'markings'"),
        ("floor = 3", "floor: expected a table"),
    ],
)
def test_faults_are_reported_where_they_are(text, message, tmp_path):
    with pytest.raises(ScenarioError) as caught:
        read(text, tmp_path)
    assert re.search(message, str(caught.value)), str(caught.value)


def test_a_floor_is_a_floor():
    with pytest.raises(ParameterError, match="markings"):
        am.Floor(markings=[am.Shape.circle(1.0)])
    with pytest.raises(ParameterError, match="floor"):
        building.scenario(floor=[am.Marking(points=((0, 0), (1, 0)))])
