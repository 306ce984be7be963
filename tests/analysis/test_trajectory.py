"""Trajectories from and to files."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

import amorsim as am
from amorsim.analysis import (
    Trajectory,
    read_csv,
    read_kitti,
    read_tum,
    run_trajectories,
    write_csv,
    write_kitti,
    write_tum,
)
from tests import building


def some() -> Trajectory:
    random = np.random.default_rng(1)
    poses = np.column_stack((random.normal(size=(50, 2)), random.uniform(-3.1, 3.1, 50)))
    return Trajectory(time=np.arange(50) * 0.1, poses=poses)


def test_a_quaternion_of_any_length_is_a_heading(tmp_path: Path) -> None:
    ends = "0 0 2 2", "0 0 3 -3", "0 0 1e-200 1e-200", "0 0 0 0"
    (tmp_path / "a.tum").write_text("".join(f"{time} 1 2 0 {end}\n" for time, end in enumerate(ends)))
    quarter = math.pi / 2
    assert read_tum(tmp_path / "a.tum").poses[:, 2] == pytest.approx([quarter, -quarter, quarter, 0.0], abs=1e-15)


def test_files_give_the_poses_back(tmp_path: Path) -> None:
    made = some()
    write_csv(made, tmp_path / "a.csv")
    assert (read_csv(tmp_path / "a.csv").poses == made.poses).all()
    assert (read_csv(tmp_path / "a.csv").time == made.time).all()
    write_tum(made, tmp_path / "a.tum")
    assert np.abs(read_tum(tmp_path / "a.tum").poses - made.poses).max() < 1e-14
    write_kitti(made, tmp_path / "a.kitti")
    (tmp_path / "times.txt").write_text("".join(f"{time!r}\n" for time in made.time.tolist()))
    read = read_kitti(tmp_path / "a.kitti", tmp_path / "times.txt")
    assert np.abs(read.poses - made.poses).max() < 1e-14
    assert (read.time == made.time).all()


def test_a_camera_of_kitti_looks_along_z(tmp_path: Path) -> None:
    # Two metres ahead, one to the left, turned by 0.3 rad to the left: about the camera's -y.
    cos, sin = math.cos(0.3), math.sin(0.3)
    row = [cos, 0.0, -sin, -1.0, 0.0, 1.0, 0.0, 0.0, sin, 0.0, cos, 2.0]
    (tmp_path / "a.txt").write_text(" ".join(map(str, row)) + "\n")
    assert read_kitti(tmp_path / "a.txt", plane="zx").poses[0] == pytest.approx([2.0, 1.0, 0.3])


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("1 2 3\n", "line 1: expected 8 numbers, got 3"),
        ("# head\n1 0 0 0 0 0 0 1\n2 x 0 0 0 0 0 1\n", "line 3: expected a finite number, got 'x'"),
        ("2 0 0 0 0 0 0 1\n1 0 0 0 0 0 0 1\n", "expected increasing times, got 1.0 after 2.0"),
        ("1 nan 0 0 0 0 0 1\n", "line 1: expected a finite number, got 'nan'"),
    ],
)
def test_a_damaged_file_is_reported(tmp_path: Path, text: str, words: str) -> None:
    (tmp_path / "a.tum").write_text(text)
    with pytest.raises(am.AnalysisError, match=words):
        read_tum(tmp_path / "a.tum")


def test_a_table_without_its_columns_is_reported(tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_text("time,x,z\n1,2,3\n")
    with pytest.raises(am.AnalysisError, match=r"line 1: no column 'y'; known columns: time, x, z"):
        read_csv(tmp_path / "a.csv")
    with pytest.raises(am.AnalysisError, match=r"cannot be read"):
        read_csv(tmp_path / "none.csv")


def test_a_run_has_trajectories(tmp_path: Path) -> None:
    scenario = building.scenario(building.robot(controller=am.controllers.Square(side=1.0)))
    am.run(scenario, tmp_path / "run", duration=1.0, replicas=2)
    true, believed = run_trajectories(tmp_path / "run", replica=1)
    simulation = am.Simulation(scenario, replicas=2)
    kept = simulation.run(1.0, keep=("true_pose", "estimated_pose"))
    assert np.abs(true.poses[1:] - kept["true_pose"][:, 1]).max() < 1e-6
    assert np.abs(believed.poses[1:] - kept["estimated_pose"][:, 1]).max() < 1e-6
    _, reckoned = run_trajectories(tmp_path / "run", replica=1, estimator="dead_reckoning")
    assert (reckoned.poses == believed.poses).all()
    with pytest.raises(am.RunError, match=r"no estimator 'ekf'; known estimators: dead_reckoning"):
        run_trajectories(tmp_path / "run", replica=0, estimator="ekf")
    with pytest.raises(am.RunError, match=r"there are 2 replicas"):
        run_trajectories(tmp_path / "run")
