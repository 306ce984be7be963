"""What a document says of its faults, and what of it can be shown in spite of them."""

from __future__ import annotations

import contextlib

import pytest
from hypothesis import HealthCheck, given
from hypothesis import strategies as st

import amorsim as am
from amorsim.scenario.documents.document import Document, open_document
from tests.examples import settings

SOUND = """\
format = 1

[world]
map = "room.wld"

[[robots]]
name = "rover"
model = "pioneer2dx"
pose = { x = 1.0, y = 1.0 }
controller = { use = "wander" }

[robots.sensors.laser]
beams = 31

[[robots]]
name = "scout"
model = "pioneer2dx"
pose = { x = 3.0, y = 1.0 }

[[obstacles]]
name = "box"
shape = { circle = 0.2 }
pose = { x = 2.0, y = 2.0 }
"""


@pytest.fixture
def document_of(folder):
    """A document of the sound text with parts of it replaced, in the folder of the map."""

    def make(*changes):
        text = SOUND
        for old, new in changes:
            assert old in text
            text = text.replace(old, new, 1)
        return Document(text, folder / "some.toml")

    return make


def found(document):
    return {fault.named or fault.path: fault.line for fault in document.faults()}


def test_a_sound_document_has_no_faults_and_is_a_scenario(document_of, folder):
    document = document_of()
    assert document.faults() == ()
    scenario = document.scenario()
    assert [robot.name for robot in scenario.robots] == ["rover", "scout"]
    assert scenario.robots[0].sensors["laser"].sensor.beams == 31
    assert scenario.source == folder / "some.toml"
    assert scenario.resolved["robots"][0]["resolved_from"] == "pioneer2dx"


def test_a_change_counts_before_it_is_saved(document_of):
    document = document_of()
    document.set("robots.scout.pose.x", 1.0)
    document.set("simulation.dt", -1)
    assert found(document) == {"simulation.dt": 7, "robots.scout.pose": 21}
    with pytest.raises(am.ScenarioError, match=r"some\.toml:7: simulation\.dt: expected"):
        document.scenario()
    document.undo()
    document.undo()
    assert document.faults() == ()


def test_all_faults_come_at_once_with_those_of_toml(document_of):
    document = document_of(
        ("beams = 31", "beams = 31 of them\nbeems = 3"),
        ('use = "wander"', 'use = "wonder"'),
        ('name = "box"\n', 'name = "box"\nweight = 3\n'),
        ("circle = 0.2", "circle = -0.2"),
    )
    assert found(document) == {
        "": 13,
        "robots.rover.controller.use": 10,
        "robots.rover.sensors.laser.beems": 14,
        "obstacles.box.weight": 23,
        "obstacles.box.shape.circle": 24,
    }
    text = document.text
    document.set("robots.scout.pose.x", 3.5)
    assert document.text == text.replace("x = 3.0", "x = 3.5")
    assert 13 in found(document).values()


def test_unknown_keys_and_components_are_faults_and_stay(document_of, folder):
    document = document_of(
        ("beams = 31", 'use = "lidar3000"  # of a plugin\nspin = [1, 2]'), ("format = 1", "format = 1\nauthor = 'me'")
    )
    assert set(found(document)) == {"author", "robots.rover.sensors.laser.use"}
    document.set("robots.rover.sensors.laser.spin.1", 3)
    saved = document.save(folder / "saved.toml").read_text()
    assert saved == document.text
    assert 'use = "lidar3000"  # of a plugin\nspin = [1, 3]' in saved
    assert "author = 'me'" in saved


def test_what_is_at_fault_is_left_out_and_the_rest_can_be_shown(document_of):
    partial = document_of(
        ("beams = 31", "beams = 0"),
        ('use = "wander"', 'use = "wonder"'),
        ("x = 2.0, y = 2.0", "x = 2.0, y = 'up'"),
        ("format = 1", "format = 1\n[simulation]\ndt = 0.05\nseed = -1\n"),
    ).partial()
    assert len(partial.faults) == 4
    assert partial.map.name == "room"
    rover, scout = partial.robots
    assert rover.controller is None
    assert "laser" not in rover.sensors
    assert "sonar" in rover.sensors
    assert rover.pose == am.Pose(x=1.0, y=1.0)
    assert "laser" in scout.sensors
    assert partial.obstacles == ()
    assert (partial.dt, partial.seed) == (0.05, 0)


def test_of_a_body_of_which_no_more_can_be_read_there_is_an_outline(document_of):
    partial = document_of(
        ('name = "scout"\nmodel = "pioneer2dx"', 'name = "scout"\nshape = { circle = 0.3 }\ndrive = { use = "wings" }')
    ).partial()
    assert [robot.name for robot in partial.robots] == ["rover"]
    (outline,) = partial.outlines
    assert (outline.name, outline.pose.x, outline.shape.radius) == ("scout", 3.0, 0.3)


def test_without_a_map_the_bodies_are_there(document_of):
    partial = document_of(("room.wld", "hall.wld")).partial()
    assert partial.map is None
    assert [robot.name for robot in partial.robots] == ["rover", "scout"]
    assert len(partial.faults) == 1


def test_robots_of_one_name_are_both_there(document_of):
    partial = document_of(('name = "scout"', 'name = "rover"')).partial()
    assert [robot.name for robot in partial.robots] == ["rover", "robots-1"]


@settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.data())
def test_a_document_with_holes_has_its_faults_and_can_be_shown(folder, data):
    lines = SOUND.splitlines(keepends=True)
    for _ in range(data.draw(st.integers(1, 3))):
        at = data.draw(st.integers(0, len(lines) - 1))
        lines[at] = data.draw(
            st.sampled_from(
                ["", "= 3\n", "[\n", "x = [\n", "]\n", 'name = """\n', "[[robots]]\n", lines[at] * 2, "\x00"]
            )
        )
    text = "".join(lines)
    document = Document(text, folder / "holes.toml")
    assert document.text == text
    faults, partial = document.faults(), document.partial()
    assert partial.faults == faults
    assert all(fault.message and (fault.line or fault.path) for fault in faults)
    with pytest.raises(am.ScenarioError) if faults else contextlib.nullcontext() as caught:
        document.scenario()
    assert not faults or caught.value.faults == faults


def test_a_bundled_scenario_is_opened_by_its_name():
    assert open_document("demo").faults() == ()


def test_a_lone_carriage_return_is_the_same_fault_wherever_a_file_is_read(folder):
    """TOML's line ends are LF and CRLF, so what is shown as wrong may not run all the same."""
    file = folder / "some.toml"
    file.write_bytes(SOUND.replace("format = 1\n", "format = 1\r\n# one\rtwo = 2\n", 1).encode())
    document = am.open_document(file)
    assert [(fault.line, fault.value) for fault in document.faults()] == [(2, "# one\rtwo = 2")]
    with pytest.raises(am.ScenarioError) as caught:
        am.load(file)
    assert caught.value.faults == document.faults()


@pytest.mark.parametrize(
    "line",
    [
        "a = = 1", "a 1", "a : 1", "a", "[x", "[x]]", "[]", "a = [1,", "a = [1 2]", "a = {b=1", "a = {b=1 c=2}",
        "a = 'x", 'a = "x', "a = 1 2", "a = 1,5", "a = .5", "a = True", 'a = "C:\\q"', "= 1", "a = ", "a..b = 1",
        "a = 1\na = 2", "a = {b = 1, b = 2}", "a = {b = 1}\na.c = 2", "[a]\n[a]", "a = 01", "a = \"x\ny\"",
    ],
)  # fmt: skip
def test_each_error_of_toml_has_its_line_its_text_and_a_remedy(tmp_path, line):
    (tmp_path / "one.toml").write_text(f"# first\n{line}\n")
    document = am.open_document(tmp_path / "one.toml")
    faults = [fault for fault in document.faults() if not fault.path]
    assert faults
    assert faults[0].line in (2, 3)
    assert all(fault.remedy and fault.value and fault.file for fault in faults), faults


ROBOT = "[[robots]]\nname = 'a'\nmodel = 'pioneer2dx'\n"


@pytest.mark.parametrize(
    ("line", "remedy"),
    [
        ("shape.circle = -1", "expected a circle with a radius above 0 m"),
        ("shape.rectangle = [0, 1]", "expected a rectangle with a length above 0 m"),
        ("shape.polygon = [[0, 0], [1, 1]]", "expected a polygon of three vertices at least"),
        ("shape.polygon = [[0, 0], [1, 1], [1, 0], [0, 1]]", "expected a polygon whose border does not meet itself"),
        ("shape.circle = 1e20", "expected a shape that reaches 1e-06 m to 1e+06 m from its body's origin"),
        ("knowledge.map = 'rom.wld'", "Did you mean 'room.wld'?"),
        ("knowledge.map = 'x.png'", "check its name and its folder"),
        ("controller.use = 'nothing.py:go'", "check its name and its folder"),
        ("sensors.laser.model = 'nothing.toml'", "check its name and its folder"),
        ("errors.sensors.laser.rate = 1", "change the noise chain of the sensor itself"),
        ("resolved_from = 'x'", "leave one of the two out"),
    ],
)
def test_a_fault_says_what_to_do(tmp_path, line, remedy):
    (tmp_path / "room.wld").write_text("width 4000\nheight 3000\n")
    (tmp_path / "one.toml").write_text(f"format = 1\nworld = {{ map = 'room.wld' }}\n{ROBOT}{line}\n")
    (fault,) = am.open_document(tmp_path / "one.toml").faults()
    assert (fault.line, fault.remedy) == (6, remedy)
