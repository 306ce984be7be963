"""``amorsim slam``: what it leaves, prints and refuses."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

import amorsim as am
from tests import building
from tests.cli.conftest import Command


@pytest.fixture
def log(tmp_path: Path) -> Path:
    """A log of CARMEN: a robot with a laser of 180 beams drives through a room for 12 s."""
    laser = am.MountedSensor(sensor=am.load_robot("pioneer2dx-lms200").sensors["laser"].sensor)
    robot = building.robot(
        name="rover",
        pose=am.Pose(x=1.0, y=1.0),
        controller=am.controllers.Square(side=1.5),
        sensors={"encoder": building.all_sensors()["encoder"], "laser": laser},
    )
    sim = am.Simulation(building.scenario(robot))
    start, lines = sim.estimated_pose[0].copy(), []
    for step in range(120):
        sim.step()
        at, time = (
            " ".join(map(repr, am.relative(start[None], sim.estimated_pose)[0].tolist())),
            repr(step * sim.dt + 0.04 * math.sin(step**2)),
        )
        lines.append(f"ODOM {at} 0 0 0 {time} host 0")
        ranges = sim.frames()[0].readings["laser"][1].measured[0].clip(max=81.9)
        lines.append(f"FLASER 180 {' '.join(map(repr, ranges.tolist()))} {at} {at} {time} host 0")
    path = tmp_path / "lab.log"
    path.write_text("\n".join(lines) + "\n")
    return path


@pytest.mark.long
def test_a_log_becomes_a_folder_with_path_map_graph_and_report(amorsim: Command, log: Path, tmp_path: Path) -> None:
    result = amorsim("slam", log, "--out", "lab")
    assert result.status == 0, result.err
    assert "scans: 120 of 180 beams, from 0 to 11." in result.out
    assert "estimator: graph_slam of pioneer2dx-lms200" in result.out
    names = {path.name for path in (tmp_path / "lab").iterdir()}
    assert {
        "path.tum", "online.tum", "odometry.tum", "map.yaml", "map.pgm", "graph.g2o", "report.html",
    } < names  # fmt: skip
    assert "amorsim replay lab" in result.out
    page = (tmp_path / "lab" / "report.html").read_text()
    assert page.count("data:image/png") >= 2
    assert am.load_map(tmp_path / "lab" / "map.yaml").shape[0] > 20
    again = amorsim("slam", log, "--out", "lab")
    assert again.status == 2
    assert "holds files already" in again.err


@pytest.mark.long
def test_a_folder_without_truth_is_played_and_refused_where_truth_is_needed(
    amorsim: Command, log: Path, tmp_path: Path
) -> None:
    assert amorsim("slam", log, "--out", "lab").status == 0
    film = amorsim("replay", "lab", "--gif", "lab.gif", "--gif-size", "200")
    assert film.status == 0, film.err
    assert (tmp_path / "lab.gif").stat().st_size > 1000
    for words in (["reproduce", "lab"], ["plot", "lab"], ["report", "lab"], ["slam", "lab"]):
        result = amorsim(*words)
        assert result.status == 2, words
        assert "was made of the log lab.log by amorsim slam, so it has no true poses" in result.err


@pytest.mark.long
def test_a_robot_without_a_graph_gets_one_and_a_log_without_motion_is_told(
    amorsim: Command, log: Path, tmp_path: Path
) -> None:
    (tmp_path / "mine.toml").write_text(
        'format = 1\ndescription = "mine"\nmodel = "pioneer2dx"\n[sensors.laser]\nbeams = 180\nfov_deg = 179.0\n'
    )
    result = amorsim("slam", log, "--robot", "mine.toml", "--out", "lab")
    assert result.status == 0, result.err
    assert "estimator: graph_slam of " in result.out
    assert "never moved" not in result.err
    lines = [line for line in log.read_text().splitlines() if line.startswith("FLASER")]
    still = [" ".join([*line.split()[:182], *["0"] * 6, *line.split()[188:]]) for line in lines]
    (tmp_path / "still.log").write_text("\n".join(still) + "\n")
    assert "the robot never moved: the path is by its scans alone" in amorsim("slam", "still.log").err


@pytest.mark.long
def test_errors_in_known_relations_are_printed(amorsim: Command, log: Path, tmp_path: Path) -> None:
    path = am.analysis.slam(log, progress=False).path
    rows = []
    for i in range(30):
        x, y, heading = am.relative(path.poses[i : i + 1], path.poses[i + 9 : i + 10])[0].tolist()
        rows.append(f"{path.time[i] + 5e8:.6f} {path.time[i + 9] + 5e8:.6f} {x} {y} 0 0 0 {heading}")
    (tmp_path / "lab.relations").write_text("\n".join(rows) + "\n")
    result = amorsim("slam", log, "--out", "lab", "--relations", "lab.relations")
    assert result.status == 0, result.err
    assert "as known at the end" in result.out
    assert " 0.000 " in next(line for line in result.out.splitlines() if line.startswith("as known at the end"))


@pytest.mark.long
def test_relations_of_another_log_cost_nothing_that_was_computed(amorsim: Command, log: Path, tmp_path: Path) -> None:
    (tmp_path / "other.relations").write_text("1e9 1000000002.0 0.5 0 0 0 0 0\n")
    result = amorsim("slam", log, "--out", "lab", "--relations", "other.relations")
    assert result.status == 0
    assert "has no poses at the times of these relations" in result.err
    assert (tmp_path / "lab" / "report.html").exists()


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("none.log",), "none.log: cannot be read: No such file or directory"),
        (("lab.log", "--topic", "laser"), "--topic: expected SENSOR=TOPIC"),
        (
            ("lab.log", "--robot", "pioneer2dx"),
            "180 beams, and the robot's laser has 181; give it as many, as",
        ),
        (
            ("lab.log", "--estimator", "slam"),
            "has no estimator 'slam'; it has: 'dead_reckoning', 'graph_slam', 'scan_matching'",
        ),
        (("lab.log", "--relations", "none"), "none: cannot be read: No such file or directory"),
        (("lab.log", "--resolution", "-1"), "--resolution: expected a number of metres > 0, got -1"),
    ],
)
def test_what_it_cannot_do_is_told_in_words(
    amorsim: Command, log: Path, tmp_path: Path, arguments: tuple[str, ...], words: str
) -> None:
    result = amorsim("slam", *arguments)
    assert result.status == 2
    assert words in result.err
    assert not (tmp_path / "amorsim-runs").exists()
