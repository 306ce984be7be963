"""Values that are set back: what equals the inherited value, or no error at all, is not written any more."""

from __future__ import annotations

import pytest

import amorsim as am

HEAD = """\
format = 1
[world]
map = "room.wld"

[simulation]
dt = 0.2  # coarse
duration = 60.0

"""
ROBOT = """\
[[robots]]
name = "rover"
model = "{model}"
pose = {{ x = 1.0, y = 1.5 }}
"""
MINE = """\
format = 1
model = "pioneer2dx"
errors.drive.track = { scale = 1.02, add = 0.01 }
"""
TRACK = "robots.rover.errors.drive.track"


def document_of(folder, errors, model="pioneer2dx"):
    (folder / "room.wld").write_text("width 4000\nheight 3000\n")
    (folder / "mine.toml").write_text(MINE)
    (folder / "one.toml").write_text(HEAD + ROBOT.format(model=model) + errors)
    return am.open_document(folder / "one.toml")


def test_a_value_set_back_to_a_default_that_the_author_did_not_write_is_removed(tmp_path):
    document = document_of(tmp_path, "")
    text = document.text
    document.set("simulation.dt", 0.1)
    assert document.text == text.replace("dt = 0.2  # coarse\n", "")
    document.undo()
    # What the author wrote out, though it is the default, stays.
    document.set("simulation.duration", 30.0)
    document.set("simulation.duration", 60.0)
    assert document.text == text


@pytest.mark.parametrize(
    "errors",
    [
        "errors.drive.track = { scale = 1.02 }\n",
        "errors.drive = { track = { scale = 1.02 } }\n",
        "errors = { drive = { track = { scale = 1.02, per = 'study' } } }\n",
        "errors.drive.track.scale = 1.02\n",
        "[robots.errors.drive.track]\nscale = 1.02\n",
        "[robots.errors.drive]\ntrack.scale = { normal = [1.0, 0.1] }\n",
    ],
)
def test_an_error_that_is_set_back_goes_with_the_tables_that_held_it(tmp_path, errors):
    document = document_of(tmp_path, errors)
    before = document.text
    for value in ({"scale": 1.0}, {}):
        document.set(TRACK, value)
        assert document.text.rstrip("\n") == (HEAD + ROBOT.format(model="pioneer2dx")).rstrip("\n")
        document.undo()
    document.set(f"{TRACK}.scale", 1.0)
    assert document.text.rstrip("\n") == (HEAD + ROBOT.format(model="pioneer2dx")).rstrip("\n")
    assert document.undo()
    assert document.text == before


def test_other_errors_stay_where_they_are(tmp_path):
    document = document_of(tmp_path, "errors.drive = { track = { scale = 1.02, add = 0.1 }, lag = 0.1 }\n")
    document.set(f"{TRACK}.scale", 1.0)
    assert "errors.drive = { track = { add = 0.1 }, lag = 0.1 }\n" in document.text
    document.set(f"{TRACK}.add", 0.0)
    assert "errors.drive = { lag = 0.1 }\n" in document.text
    assert document.faults() == ()


def test_the_error_of_a_model_is_overridden_and_inherited_again(tmp_path):
    document = document_of(tmp_path, "", "mine.toml")
    text = document.text
    assert document.scenario().robots[0].errors["drive.track"].scale == 1.02
    document.set(TRACK, {"scale": 1.0})
    assert document.scenario().robots[0].errors["drive.track"] == am.Deviation()
    document.set(TRACK, {"scale": 1.02, "add": 0.01})
    assert document.text == text
    # A part of an error says all of it: the model's parts do not hold beside it.
    document.set(TRACK, {"scale": 1.03, "add": 0.01})
    document.set(f"{TRACK}.scale", 1.02)
    assert document.text == text


def test_an_error_may_be_begun_with_what_changes_nothing(tmp_path):
    document = document_of(tmp_path, "")
    document.set(TRACK, {"scale": 1.0})
    assert document.get(TRACK) == {"scale": 1.0}


def test_a_sensor_may_be_called_errors(tmp_path):
    document = document_of(tmp_path, "sensors.errors = { use = 'gyro' }\n")
    text = document.text
    document.set("robots.rover.sensors.errors.mount.x", 0.1)
    document.set("robots.rover.sensors.errors.mount.x", 0.0)
    assert document.text == text
    assert document.faults() == ()


def test_the_errors_of_a_model_are_set_back_too(tmp_path):
    (tmp_path / "mine.toml").write_text(MINE)
    model = am.open_document(tmp_path / "mine.toml")
    model.set("errors.drive.track.scale", 1.0)
    assert "errors.drive.track = { add = 0.01 }\n" in model.text
    model.set("errors.drive.track.add", 0.0)
    assert model.text == 'format = 1\nmodel = "pioneer2dx"\n'


def test_a_place_keeps_all_of_its_coordinates(tmp_path):
    document = document_of(tmp_path, "sensors.laser.mount = { x = 0.1, y = 0.2 }\n")
    document.set("robots.rover.pose.x", 0.0)
    assert "pose = { x = 0.0, y = 1.5 }\n" in document.text
    document.set("robots.rover.sensors.laser.mount.y", 0.0)
    assert "sensors.laser.mount = { x = 0.1, y = 0.0 }\n" in document.text


def test_a_place_at_the_origin_is_said_where_there_was_none(tmp_path):
    document = document_of(tmp_path, '[[obstacles]]\nname = "door"\nshape = { circle = 0.1 }\n')
    document.set("obstacles.door.pose.x", 0.0)
    assert "pose.x = 0.0\n" in document.text
    document.undo()
    document.set("obstacles.door.pose", {"x": 0.0, "y": 0.0})
    assert document.get("obstacles.door.pose") == {"x": 0.0, "y": 0.0}
