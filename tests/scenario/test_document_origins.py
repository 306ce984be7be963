"""Where the values of a document come from, and how one goes back to what it inherits."""

from __future__ import annotations

from pathlib import Path

import pytest

import amorsim as am
from amorsim.plugins.manager import default_registry

TEXT = """\
format = 1
[world]
map = "room.wld"

[simulation]
dt = 0.2

[[robots]]
name = "rover"
model = "mine.toml"
pose = { x = 1.0, y = 1.5 }
controller = { use = "wander", speed = 0.4 }
drive.track = 0.35  # measured

[[robots]]
name = "scout"
model = "pioneer2dx"
pose = { x = 3.0, y = 1.5 }
"""
MINE = """\
format = 1
model = "pioneer2dx"

[sensors.compass]
model = "tcm2"
latency = 0.1

[drive]
wheel_radius_left = 0.08
"""


@pytest.fixture
def document(tmp_path):
    (tmp_path / "room.wld").write_text("width 4000\nheight 3000\n")
    (tmp_path / "mine.toml").write_text(MINE)
    (tmp_path / "two.toml").write_text(TEXT)
    return am.open_document(tmp_path / "two.toml")


def test_a_value_comes_from_the_file_its_model_a_device_or_a_default(document, tmp_path):
    registry = default_registry()
    pioneer, tcm2 = registry.file("robot", "pioneer2dx"), registry.file("device", "tcm2")
    for path, source, file, value in (
        ("robots.rover.drive.track", "file", tmp_path / "two.toml", 0.35),
        ("robots.rover.drive.wheel_radius_left", "model", tmp_path / "mine.toml", 0.08),
        ("robots.rover.drive.wheel_radius_right", "model", pioneer, 0.0825),
        ("robots.rover.sensors.compass.latency", "model", tmp_path / "mine.toml", 0.1),
        ("robots.rover.sensors.compass.use", "device", tcm2, "compass"),
        ("robots.rover.sensors.laser.noise.gaussian.std", "model", pioneer, 0.005),
        ("robots.rover.controller.speed", "file", tmp_path / "two.toml", 0.4),
        ("robots.rover.on_collision", "default", None, "end"),
        ("robots.rover.sensors.laser.latency", "default", None, 0.0),
        ("robots.rover.sensors.laser.rate", "default", None, "none"),
        ("robots.rover.pose.heading_deg", "default", None, 0.0),
        ("robots.rover.errors.drive.track.scale", "default", None, 1.0),
        ("simulation.dt", "file", tmp_path / "two.toml", 0.2),
        ("simulation.duration", "default", None, 60.0),
        ("recording.sensors", "default", None, "auto"),
    ):
        origin = document.inherited(path)
        assert (origin.source, origin.file, origin.value) == (source, file, value), path
        assert document.get(path) == value
    assert document.inherited("robots.rover.drive.track").line == 13
    assert document.inherited("robots.rover.drive.wheel_radius_left").line == 9
    text = Path(pioneer).read_text().splitlines()
    assert text[document.inherited("robots.scout.drive.track").line - 1].startswith("track = 0.33")


def test_what_would_hold_without_the_file_is_reported(document):
    under = document.inherited("robots.rover.drive.track").under
    assert (under.source, under.value) == ("model", 0.33)
    under = document.inherited("simulation.dt").under
    assert (under.source, under.value) == ("default", 0.1)
    assert document.inherited("robots.rover.name").under is None


def test_a_value_that_is_set_back_is_inherited_again(document):
    document.set("robots.rover.drive.track", 0.33)
    assert document.text == TEXT.replace("drive.track = 0.35  # measured\n", "")
    document.undo()
    for path, value in (
        ("robots.scout.drive.track", 0.4),
        ("robots.scout.sensors.laser.range_max", 10.0),
        ("robots.scout.sensors.compass.mount.x", 0.1),
        ("simulation.duration", 30.0),
        ("recording.sensors", "all"),
        ("robots.rover.controller.clearance", 1.0),
    ):
        before = document.get(path)
        document.set(path, value)
        assert document.get(path) == value
        document.set(path, before)
        assert document.text == TEXT, path


def test_a_value_of_the_author_that_is_set_to_the_default_goes(document):
    document.set("simulation.dt", 0.05)
    document.set("simulation.dt", 0.2)
    assert document.text == TEXT
    document.set("simulation.dt", 0.1)
    assert document.text == TEXT.replace("dt = 0.2\n", "")


def test_what_is_inherited_anyway_is_not_written(document):
    document.set("robots.scout.drive.track", 0.33)
    document.set("robots.rover.drive", document.get("robots.rover.drive"))
    document.set("robots.scout.sensors.laser.beams", 181)
    assert document.text == TEXT


def test_an_item_of_a_list_of_the_model_takes_the_list_into_the_file(document):
    document.set("robots.scout.sensors.laser.noise.gaussian.std", 0.02)
    noise = document.get("robots.scout.sensors.laser.noise")
    assert noise == [{"use": "gaussian", "std": 0.02}, {"use": "quantize", "step": 0.01}]
    assert document.inherited("robots.scout.sensors.laser.noise").source == "file"
    assert document.scenario().robots[1].sensors["laser"].noise[0].noise.std == 0.02
    document.set("robots.scout.sensors.laser.noise.gaussian.std", 0.005)
    assert document.text == TEXT


def test_a_model_that_cannot_be_read_hides_no_value_of_the_file(document, tmp_path):
    (tmp_path / "mine.toml").write_text("drive = [\n")
    document = am.open_document(tmp_path / "two.toml")
    assert document.get("robots.rover.drive.track") == 0.35
    document.set("robots.rover.drive.track", 0.36)
    assert "track = 0.36  # measured" in document.text


@pytest.mark.parametrize("path", ["robots.rover.drive.tracks", "simulation.speed", "author"])
def test_what_nothing_says_is_an_error(document, path):
    for ask in (document.get, document.inherited):
        with pytest.raises(am.DocumentError, match="nothing says it"):
            ask(path)


def test_what_the_model_says_cannot_be_removed_from_the_file(document):
    with pytest.raises(am.DocumentError, match=r"mine\.toml does"):
        document.remove("robots.rover.drive.wheel_radius_left")


def test_a_model_is_a_document_too(document, tmp_path):
    model = am.open_document(tmp_path / "mine.toml")
    assert model.faults() == ()
    assert model.inherited("drive.wheel_radius_left").source == "file"
    assert model.inherited("drive.wheel_radius_left").under.value == 0.0825
    assert (model.inherited("drive.track").source, model.get("drive.track")) == ("model", 0.33)
    assert model.inherited("sensors.compass.use").source == "device"
    model.set("drive.track", 0.4)
    model.set("sensors.laser.beams", 31)
    model.set("drive.track", 0.33)
    model.set("sensors.laser.beams", 181)
    assert model.text == MINE
    model.set("drive.tracks", 3)
    model.set("pose.x", 1.0)
    model.set("sensors.laser.beams", -1)
    assert {(fault.path, fault.line) for fault in model.faults()} == {
        ("drive.tracks", 13),
        ("pose", 15),
        ("sensors.laser.beams", 9),
    }
    with pytest.raises(am.ScenarioError):
        model.scenario()
    for _ in range(3):
        model.undo()
    with pytest.raises(am.DocumentError, match="no scenario"):
        model.scenario()


def test_a_device_is_a_document_too(tmp_path):
    path = tmp_path / "far.toml"
    text = 'format = 1\nmodel = "sick-lms200"\nrange_max = 30.0\n'
    path.write_text(text)
    device = am.open_document(path)
    assert device.faults() == ()
    assert (device.inherited("beams").source, device.inherited("latency").source) == ("device", "default")
    under = device.inherited("range_max").under
    assert under.source == "device"
    device.set("range_max", -1)
    assert [(fault.path, fault.line) for fault in device.faults()] == [("range_max", 3)]
    device.set("range_max", under.value)
    assert device.text == text.replace("range_max = 30.0\n", "")


def test_a_device_that_builds_on_an_unknown_one_can_be_changed(tmp_path):
    path = tmp_path / "far.toml"
    path.write_text('format = 1\nmodel = "sick-lms2000"\nrange_max = 30.0\n')
    device = am.open_document(path)
    assert device.get("range_max") == 30.0
    with pytest.raises(am.DocumentError, match="nothing says it"):
        device.get("beams")
    device.set("range_max", 20.0)
    assert "range_max = 20.0" in device.text
    assert [fault.path for fault in device.faults()] == ["model"]
