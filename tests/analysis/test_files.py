"""Reading a run's files back."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import amorsim as am
from amorsim.analysis.files import RunFiles
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
    first = files.table("poses", robot="rover")
    assert set(first["replica"].tolist()) == {4.0}
    assert (first["true_heading"] != poses["true_heading"]).any()
    assert files.table("sensors/laser")["measured_180"].shape == (11,)
    assert len(files.table("events")["time"]) == 0


def test_a_half_line_of_a_killed_run_is_left_out(folder: Path) -> None:
    poses = folder / "poses.csv"
    whole = RunFiles(folder).table("poses", replica=2)["true_x"]
    text = poses.read_text().rstrip("\n")
    # The last line is of replica 2; cut within its last number, it would still have all its cells.
    poses.write_text(text[:-3])
    np.testing.assert_array_equal(RunFiles(folder).table("poses", replica=2)["true_x"], whole[:-1])


def test_what_is_not_there_is_named(folder: Path) -> None:
    files = RunFiles(folder)
    with pytest.raises(am.RunError, match=r"no robot 'rovr', but: rover. Did you mean 'rover'\?"):
        files.table("poses", robot="rovr")
    with pytest.raises(am.RunError, match="no replica 3, but: 4, 2"):
        files.table("poses", replica=3)
    with pytest.raises(am.RunError, match=r"lidar.csv: cannot be read"):
        files.table("sensors/lidar")
    lines = (folder / "poses.csv").read_text().splitlines()
    lines[5] = "4,0.2,rover"
    (folder / "poses.csv").write_text("\n".join(lines) + "\n")
    with pytest.raises(am.RunError, match=r"poses.csv, line 6: is damaged: expected 9 cells, got 3"):
        files.table("poses")


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
