"""Models and devices as files: only what differs from what they build on, and read again the same."""

from __future__ import annotations

import attrs
import pytest

import amorsim as am
from amorsim.plugins.manager import default_registry
from amorsim.scenario.files.resolved import robot_table, sensor_table

REGISTRY = default_registry()
ROBOTS = REGISTRY.names("robot")
DEVICES = REGISTRY.names("device")


def same(robot, other):
    return robot_table(robot, REGISTRY) == robot_table(other, REGISTRY)


def test_what_is_as_the_model_says_is_not_written(tmp_path):
    robot = am.load_robot("pioneer2dx")
    path = am.save_robot(robot, tmp_path / "mine.toml")
    assert path.read_text() == 'format = 1\nmodel = "pioneer2dx"\n'
    laser = attrs.evolve(robot.sensors["laser"], rate=5.0)
    sensors = {name: unit for name, unit in robot.sensors.items() if name != "sonar"} | {"laser": laser}
    robot = attrs.evolve(robot, drive=attrs.evolve(robot.drive, track=0.34), sensors=sensors, height=0.4)
    am.save_robot(robot, path)
    assert path.read_text() == (
        'format = 1\nmodel = "pioneer2dx"\nheight = 0.4\n\n[drive]\ntrack = 0.34\n\n[sensors]\nsonar = false\n'
        "\n[sensors.laser]\nrate = 5.0\n"
    )
    assert same(am.load_robot(str(path)), robot)
    assert am.open_document(path).faults() == ()


@pytest.mark.parametrize("name", ROBOTS)
@pytest.mark.parametrize("model", ["", "pioneer2dx", "khepera"])
def test_every_robot_is_read_again_the_same_on_any_model(tmp_path, name, model):
    robot = am.load_robot(name)
    path = am.save_robot(robot, tmp_path / "mine.toml", model=model)
    assert same(am.load_robot(str(path)), robot)


@pytest.mark.parametrize("name", DEVICES)
def test_every_device_is_read_again_the_same(tmp_path, name):
    device = am.load_device(name)
    for model in ("", name, "tcm2"):
        path = am.save_device(device, tmp_path / "mine.toml", model=model)
        assert sensor_table(am.load_device(str(path)), REGISTRY) == sensor_table(device, REGISTRY)
    am.save_device(attrs.evolve(device, latency=0.25), path, model=name)
    assert path.read_text() == f'format = 1\nmodel = "{name}"\nlatency = 0.25\n'


def test_a_model_in_a_file_and_a_program_are_named_from_the_new_file(tmp_path):
    (tmp_path / "mine.py").write_text("def drive(readings, estimate, clock):\n    return None\n")
    (tmp_path / "cart.toml").write_text('format = 1\nmodel = "pioneer2dx"\ncontroller = { use = "mine.py:drive" }\n')
    (tmp_path / "away").mkdir()
    cart = am.load_robot(str(tmp_path / "cart.toml"), errors={"drive.track": am.Deviation(scale=1.1)})
    path = am.save_robot(cart, tmp_path / "away" / "other.toml", model=str(tmp_path / "cart.toml"))
    assert path.read_text() == (
        'format = 1\nmodel = "../cart.toml"\n\n[errors.drive]\ntrack = { scale = 1.1, add = 0.0, per = "replica" }\n'
    )
    assert same(am.load_robot(str(path)), cart)
    path = am.save_robot(cart, tmp_path / "away" / "other.toml", model="pioneer2dx")
    assert 'use = "../mine.py:drive"' in path.read_text()
    assert same(am.load_robot(str(path)), cart)


def test_what_a_file_cannot_take_away_is_an_error(tmp_path):
    (tmp_path / "cart.toml").write_text('format = 1\nmodel = "pioneer2dx"\ncontroller = { use = "wander" }\n')
    for model, part in ((str(tmp_path / "cart.toml"), "controller"), ("pioneer2dx-typical", "errors")):
        with pytest.raises(am.RunError, match=f"{part}: the model has this and the robot has not"):
            am.save_robot(am.load_robot("pioneer2dx"), tmp_path / "mine.toml", model=model)
    assert not (tmp_path / "mine.toml").exists()
