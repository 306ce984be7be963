"""A document: values by their paths, and what a change makes of the author's lines."""

from __future__ import annotations

import copy
import pickle
import time

import pytest

import amorsim as am
from amorsim.scenario.documents.document import open_document

TEXT = """\
# Two robots in a room.

format = 1

[world]
map = "room.wld"        # four metres by three

[simulation]
dt = 0.10               # s

[[robots]]
name = "rover"
model = "pioneer2dx"
pose = { x = 1.0, y = 1_0e-1 }   # near the door
controller = { use = "wander", speed = 0.4 }

[robots.errors.drive]
# Measured on a Tuesday.
track = { scale = 1.02 }

# The second one looks on.
[[robots]]
name = "scout"
model = "pioneer2dx"
drive.track = 0.34
ground = [
    { use = "diffusion", variance_per_length = 1e-6 },  # carpet
]

[[obstacles]]
name = "box"
shape = { circle = 0.2 }
"""


@pytest.fixture
def document(tmp_path):
    path = tmp_path / "two.toml"
    path.write_text(TEXT)
    return open_document(path)


def changed(document):
    """The lines that went, and those that came."""
    before, after = TEXT.splitlines(), document.text.splitlines()
    return [line for line in before if line not in after], [line for line in after if line not in before]


def test_a_document_is_copied_and_pickled_as_its_text(document):
    document.set("simulation.dt", 0.05)
    for again in (copy.copy(document), copy.deepcopy(document), pickle.loads(pickle.dumps(document))):
        assert (again.text, again.path) == (document.text, document.path)
        again.set("simulation.dt", 0.2)
    assert document.get("simulation.dt") == 0.05


def test_values_have_the_paths_of_settings(document):
    assert document.get("simulation.dt") == 0.1
    assert document.get("robots.rover.controller.speed") == document.get("robots.0.controller.speed") == 0.4
    assert document.get("robots.scout.ground.diffusion.variance_per_length") == 1e-6
    assert document.get("robots.1.drive.track") == 0.34


def test_a_value_is_changed_in_its_line_and_nothing_else_is(document):
    document.set("robots.rover.pose.x", 2.5)
    assert changed(document) == (
        ["pose = { x = 1.0, y = 1_0e-1 }   # near the door"],
        ["pose = { x = 2.5, y = 1_0e-1 }   # near the door"],
    )


def test_the_value_that_is_there_changes_nothing(document):
    document.set("simulation.dt", 0.1)
    document.set("robots.rover.pose", {"x": 1.0, "y": 1.0})
    assert document.text == TEXT
    assert not document.undo()


def test_of_a_table_only_what_differs_is_written(document):
    document.set("robots.rover.pose", {"x": 1.0, "y": 2.0, "heading_deg": 90.0})
    assert changed(document)[1] == ["pose = { x = 1.0, y = 2.0, heading_deg = 90.0 }   # near the door"]


def test_another_use_forgets_the_keys_of_the_one_before(document):
    document.set("robots.rover.controller.use", "manual")
    assert changed(document)[1] == ['controller = { use = "manual" }']


@pytest.mark.parametrize(
    ("path", "value", "lines"),
    [
        ("simulation.seed", 7, ["seed = 7"]),
        ("robots.scout.drive.wheel_radius_left", 0.08, ["drive.wheel_radius_left = 0.08"]),
        ("robots.rover.errors.drive.wheel_radius_left.scale", 1.01, ["wheel_radius_left.scale = 1.01"]),
        ("robots.rover.errors.pose.x.add", 0.1, ["[robots.errors.pose]", "x.add = 0.1"]),
        ("robots.rover.fiducial", 3, ["fiducial = 3"]),
        ("robots.scout.sensors.sonar", False, ["sensors.sonar = false"]),
        ("recording.sensors", "all", ["[recording]", 'sensors = "all"']),
        ("description", "Two.", ['description = "Two."']),
        ("obstacles.box.pose.x", 1.0, ["pose.x = 1.0"]),
    ],
)
def test_a_new_value_has_a_line_where_its_table_is(document, path, value, lines):
    document.set(path, value)
    gone, come = changed(document)
    assert gone == []
    assert [line.partition("  #")[0] for line in come] == lines
    assert document.get(path) == value
    document.undo()
    assert document.text == TEXT


def test_items_are_added_moved_and_removed_with_their_comments(document):
    assert document.add("obstacles", {"name": "post", "shape": {"circle": 0.1}}) == "obstacles.1"
    assert document.text == TEXT + '\n[[obstacles]]\nname = "post"\nshape = { circle = 0.1 }\n'
    assert document.move("robots.scout", 0) == "robots.0"
    assert [robot["name"] for robot in document.get("robots")] == ["scout", "rover"]
    assert '# The second one looks on.\n[[robots]]\nname = "scout"' in document.text
    document.remove("robots.scout")
    assert "The second one" not in document.text
    assert document.text.count("[[robots]]") == 1
    assert document.add("robots.rover.ground", {"use": "diffusion", "variance_per_length": 1e-5}) == "robots.0.ground.0"
    assert 'ground = [{ use = "diffusion", variance_per_length = 1e-05 }]' in document.text
    assert document.add("lights", {"x": 1.0}) == "lights.0"
    for _ in range(5):
        assert document.undo()
    assert document.text == TEXT


def test_an_item_is_added_to_a_list_of_lines_on_a_line_of_its_own(document):
    document.add("robots.scout.ground", {"use": "bump", "size": 0.01}, index=0)
    document.add("robots.scout.ground", {"use": "slip"})
    text = document.text
    assert text[text.index("ground") : text.index("[[obstacles]]")] == (
        "ground = [\n"
        '    { use = "bump", size = 0.01 },\n'
        '    { use = "diffusion", variance_per_length = 1e-6 },  # carpet\n'
        '    { use = "slip" },\n'
        "]\n\n"
    )


def test_undo_and_redo_go_through_all_changes(document):
    texts = [document.text]
    for path, value in (("simulation.dt", 0.05), ("robots.rover.pose.y", 2.0), ("simulation.seed", 3)):
        document.set(path, value)
        texts.append(document.text)
    for text in reversed(texts[:-1]):
        assert document.undo()
        assert document.text == text
    for text in texts[1:]:
        assert document.redo()
        assert document.text == text
    document.undo()
    document.set("simulation.duration", 5.0)
    assert not document.redo(), "what was taken back is gone once something else has changed"


def test_what_leaves_the_text_as_it_was_is_no_step(tmp_path):
    document = am.Document("a = [0, 0]\n", tmp_path / "one.toml")
    document.move("a.0", 1)
    assert not document.undo()
    document.set("a", [0, 1])
    document.undo()
    document.move("a.0", 1)
    assert document.redo()
    assert document.text == "a = [0, 1]\n"


@pytest.mark.parametrize(
    ("do", "words"),
    [
        (lambda document: document.get("robots.rovr.pose"), "Did you mean 'rover'?"),
        (lambda document: document.get("robots.2"), "no robot '2'; known robots: rover, scout"),
        (
            lambda document: document.set("robots.rover.name.first", 1),
            "there is nothing under robots.0.name: it is 'rover'",
        ),
        (lambda document: document.set("", 1), "expected a path"),
        (lambda document: document.set("simulation..dt", 1), "expected a path"),
        (lambda document: document.set("simulation.dt", object()), "expected a number, a text"),
        (lambda document: document.remove("simulation.seed"), "the file says nothing of it"),
        (lambda document: document.add("simulation", 1), "expected a list"),
        (lambda document: document.add("obstacles", {}, index=2), "expected a whole number from 0 to 1, got 2"),
        (lambda document: document.move("recording", 0), "expected what the file says"),
        (lambda document: document.move("robots.rover", 2), "expected a whole number from 0 to 1, got 2"),
    ],
)
def test_what_cannot_be_done_is_said_and_changes_nothing(document, do, words):
    with pytest.raises(am.DocumentError) as caught:
        do(document)
    assert words in str(caught.value)
    assert document.text == TEXT
    assert not document.undo()


def test_a_change_that_fails_half_way_leaves_nothing(document, monkeypatch):
    monkeypatch.setattr(document._editor, "remove", lambda _: pytest.fail("in the middle"))
    with pytest.raises(pytest.fail.Exception):
        document.set("simulation", {"seed": 3})
    assert document.text == TEXT


@pytest.mark.parametrize("value", ["\ud800", ["a", {"b": "\udfff"}], {"\udc80": 1}])
def test_what_no_file_can_hold_is_refused(document, value):
    before = document.text
    with pytest.raises(am.DocumentError, match="a text that UTF-8 can hold"):
        document.set("robots.rover.colour", value)
    with pytest.raises(am.DocumentError, match="a text that UTF-8 can hold"):
        document.set("robots.rover.\ud800", 1)
    assert document.text == before


@pytest.mark.parametrize("value", [None, {1, 2}, [1, {"a": 1j}], {2: "b"}, ["\ud800"]])
def test_a_value_that_toml_has_not_is_refused_by_its_path(document, value):
    for path, does in (("robots.rover.colour", document.set), ("obstacles", document.add)):
        with pytest.raises(am.DocumentError, match="expected") as caught:
            does(path, value)
        assert caught.value.path == path
        assert str(caught.value).startswith(f"{path}: expected")
    assert document.text == TEXT


def test_what_is_no_toml_stays_and_the_rest_can_be_changed(tmp_path):
    text = TEXT.replace("dt = 0.10 ", "dt = 0.1.0 ").replace('name = "box"', 'name = "box\nname = 3\nname = 4')
    path = tmp_path / "bad.toml"
    path.write_text(text)
    document = open_document(path)
    assert [fault.line for fault in document.faults()][:3] == [9, 31, 33]
    document.set("robots.rover.pose.x", 2.0)
    document.save()
    assert path.read_text() == text.replace("x = 1.0", "x = 2.0")


def test_a_file_that_is_not_there_or_no_text_is_reported(tmp_path):
    (tmp_path / "picture.toml").write_bytes(b"\xff\xd8")
    for path, words in ((tmp_path / "none.toml", "no such file"), (tmp_path / "picture.toml", "0xff")):
        with pytest.raises(am.DocumentError, match=words):
            open_document(path)
    with pytest.raises(am.DocumentError, match="Did you mean 'demo'"):
        open_document("dmo")
    (tmp_path / "scenario.toml").touch()
    with pytest.raises(am.DocumentError, match=r"it is a folder; expected a scenario, such as .*scenario\.toml$"):
        open_document(tmp_path)


def test_reading_and_changing_a_thousand_robots_takes_less_than_a_third_of_a_second(tmp_path):
    robot = TEXT[TEXT.index("[[robots]]") : TEXT.index("# The second")]
    path = tmp_path / "many.toml"
    path.write_text(
        'format = 1\n[world]\nmap = "room.wld"\n' + "".join(robot.replace("rover", f"r{i}") for i in range(1000))
    )
    seconds = []
    for _ in range(3):
        start = time.process_time()
        document = open_document(path)
        document.set("robots.r500.pose.x", 3.0)
        seconds.append(time.process_time() - start)
    assert min(seconds) < 0.3


@pytest.mark.parametrize(
    ("before", "after"),
    [
        (
            'a = [\n    "x", # the first\n    # about y\n    "y",\n    "z" # the last\n]\n',
            'a = [\n    "z", # the last\n    "x", # the first\n    # about y\n    "y",\n]\n',
        ),
        ('a = ["x", "y", "z"]\n', 'a = ["z", "x", "y"]\n'),
        ('a = [\n    "x", "y",\n    "z"\n]\n', None),
        ('a = [\n    "x",\n    "y",\n    "z"\n    ,\n]\n', None),
    ],
)
def test_an_item_of_a_list_within_a_value_moves_with_its_comments(tmp_path, before, after):
    document = am.Document(before, tmp_path / "x.toml")
    document.move("a.2", 0)
    assert document.values == {"a": ["z", "x", "y"]}
    if after is not None:
        assert document.text == after
    document.undo()
    assert document.text == before


TABLES = """\
format = 1
a = 1
# about b
b = 2
c = { x = 1, y = 2, z = 3 }  # inline

[first]
x = 1

# about second
[second]
y = 2
[second.inner]
z = 3

[third.u]
w = 1
[third.v]
w = 2
"""


@pytest.mark.parametrize(
    ("path", "index", "before", "after"),
    [
        ("b", 1, "a = 1\n# about b\nb = 2\n", "# about b\nb = 2\na = 1\n"),
        ("a", 2, "a = 1\n# about b\nb = 2\n", "# about b\nb = 2\na = 1\n"),
        ("c.z", 0, "{ x = 1, y = 2, z = 3 }", "{ z = 3, x = 1, y = 2 }"),
        ("c.x", 1, "{ x = 1, y = 2, z = 3 }", "{ y = 2, x = 1, z = 3 }"),
        ("third.v", 0, "[third.u]\nw = 1\n[third.v]\nw = 2\n", "[third.v]\nw = 2\n\n[third.u]\nw = 1\n"),
        (
            "second",
            4,
            "[first]\nx = 1\n\n# about second\n[second]\ny = 2\n[second.inner]\nz = 3\n",
            "# about second\n[second]\ny = 2\n[second.inner]\nz = 3\n\n[first]\nx = 1\n",
        ),
    ],
)
def test_what_is_in_a_table_moves_with_its_comments(tmp_path, path, index, before, after):
    (tmp_path / "t.toml").write_text(TABLES)
    document = am.open_document(tmp_path / "t.toml")
    assert document.move(path, index) == path
    assert document.text == TABLES.replace(before, after)
    assert document.undo()
    assert document.text == TABLES


@pytest.mark.parametrize(("path", "index"), [("first", 0), ("a", 5), ("second.inner", 0)])
def test_what_toml_cannot_order_so_stays(tmp_path, path, index):
    (tmp_path / "t.toml").write_text(TABLES)
    document = am.open_document(tmp_path / "t.toml")
    with pytest.raises(am.DocumentError):
        document.move(path, index)
    assert document.text == TABLES
    assert not document.undo()


def test_the_first_estimator_is_the_one_that_the_controller_gets(tmp_path):
    (tmp_path / "room.wld").write_text("width 4000\nheight 3000\n")
    (tmp_path / "e.toml").write_text(
        "format = 1\nworld.map = 'room.wld'\n[[robots]]\nname = 'a'\nmodel = 'pioneer2dx'\n"
        "[robots.estimators.dead_reckoning]\nuse = 'dead_reckoning'\n"
        "[robots.estimators.other]\nuse = 'dead_reckoning'\n"
    )
    document = am.open_document(tmp_path / "e.toml")
    document.move("robots.a.estimators.other", 0)
    assert list(document.values["robots"][0]["estimators"]) == ["other", "dead_reckoning"]
