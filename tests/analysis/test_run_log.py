"""Estimators run on the folder of a run, as on a robot's log."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import attrs
import numpy as np
import pytest

import amorsim as am
from amorsim.analysis import RunFiles, export_run, read_log
from amorsim.simulation.fleet.grouping import reading_size

DIGIT = 1e-6  # [m, rad] files of a run have six digits
CHANGES = ["robots.rover.sensors.compass.rate=5.0", "robots.rover.sensors.compass.latency=0.1"]


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("logs") / "run"
    am.run(am.load("landmarks", CHANGES), folder, duration=2.0, replicas=2)
    return folder


@pytest.mark.parametrize("name", ["wheels", "ekf"])
def test_an_estimator_gives_the_estimates_of_the_run(run: Path, name: str) -> None:
    files = RunFiles(run)
    robot = files.scenario.robots[0]
    runner = am.EstimatorRunner(robot, name, dt=files.scenario.dt)
    log = list(read_log(run, robot, replica=1))
    found = [runner.update(*entry) for entry in log]
    wanted = files.arrays(f"estimates/{name}")
    assert [entry.time for entry in log] == wanted["time"].tolist()
    # The filter moves by less than its readings are off, and its covariance changes even less.
    assert np.abs(np.array([each.pose for each in found]) - wanted["pose"][:, 1]).max() < 2.0 * DIGIT
    assert np.abs(np.array([each.covariance for each in found]) - wanted["covariance"][:, 1]).max() < DIGIT
    assert found[-1].pose[0] > robot.pose.x + 0.3


def test_entries_have_what_was_read_and_when(run: Path) -> None:
    files = RunFiles(run)
    log = list(read_log(run, files.scenario.robots[0], replica=0))
    table = files.table("sensors/compass", replica=0)
    seen = [entry for entry in log if "compass" in entry.readings]
    assert [entry.time for entry in seen] == table["time"].tolist()
    assert [entry.readings["compass"][0] for entry in seen] == table["measured_0"].tolist()
    assert [entry.ages["compass"] for entry in seen] == pytest.approx((table["time"] - table["stamp"]).tolist())
    assert 5 < len(seen) < len(log) == 21
    assert all("encoder" in entry.readings for entry in log)
    assert log[0].command is None
    commands = files.table("commands", replica=0)
    assert [entry.command[0] for entry in log[1:] if entry.command is not None] == commands["left"][1:].tolist()


def test_mistakes_are_named(run: Path) -> None:
    robot = RunFiles(run).scenario.robots[0]
    with pytest.raises(am.RunError, match=r"2 replicas; say which one with replica="):
        list(read_log(run, robot))
    with pytest.raises(am.RunError, match="no replica 7"):
        list(read_log(run, robot, replica=7))
    with pytest.raises(am.RunError, match=r"no robot 'rovr'; did you mean 'rover'"):
        list(read_log(run, attrs.evolve(robot, name="rovr"), replica=0))
    wrong: Any = "rover"  # as other functions take it
    with pytest.raises(am.ParameterError, match=r"robot: expected a Robot, as am\.load.*, got 'rover'"):
        read_log(run, wrong)
    wrong = None
    with pytest.raises(am.ParameterError, match="path: expected the path of a recording, got None"):
        read_log(wrong, robot)
    with pytest.raises(am.AnalysisError, match="has no topics"):
        read_log(run, robot, command="/cmd_vel")
    with pytest.raises(am.AnalysisError, match="is not the folder of a run"):
        read_log(run / "none.mcap", robot, replica=0)


def test_readings_of_another_size_than_the_robot_expects_are_refused(tmp_path: Path) -> None:
    """Of a laser with fewer beams, they would be those of the first beams alone."""
    robot = am.load("demo").robots[0]
    am.run(am.load("demo"), tmp_path / "run", duration=0.2)
    few = attrs.evolve(robot, sensors={**robot.sensors, "laser": am.MountedSensor(sensor=am.sensors.Laser(beams=3))})
    beams = reading_size(robot, "laser")
    first = next(entry for entry in read_log(tmp_path / "run", few) if "laser" in entry.readings)
    runner = am.EstimatorRunner(few, "dead_reckoning")
    with pytest.raises(am.AmorsimError, match=rf"expected 3 numbers as a reading of 'laser', got {beams}"):
        runner.update(*first)


def test_a_sensor_that_only_another_robot_of_the_run_has_gives_no_readings(tmp_path: Path) -> None:
    demo = am.load("demo")
    robot = demo.robots[0]
    less = {name: unit for name, unit in robot.sensors.items() if name != "laser"}
    blind = attrs.evolve(
        robot, name="blind", sensors=less, estimators={}, controller=None, pose=attrs.evolve(robot.pose, x=3.0)
    )
    am.run(attrs.evolve(demo, robots=[robot, blind]), tmp_path / "run", duration=0.2)
    log = list(read_log(tmp_path / "run", attrs.evolve(blind, sensors=robot.sensors)))
    assert not any("laser" in entry.readings for entry in log)


def test_a_run_without_its_readings_is_no_log_of_a_robot_that_stood(tmp_path: Path) -> None:
    scenario = am.load("landmarks", ["recording.sensors='none'"])
    am.run(scenario, tmp_path / "run", duration=0.5)
    with pytest.raises(
        am.AnalysisError,
        match=r"readings of .*encoder.* were not written; .*'all', or pass the robot without these sensors",
    ):
        list(read_log(tmp_path / "run", scenario.robots[0]))
    without = attrs.evolve(scenario.robots[0], sensors={}, estimators={})
    assert [entry.readings for entry in read_log(tmp_path / "run", without)] == [{}] * 6


@pytest.mark.parametrize("kind", ["rosbag", "mcap"])
def test_nor_is_a_recording_of_it(kind: str, tmp_path: Path) -> None:
    pytest.importorskip({"rosbag": "rosbags", "mcap": "mcap"}[kind])
    scenario = am.load("landmarks", ["recording.sensors='none'"])
    am.run(scenario, tmp_path / "run", duration=0.5)
    (path,) = export_run(tmp_path / "run", kind, tmp_path / "export")
    with pytest.raises(am.AnalysisError, match=r"there is none of the topics /rover/.*encoder"):
        list(read_log(path, scenario.robots[0]))
    assert len(list(read_log(path, scenario.robots[0], topics={}))) == 5  # commands alone
