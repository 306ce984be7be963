"""Reading a run's files back."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import amorsim as am
from amorsim.analysis import run_files as files_module
from amorsim.analysis.run_files import RunFiles
from tests.studies import make_study


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    return am.run(am.load(make_study(tmp_path / "study")), tmp_path / "run", replicas=[4, 2], duration=1.0).folder


def test_tables_are_columns_of_one_robot_in_one_replica(folder: Path) -> None:
    files = RunFiles(folder)
    assert files.robots == ["rover"]
    assert files.sensors == ["compass", "encoder", "gyro", "laser", "sonar"]
    poses = files.table("poses", robot="rover", replica=2)
    np.testing.assert_allclose(poses["time"], np.arange(11) * 0.1, atol=1e-9)
    assert set(poses["replica"].tolist()) == {2.0}
    assert poses["robot"].tolist() == ["rover"] * 11
    other = files.table("poses", robot="rover", replica=4)
    assert set(other["replica"].tolist()) == {4}
    assert (other["true_heading"] != poses["true_heading"]).any()
    assert files.table("sensors/laser", replica=4)["measured_180"].shape == (11,)
    assert len(files.table("events", replica="all")["time"]) == 0


def test_of_several_replicas_none_is_taken_in_silence(folder: Path) -> None:
    files = RunFiles(folder)
    with pytest.raises(am.RunError, match=r"there are 2 replicas; say which one with replica=, or replica=\"all\""):
        files.table("poses", robot="rover")
    whole = files.table("poses", replica="all")
    assert whole["replica"].tolist() == [4, 2] * 11
    for replica in (4, 2):
        one = files.table("poses", robot="rover", replica=replica)
        np.testing.assert_array_equal(one["true_x"], whole["true_x"][whole["replica"] == replica])


def test_arrays_hold_all_replicas_and_robots_in_the_order_of_a_simulations_rows(tmp_path: Path) -> None:
    text = make_study(tmp_path / "study").read_text()
    second = text[text.index("[[robots]]") :].replace('"rover"', '"alpha"').replace("x = 1.0", "x = 3.0")
    (tmp_path / "study" / "scenario.toml").write_text(text + "\n" + second)
    simulation = am.Simulation(am.load(tmp_path / "study" / "scenario.toml"), replicas=[4, 2])
    seen = [(simulation.true_pose.copy(), simulation.estimated_pose.copy(), simulation.covariance.copy())]
    ranges = [simulation.readings["laser"].measured.copy()]
    with am.record(simulation, tmp_path / "run") as session:
        for _ in range(12):
            simulation.step()
            session.keep()
            seen.append((simulation.true_pose.copy(), simulation.estimated_pose.copy(), simulation.covariance.copy()))
            if (simulation.readings["laser"].fresh).all():
                ranges.append(simulation.readings["laser"].measured.copy())
    true, estimated, covariance = (np.array(parts) for parts in zip(*seen, strict=True))
    files = RunFiles(tmp_path / "run")
    assert files.rows == [(4, "alpha"), (4, "rover"), (2, "alpha"), (2, "rover")]
    poses = files.arrays("poses")
    np.testing.assert_allclose(poses["time"], np.arange(13) * 0.1, atol=1e-9)
    assert poses["true_pose"].shape == (13, 4, 3)
    np.testing.assert_allclose(poses["true_pose"], true, atol=1e-6)
    np.testing.assert_allclose(poses["estimated_pose"], estimated, atol=1e-6)
    (estimator,) = files.estimators
    estimates = files.arrays(f"estimates/{estimator}")
    np.testing.assert_array_equal(estimates["covariance"], covariance)
    np.testing.assert_array_equal(estimates["pose"], poses["estimated_pose"])
    laser = files.arrays("sensors/laser")
    assert laser["measured"].shape == (len(ranges), 4, 181)
    np.testing.assert_allclose(laser["measured"], ranges, atol=1e-6)
    assert files.arrays("velocities")["measured_rates"].shape == (13, 4, 2)
    assert files.arrays("commands")["command"].shape == (13, 4, 2)
    alone = files.arrays("poses", robot="rover")
    np.testing.assert_array_equal(alone["true_pose"], poses["true_pose"][:, 1::2])
    for row, (replica, robot) in enumerate(files.rows):
        one = files.table("poses", robot=robot, replica=replica)
        np.testing.assert_array_equal(one["true_x"], poses["true_pose"][:, row, 0])
    with pytest.raises(am.RunError, match="only poses, velocities, commands, estimates, beliefs and sensors have rows"):
        files.arrays("events")


def test_a_file_is_read_once(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    read = []
    real = files_module.read_columns
    monkeypatch.setattr(
        files_module, "read_columns", lambda path, *rest, **how: read.append(path) or real(path, *rest, **how)
    )
    files = RunFiles(folder)
    for replica in files.replicas * 3:
        files.table("poses", robot="rover", replica=replica)
    files.arrays("poses")
    assert read == [folder / "poses.csv"]


def test_arrays_leave_out_a_step_that_not_all_robots_have(folder: Path) -> None:
    lines = (folder / "poses.csv").read_text().splitlines(keepends=True)
    (folder / "poses.csv").write_text("".join(lines[:-1]))
    assert RunFiles(folder).arrays("poses")["true_pose"].shape == (10, 2, 3)


@pytest.mark.parametrize(
    ("old", "new", "problem"),
    [
        ("2,0.400000,rover", "2,0.400000,rove", r"line 11, robot: there is no robot 'rove'"),
        ("2,0.400000,rover", "3,0.400000,rover", r"line 11, replica: there is no replica 3"),
        ("2,0.400000,rover", "2,0.450000,rover", r"line 11, time: expected the time of the same step"),
    ],
)
def test_arrays_of_lines_that_do_not_fit_are_refused(folder: Path, old: str, new: str, problem: str) -> None:
    text = (folder / "poses.csv").read_text()
    assert old in text
    (folder / "poses.csv").write_text(text.replace(old, new))
    with pytest.raises(am.RunError, match=problem):
        RunFiles(folder).arrays("poses")


def test_arrays_of_files_with_gaps_are_refused(folder: Path) -> None:
    lines = (folder / "poses.csv").read_text().splitlines(keepends=True)
    (folder / "poses.csv").write_text(
        "".join(line for line in lines if not line.startswith("2,0.4") and not line.startswith("2,0.5"))
    )
    with pytest.raises(am.RunError, match=r"got 9 of 'rover' in replica 2 and 11 of 'rover' in replica 4"):
        RunFiles(folder).arrays("poses")


def test_a_half_line_of_a_killed_run_is_left_out(folder: Path) -> None:
    poses = folder / "poses.csv"
    whole = RunFiles(folder).table("poses", replica=2)["true_x"]
    text = poses.read_text().rstrip("\n")
    # The last line is of replica 2; cut within its last number, it would still have all its cells.
    poses.write_text(text[:-3])
    np.testing.assert_array_equal(RunFiles(folder).table("poses", replica=2)["true_x"], whole[:-1])


def test_what_is_not_there_is_named(folder: Path) -> None:
    files = RunFiles(folder)
    with pytest.raises(am.RunError, match=r"no robot 'rovr'; did you mean 'rover'\?"):
        files.table("poses", robot="rovr")
    with pytest.raises(am.RunError, match="no replica 3; known replicas: 4, 2"):
        files.table("poses", replica=3)
    with pytest.raises(am.RunError, match=r"lidar.csv: cannot be read"):
        files.table("sensors/lidar", replica=4)
    lines = (folder / "poses.csv").read_text().splitlines()
    lines[5] = "4,0.2,rover"
    (folder / "poses.csv").write_text("\n".join(lines) + "\n")
    with pytest.raises(am.RunError, match=r"poses.csv, line 6: is damaged: expected 9 cells, got 3"):
        RunFiles(folder).table("poses", replica=4)


def test_values_with_commas_are_one_cell(tmp_path: Path) -> None:
    study = make_study(tmp_path / "study")
    simulation = am.Simulation(am.load(study))
    simulation.set_pose("rover", (2.0, 1.0, 0.5))
    with am.record(simulation, tmp_path / "run"):
        pass
    events = RunFiles(tmp_path / "run").table("events")
    assert events["value"].tolist() == []  # nothing was stepped, so nothing was kept
    with am.record(am.Simulation(am.load(study)), tmp_path / "again") as session:
        session._simulation.set_pose("rover", (2.0, 1.0, 0.5))
        session._simulation.step()
        session.keep()
    assert RunFiles(tmp_path / "again").table("events")["value"].tolist() == ["[2.0, 1.0, 0.5]"]
