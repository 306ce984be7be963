"""Robots of models, in Python."""

from __future__ import annotations

from pathlib import Path

import pytest

import amorsim as am
from tests import building


def test_a_shipped_model_with_what_is_to_be_otherwise() -> None:
    wander = am.controllers.Wander(speed=0.2)
    rover = am.load_robot("pioneer2dx", name="rover", pose=am.Pose(x=2.0, y=2.0), controller=wander)
    assert (rover.name, rover.model, rover.pose, rover.controller) == ("rover", "pioneer2dx", am.Pose(x=2, y=2), wander)
    assert {"encoder", "laser", "sonar"} <= set(rover.sensors)
    sim = am.Simulation(am.Scenario(map=building.room(), robots=[rover], dt=0.1, duration=1.0))
    sim.run()
    assert sim.robot("rover").readings["laser"].measured.shape == (181,)
    assert am.load_robot("pioneer2dx").name == "robot"


def test_the_same_as_in_a_file(tmp_path: Path) -> None:
    (tmp_path / "mine.toml").write_text('format = 1\nmodel = "pioneer2dx"\ndrive.track = 0.5\n')
    assert am.load_robot(tmp_path / "mine.toml").drive.track == 0.5


def test_what_is_wrong_is_reported(tmp_path: Path) -> None:
    with pytest.raises(am.ScenarioError, match=r"no robot 'pioner2dx'.* Did you mean 'pioneer2dx'"):
        am.load_robot("pioner2dx")
    (tmp_path / "mine.toml").write_text('format = 1\nmodel = "pioneer2dx"\ndrive.tracks = 0.5\n')
    with pytest.raises(am.ScenarioError, match=r"mine\.toml:3: drive\.tracks: unknown key"):
        am.load_robot(tmp_path / "mine.toml")
    with pytest.raises(am.AmorsimError, match=r"a robot has no field 'controler'.* Did you mean 'controller'"):
        am.load_robot("pioneer2dx", controler=None)
    with pytest.raises(am.ParameterError, match="on_collision"):
        am.load_robot("pioneer2dx", on_collision="explode")


def test_a_model_may_take_sensors_of_its_own_model_away(tmp_path):
    (tmp_path / "blind.toml").write_text('format = 1\nmodel = "pioneer2dx"\nsensors.laser = false\n')
    robot = am.load_robot(tmp_path / "blind.toml")
    assert set(robot.sensors) == set(am.load_robot("pioneer2dx").sensors) - {"laser"}
