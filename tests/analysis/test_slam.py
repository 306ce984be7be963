"""A log becomes a path, a map and a graph: against the simulation that made the log, and by its files."""

from __future__ import annotations

import math
from pathlib import Path

import attrs
import numpy as np
import pytest

import amorsim as am
from amorsim.algorithms.pose_graph import read_g2o
from amorsim.analysis import clock_offset, read_relations, relation_errors, slam
from amorsim.core.errors import AnalysisError
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


def robot_of(folder: Path) -> am.Robot:
    return am.load(folder / "scenario.toml").robots[0]


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
