"""A log becomes a path, a map and a graph: against the simulation that made the log, and by its files."""

from __future__ import annotations

import math
from pathlib import Path

import attrs
import numpy as np
import pytest

import amorsim as am
from amorsim.algorithms.pose_graph import read_g2o
from amorsim.analysis import SlamResult, clock_offset, read_relations, relation_errors, slam
from amorsim.analysis.logs.slam_replay import SlamReplay
from amorsim.core.errors import AnalysisError, RunError
from amorsim.runs.tables import read_columns
from tests import building


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A run of a robot with a laser that maps a room."""
    sensors = building.all_sensors()
    laser = am.MountedSensor(sensor=am.sensors.Laser(beams=90, fov=math.tau * 89 / 90, range_max=12.0))
    estimators = {
        "graph": am.estimators.GraphSlam(wheel_variance=1e-4, range_std=0.01, nodes=50),
        "matched": am.estimators.ScanMatching(wheel_variance=1e-4, range_std=0.01),
    }
    robot = building.robot(
        name="rover",
        pose=am.Pose(x=1.0, y=1.0),
        controller=am.controllers.Square(side=1.5),
        sensors={"encoder": sensors["encoder"], "laser": laser},
        estimators=estimators,
    )
    folder = tmp_path_factory.mktemp("log") / "run"
    am.run(building.scenario(robot), folder, duration=20.0, progress=False)
    return folder


@pytest.mark.long
def test_a_folder_has_each_moment_of_the_log_without_truth(recorded: Path, tmp_path: Path) -> None:
    slam(recorded, robot_of(recorded), "graph", progress=False, out=tmp_path / "out", resolution=0.1)
    here, there = (read_columns(path / "poses.csv", "") for path in (tmp_path / "out", recorded))
    assert here["time"].tolist() == there["time"].tolist()
    assert np.isnan(np.array([here[f"true_{part}"] for part in ("x", "y", "heading")])).all()
    estimated = np.array([[table[f"estimated_{part}"] for part in ("x", "y", "heading")] for table in (here, there)])
    np.testing.assert_allclose(*estimated, rtol=0.0, atol=2e-3)  # of readings that files have to six decimals
    scans = [read_columns(path / "sensors" / "laser.csv", "") for path in (tmp_path / "out", recorded)]
    for column in ("time", "stamp", "measured_7"):
        np.testing.assert_array_equal(*(table[column] for table in scans))
    assert np.isnan(scans[0]["true_7"]).all()
    files = sorted((tmp_path / "out" / "beliefs" / "graph").glob("*.npz"))
    assert [int(file.stem) for file in files] == list(range(0, 201, 10))
    with np.load(files[-1]) as arrays:
        assert arrays["robot"].tolist() == ["rover"]
        assert np.isfinite(arrays["graph_poses"]).any()
    world = am.load(tmp_path / "out" / "scenario.toml")
    assert list(world.robots[0].estimators) == ["graph"]
    assert world.map.resolution == 0.1
    assert not (tmp_path / "out" / "map").exists()  # map.yaml is the world; a second copy of it is not made
    with pytest.raises(RunError, match="holds files already"):
        slam(recorded, robot_of(recorded), "graph", progress=False, out=tmp_path / "out")


@pytest.mark.long
def test_a_long_log_has_fewer_moments_and_holds_the_estimate_between_two_entries(tmp_path: Path) -> None:
    robot = building.robot(name="rover", pose=am.Pose(x=1.0, y=1.0), sensors=building.all_sensors())
    runner = am.EstimatorRunner(robot, am.estimators.DeadReckoning(encoder="encoder"))
    counts = np.full(2, 1000.0)
    with SlamReplay(tmp_path / "out", "long.log", 4000.0) as replay:
        for time in (0.0, 0.05, 900.0, 4000.0):
            replay.write_until(time)
            runner.update(time + 1e9, {"encoder": counts * time} if time != 900.0 else {})
            replay.keep(runner.frame())
        replay.write_until(4001.0)
    table = read_columns(tmp_path / "out" / "poses.csv", "")
    assert len(table["time"]) == pytest.approx(20_000, abs=10)
    assert np.diff(table["time"]) == pytest.approx(0.2)
    assert len(set(table["estimated_x"].tolist())) == 2  # the end's differs from all before
    arrived = read_columns(tmp_path / "out" / "sensors" / "encoder.csv", "")["time"]
    assert arrived.tolist() == pytest.approx([0.0, 4000.0], abs=0.2)  # 0 s and 0.05 s are one moment


@pytest.mark.long
def test_an_interrupt_while_the_result_is_saved_loses_no_moment(
    recorded: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def interrupted(*_: object) -> list[Path]:
        raise KeyboardInterrupt

    monkeypatch.setattr(SlamResult, "save", interrupted)
    with pytest.raises(KeyboardInterrupt):
        slam(recorded, robot_of(recorded), "graph", progress=False, out=tmp_path / "out")
    assert len(read_columns(tmp_path / "out" / "poses.csv", "")["time"]) > 150


def test_of_a_log_without_scans_no_folder_stays(recorded: Path, tmp_path: Path) -> None:
    blind = tmp_path / "blind.log"
    blind.write_text("ODOM 0 0 0 0 0 0 1.0 host 0\nODOM 0.1 0 0 0 0 0 2.0 host 1\n")
    with pytest.raises(AnalysisError, match="no scan"):
        slam(blind, progress=False, out=tmp_path / "out")
    assert not (tmp_path / "out").exists()


def robot_of(folder: Path) -> am.Robot:
    return am.load(folder / "scenario.toml").robots[0]


@pytest.mark.long
def test_a_recorded_run_becomes_a_path_a_map_and_a_graph(recorded: Path, tmp_path: Path) -> None:
    found = slam(recorded, robot_of(recorded), "graph", progress=False)
    true, _ = am.analysis.run_trajectories(recorded)
    assert am.analysis.ape(true, found.path).position.max() < 0.02
    assert found.is_whole
    assert found.scans.shape == (len(found.path), 90)
    made = found.save(tmp_path / "out", 0.1)
    assert [path.name for path in made] == ["path.tum", "online.tum", "odometry.tum", "map.yaml", "graph.g2o"]
    assert am.analysis.read_tum(made[0]).poses == pytest.approx(found.path.poses, abs=1e-9)
    assert found.graph is not None
    np.testing.assert_array_equal(read_g2o(made[-1]).edges, found.graph.edges)
    # Walls of the map lie on walls of the world: the cells that are occupied, against the true map.
    world = am.load(recorded / "scenario.toml").map
    drawn = am.load_map(made[3])
    cells = np.argwhere(drawn.to_array() != 0)
    points = (cells[:, ::-1] + 0.5) * drawn.resolution + np.array(drawn.origin[:2])
    around = 0.12 * np.array([(math.cos(a), math.sin(a)) for a in np.linspace(0.0, math.tau, 16)])
    near = np.array([world.occupied(points + step) for step in around]).any(axis=0) | world.occupied(points)
    assert len(cells) > 50
    assert near.mean() > 0.98


def test_an_estimator_without_a_graph_leaves_none(recorded: Path, tmp_path: Path) -> None:
    found = slam(recorded, robot_of(recorded), "matched", progress=False)
    assert found.graph is None
    np.testing.assert_array_equal(found.path.poses, found.online.poses)
    assert "graph.g2o" not in {path.name for path in found.save(tmp_path / "out")}


def test_what_was_found_until_ctrl_c_is_kept(recorded: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    update = am.EstimatorRunner.update

    def interrupted(self: am.EstimatorRunner, time: float, *entry: object) -> am.Estimate:
        if time > 5.0:
            raise KeyboardInterrupt
        return update(self, time, *entry)  # type: ignore[arg-type]

    monkeypatch.setattr(am.EstimatorRunner, "update", interrupted)
    found = slam(recorded, robot_of(recorded), "graph", progress=False)
    assert not found.is_whole
    assert found.path.time[-1] == pytest.approx(5.0)


def test_a_robot_without_a_laser_or_an_encoder_is_refused(recorded: Path) -> None:
    robot = robot_of(recorded)
    blind = attrs.evolve(robot, sensors={"encoder": robot.sensors["encoder"]}, estimators={})
    with pytest.raises(AnalysisError, match="expected a laser among its sensors: encoder"):
        slam(recorded, blind, am.estimators.DeadReckoning(), progress=False)


def test_a_map_has_a_resolution_that_makes_sense(recorded: Path) -> None:
    found = slam(recorded, robot_of(recorded), "matched", progress=False)
    for resolution in (0.0, math.nan, -1.0):
        with pytest.raises(AnalysisError, match="expected a number of metres > 0"):
            found.map(resolution)
    with pytest.raises(AnalysisError, match="too many cells"):
        found.map(1e-4)


@pytest.mark.parametrize(
    ("relations", "times", "words"),
    [
        (1.0, [1.0], "relations: expected numbers of the shape"),
        ([[1.0, 2.0]], [1.0], "relations: expected numbers of the shape"),
        ("x", [1.0], "relations: expected numbers"),
        (np.ones((2, 5)), {"a": 1}, "times: expected numbers"),
        (np.ones((2, 5)), [math.nan], "times: expected finite numbers"),
        (np.full((2, 5), math.inf), [1.0], "relations: expected finite numbers"),
    ],
)
def test_what_has_no_clock_is_refused_in_words(relations: object, times: object, words: str) -> None:
    with pytest.raises(AnalysisError, match=words):
        clock_offset(relations, times)  # type: ignore[arg-type]
    assert clock_offset(np.empty((0, 5)), [1.0]) == clock_offset(np.ones((1, 5)), []) == 0.0


def test_relations_are_read_and_their_clock_is_found(tmp_path: Path) -> None:
    rng = np.random.default_rng(3)
    times = np.cumsum(rng.uniform(1.0, 4.0, 200))
    pairs = rng.integers(0, 200, (40, 2))
    path = tmp_path / "a.relations"
    rows = [f"{times[i] + 1e9:.6f} {times[j] + 1e9:.6f} 1 2 0 0 0 0.5" for i, j in pairs.tolist()]
    path.write_text("# known\n" + "\n".join(rows) + "\n")
    relations = read_relations(path)
    assert relations.shape == (40, 5)
    assert relations[0, 2:].tolist() == [1.0, 2.0, 0.5]
    assert clock_offset(relations, times) == pytest.approx(1e9, abs=0.01)
    assert clock_offset(relations, np.cumsum(rng.uniform(1.0, 4.0, 200))) == 0.0  # no log of theirs
    regular = np.arange(200.0)
    relations[:, :2] = 1e9 + regular[50 + pairs % 50]
    assert clock_offset(relations, regular) == 0.0  # which of many?


@pytest.mark.parametrize(
    ("text", "words"),
    [("1 2 3\n", "line 1: expected 8 numbers"), ("1 2 nan 0 0 0 0 0\n", "line 1: expected 8"), ("", "found none")],
)
def test_a_file_without_relations_is_refused(tmp_path: Path, text: str, words: str) -> None:
    path = tmp_path / "a.relations"
    path.write_text(text)
    with pytest.raises(AnalysisError, match=words):
        read_relations(path)
    with pytest.raises(AnalysisError, match="cannot be read"):
        read_relations(tmp_path / "none.relations")
    (tmp_path / "bad.gz").write_bytes(b"\x1f\x8b\x08" + bytes(30))
    with pytest.raises(AnalysisError, match="cannot be read"):
        read_relations(tmp_path / "bad.gz")


def test_a_relation_of_one_pose_to_itself_tells_nothing() -> None:
    path = am.analysis.Trajectory(time=np.array([0.0, 1.0]), poses=np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]]))
    found = relation_errors(path, [[0.0, 1.0, 1.0, 0.0, 0.0], [0.0, 0.02, 0.1, 0.0, 0.0]])
    assert found.position.tolist() == [0.0]
