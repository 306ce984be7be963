"""Logs of CARMEN: what their lines mean, what becomes of damaged ones, and an estimator that runs on them."""

from __future__ import annotations

import contextlib
import gzip
import math
from pathlib import Path
from typing import Any

import attrs
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import amorsim as am
from amorsim.analysis import read_log
from amorsim.analysis.logs.carmen import read_carmen
from amorsim.core.errors import AnalysisError
from amorsim.estimators import ScanMatching
from tests import building

SHARED = Path(__file__).resolve().parents[3] / "shared" / "maps" / "logs"
LOG = """# header
PARAM robot_length 0.5 host 0
ODOM 0 0 0 0 0 0 0.5 host 0.5
FLASER 3 1.0 50.0 2.5 9 9 9 0.1 0 0 0.7 host 0.7
ODOM 0.2 0 0 0 0 0 1.0 host 1.0
ODOM 5 5 5 0 0 0 81.83 host 81.83
ROBOTLASER1 0 -1.5707963 3.1415926 1.5707963 81 0.01 0 3 1 2 3 0 9 9 9 0.2 0.1 0.3 0 0 0 0 0 1.5 host 1.5
"""


def written(folder: Path, text: str, name: str = "a.log") -> Path:
    path = folder / name
    if name.endswith(".gz"):
        path.write_bytes(gzip.compress(text.encode()))
    else:
        path.write_text(text)
    return path


def robot(beams: int = 3, **changes: Any) -> am.Robot:
    laser = am.MountedSensor(sensor=am.sensors.Laser(beams=beams, fov=math.pi, range_max=8.0))
    sensors = {"encoder": building.all_sensors()["encoder"], "laser": laser}
    estimators = {"odometry": am.estimators.DeadReckoning()}
    return building.robot(name="rover", pose=am.Pose(), **{"sensors": sensors, "estimators": estimators, **changes})


@pytest.mark.parametrize("name", ["a.log", "a.clf", "a.gfs", "b.gfs.log.gz"])
def test_each_kind_of_line_is_read(tmp_path: Path, name: str) -> None:
    messages = read_carmen(written(tmp_path, LOG, name))
    assert [(one.kind, one.time) for one in messages] == [
        ("ODOM", 0.5), ("FLASER", 0.7), ("ODOM", 1.0), ("ROBOTLASER1", 1.5),
    ]  # fmt: skip
    assert messages[1].odometry.tolist() == [0.1, 0.0, 0.0]
    assert messages[1].ranges is not None
    assert messages[1].ranges.tolist() == [1.0, 50.0, 2.5]
    assert messages[1].bearings is None
    assert messages[3].odometry.tolist() == [0.2, 0.1, 0.3]
    assert messages[3].bearings == pytest.approx([-math.pi / 2, 0.0, math.pi / 2])


def test_scans_are_the_robots_and_beyond_its_range_there_is_no_return(tmp_path: Path) -> None:
    entries = list(read_log(written(tmp_path, LOG), robot()))
    assert [sorted(entry.readings) for entry in entries] == [["encoder"], ["laser"], ["encoder"], ["laser"]]
    assert entries[1].readings["laser"].tolist() == [1.0, math.inf, 2.5]
    counts = entries[2].readings["encoder"] - entries[0].readings["encoder"]
    drive = robot().drive
    per_turn = robot().sensors["encoder"].sensor.counts_per_revolution  # type: ignore[attr-defined]
    assert counts == pytest.approx([0.2 / drive.wheel_radius_left / (2 * math.pi) * per_turn] * 2)  # type: ignore[attr-defined]


def test_a_log_without_odometry_lines_has_that_of_its_scans(tmp_path: Path) -> None:
    scans = "".join(line + "\n" for line in LOG.splitlines() if not line.startswith("ODOM"))
    entries = list(read_log(written(tmp_path, scans), robot()))
    assert [sorted(entry.readings) for entry in entries] == [["encoder", "laser"]] * 2


def test_odometry_comes_back_as_it_was_driven(tmp_path: Path) -> None:
    """A simulated robot's odometry as a log: dead reckoning on the log ends where that of the robot did."""
    one = robot(controller=am.controllers.Square(side=0.8), beams=5)
    sim = am.Simulation(building.scenario(attrs.evolve(one, pose=am.Pose(x=1.0, y=1.0))))
    start, lines, path = sim.estimated_pose[0].copy(), [], []
    for step in range(200):
        x, y, heading = am.relative(start[None], sim.estimated_pose)[0].tolist()
        lines.append(f"ODOM {x!r} {y!r} {heading!r} 0 0 0 {(step + 1) * sim.dt!r} host 0")
        path.append((x, y, heading))
        sim.step()
    runner = am.EstimatorRunner(one, "odometry")
    for entry, pose in zip(read_log(written(tmp_path, "\n".join(lines)), one), path, strict=True):
        estimate = runner.update(*entry)
        np.testing.assert_allclose(estimate.pose[:2], pose[:2], atol=1e-5)
        assert abs(am.wrap_angle(estimate.pose[2] - pose[2])) < 1e-5


def test_odometry_after_a_corrected_pose_goes_on_from_there(tmp_path: Path) -> None:
    """A program has put the robot elsewhere beside the scan, with a line without a time: that is not a motion."""
    lines = [f"ODOM {x} 0 0 0 0 0 {10 + x} host 0" for x in (1, 2)]
    lines += ["FLASER 1 1.0 7 7 1.5707963267948966 2 0 0 12 host 0", "ODOM 7 7 1.5707963267948966 0 0 0 0 host 0"]
    lines += [f"ODOM 7 {y} 1.5707963267948966 0 0 0 {y + 5} host 0" for y in (8, 9, 10, 11, 12)]
    messages = read_carmen(written(tmp_path, "\n".join(lines)))
    driven = np.array([one.odometry for one in messages if one.kind == "ODOM"])
    np.testing.assert_allclose(driven, [[x, 0.0, 0.0] for x in range(1, 8)], atol=1e-9)


def test_odometry_that_waited_gets_the_time_of_the_line_before_it(tmp_path: Path) -> None:
    times = [10.0, 10.5, 10.2, 10.4, 11.0, 11.2, 11.1]
    lines = [f"ODOM {n} 0 0 0 0 0 {time} host 0" for n, time in enumerate(times)]
    lines.insert(2, "FLASER 1 1.0 0 0 0 0 0 0 10.3 host 0")
    messages = read_carmen(written(tmp_path, "\n".join(lines)))
    assert [one.time for one in messages] == [10.0, 10.3, 10.3, 10.3, 10.4, 11.0, 11.2, 11.2]
    assert [one.odometry[0] for one in messages if one.kind == "ODOM"] == list(range(7))


def test_odometry_that_came_with_a_scan_but_after_it_is_not_of_that_scan(tmp_path: Path) -> None:
    """Lines that waited together all have the time at which they were written; their order tells."""
    lines = [f"ODOM {x} 0 0 0 0 0 {time} host 0" for x, time in ((0, 9.0), (1, 10.0), (2, 10.0), (3, 9.9), (4, 11.0))]
    lines.insert(2, "FLASER 1 1.0 0 0 0 0 0 0 10.0 host 0")
    one = robot(beams=1)
    entries = list(read_log(written(tmp_path, "\n".join(lines)), one))
    assert ["laser" in entry.readings for entry in entries] == [False, True, False, False]
    assert [entry.time for entry in entries] == pytest.approx([9.0, 10.0, 10.0, 11.0], abs=1e-5)
    runner = am.EstimatorRunner(one, "odometry")
    driven = [runner.update(*entry).pose[0] for entry in entries]
    assert driven == pytest.approx([0.0, 1.0, 3.0, 4.0], abs=1e-6)


def test_two_scans_of_one_time_are_both_kept(tmp_path: Path) -> None:
    scans = [f"FLASER 1 {n} {n} 0 0 {n} 0 0 {time} host 0" for n, time in ((1, 10.0), (2, 10.5), (3, 10.5), (4, 10.4))]
    entries = list(read_log(written(tmp_path, "\n".join(scans)), robot(beams=1)))
    assert [entry.readings["laser"].item() for entry in entries] == [1.0, 2.0, 3.0, 4.0]
    assert [entry.time for entry in entries] == pytest.approx([10.0, 10.5, 10.5, 10.5], abs=1e-5)
    assert (np.diff([entry.time for entry in entries]) > 0.0).all()


def test_a_log_that_goes_far_back_is_refused(tmp_path: Path) -> None:
    lines = [f"ODOM {n} 0 0 0 0 0 {n} host 0" for n in [*range(100, 130), *range(30)]]
    with pytest.raises(AnalysisError, match="of 0 s comes after one of 129 s; expected a log in the order of time"):
        read_carmen(written(tmp_path, "\n".join(lines)))


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("ODOM 1 2", "expected 10 fields, got 3"),
        ("ODOM 1 x 3 0 0 0 1 host 1", "expected finite numbers for the pose"),
        ("ODOM 1 2 3 0 0 0 nan host 1", "expected finite numbers for the time"),
        ("FLASER many 1 2", "expected the number of ranges"),
        ("FLASER 180 1 2 3", "expected 191 fields, got 5"),
        ("ROBOTLASER1 0 0 1", "expected the number of ranges"),
        ("ROBOTLASER1 0 0 1 1 1 1 0 1 2.0", "expected the number of remissions"),
    ],
)
def test_a_damaged_line_is_named_or_left_out(tmp_path: Path, line: str, words: str) -> None:
    path = written(tmp_path, f"{LOG}{line}\n")
    with pytest.raises(AnalysisError, match=rf"a\.log, line 8: {line.split()[0]}: {words}"):
        read_carmen(path)
    noted: list[str] = []
    assert len(list(read_log(path, robot(), damaged=noted.append))) == 4
    assert len(noted) == 1
    assert words in noted[0]


@given(
    st.lists(
        st.sampled_from(["ODOM", "FLASER", "ROBOTLASER1", "3", "0", "1.5", "nan", "x", "\n", "-1", "9" * 400]),
        max_size=60,
    )
)
def test_any_words_are_read_or_refused(tmp_path_factory: pytest.TempPathFactory, words: list[str]) -> None:
    path = written(tmp_path_factory.mktemp("log"), " ".join(words))
    noted: list[str] = []
    with contextlib.suppress(AnalysisError):
        assert read_carmen(path, noted.append)
    assert all(f"{path}, line " in one for one in noted)


@pytest.mark.parametrize(
    ("given_robot", "words"),
    [
        (lambda: robot(beams=5), "a scan of 3 beams, and the robot's laser has 5"),
        (lambda: robot(sensors={}, estimators={}), "the robot has none"),
    ],
)
def test_a_robot_that_does_not_fit_is_refused(tmp_path: Path, given_robot: Any, words: str) -> None:
    with pytest.raises(AnalysisError, match=words):
        list(read_log(written(tmp_path, LOG), given_robot()))


def test_a_scan_with_other_angles_is_refused(tmp_path: Path) -> None:
    with pytest.raises(AnalysisError, match=r"from -57\.30 to 57\.30 degrees, and those of the robot's laser"):
        list(read_log(written(tmp_path, LOG.replace("-1.5707963 3.1415926 1.5707963", "-1 2 1")), robot()))


def test_what_is_no_log_is_refused(tmp_path: Path) -> None:
    with pytest.raises(AnalysisError, match="expected a log of CARMEN, with lines of ODOM, FLASER, ROBOTLASER1"):
        read_carmen(written(tmp_path, "hello\n"))
    with pytest.raises(AnalysisError, match="No such file"):
        read_carmen(tmp_path / "none.log")
    (tmp_path / "bad.log.gz").write_bytes(b"\x1f\x8bno")
    with pytest.raises(AnalysisError, match="cannot be read"):
        read_carmen(tmp_path / "bad.log.gz")
    with pytest.raises(AnalysisError, match="has no topics and no replicas"):
        read_log(written(tmp_path, LOG), robot(), command="/cmd_vel")


@pytest.mark.skipif(not SHARED.exists(), reason="there are no shared logs")
@pytest.mark.parametrize(("name", "scans"), [("intel.gfs.log.gz", 910), ("aces-corrected.log.gz", 440)])
def test_real_logs_are_read_whole(name: str, scans: int) -> None:
    messages = read_carmen(SHARED / name)
    assert sum(one.ranges is not None for one in messages) == scans
    times = [one.time for one in messages]
    assert times == sorted(times)
    odometry = np.array([one.odometry for one in messages if one.kind == "ODOM"])
    assert np.hypot(*np.diff(odometry[:, :2], axis=0).T).max() < 1.0  # it drives, and does not jump


@pytest.mark.long
@pytest.mark.skipif(not SHARED.exists(), reason="there are no shared logs")
def test_few_scans_of_a_real_log_are_matched_wrongly() -> None:
    """The wheels alone are off by more than 0.3 m or 5 degrees in 165 of the 909 increments."""
    with_laser = with_real_laser()
    runner = am.EstimatorRunner(with_laser, ScanMatching(wheel_variance=2e-3, range_std=0.02))
    found = []
    for entry in read_log(SHARED / "intel.gfs.log.gz", with_laser):
        estimate = runner.update(*entry)
        if "laser" in entry[1]:
            found.append(estimate.pose)
    corrected = corrected_poses(SHARED / "intel.gfs.log.gz")
    off = am.relative(np.array(found[:-1]), np.array(found[1:])) - am.relative(corrected[:-1], corrected[1:])
    wrong = (np.hypot(off[:, 0], off[:, 1]) > 0.3) | (np.abs(am.wrap_angle(off[:, 2])) > math.radians(5.0))
    assert len(found) == 910
    assert not wrong.any()


@pytest.mark.long
@pytest.mark.skipif(not SHARED.exists(), reason="there are no shared logs")
def test_a_real_log_becomes_a_graph_about_as_right_as_the_corrected_path() -> None:
    """Mean errors of the published relations: 3.4 m by the wheels, 0.036 m in a path that a particle filter made."""
    found = am.analysis.slam(SHARED / "intel.gfs.log.gz")
    relations = am.analysis.read_relations(SHARED / "intel.relations.gz")
    relations[:, :2] -= am.analysis.clock_offset(relations, found.path.time)
    off = am.analysis.relation_errors(found.path, relations, most_apart=0.006)
    wheels = am.analysis.relation_errors(found.odometry, relations, most_apart=0.006)
    assert len(off.position) >= 100
    assert np.median(off.position) < 0.02  # 0.013 as measured
    assert off.position.mean() < 0.03  # 0.019
    assert np.degrees(np.abs(off.heading).mean()) < 0.6  # 0.54
    assert wheels.position.mean() > 2.0


@pytest.mark.nightly
@pytest.mark.skipif(not SHARED.exists(), reason="there are no shared logs")
def test_the_loops_of_a_real_log_with_long_corridors_close() -> None:
    """Far from the corrected path: the wheels by 4.6 m in the mean, scan matching by 1.2 m."""
    log = SHARED / "aces-corrected.log.gz"
    found = am.analysis.slam(log)
    corrected = am.analysis.Trajectory(time=found.path.time, poses=corrected_poses(log))
    off = am.analysis.ape(corrected, found.path, align="umeyama")
    assert off.position.mean() < 0.25  # 0.12 as measured


def with_real_laser() -> Any:
    """A robot with the laser of that log."""
    laser = am.MountedSensor(sensor=am.sensors.Laser(beams=180, fov=math.radians(179.0), range_max=50.0))
    model = am.load_robot("pioneer2dx", pose=am.Pose())
    return attrs.evolve(model, sensors={"encoder": model.sensors["encoder"], "laser": laser})


def corrected_poses(path: Path) -> Any:
    """The poses (n, 3) that FLASER lines have, which a particle filter has corrected."""
    with gzip.open(path, "rt") as file:
        lines = [line.split() for line in file if line.startswith("FLASER")]
    return np.array([[float(word) for word in words[2 + int(words[1]) :][:3]] for words in lines])


@pytest.mark.parametrize(("beams", "fov"), [(180, 179.0), (181, 180.0), (361, 180.0), (360, 179.5)])
def test_a_log_without_a_robot_has_a_laser_of_its_beams(tmp_path: Path, beams: int, fov: float) -> None:
    scan = " ".join(["2.0"] * beams)
    log = written(tmp_path, f"ODOM 0 0 0 0 0 0 1.0 host 0\nFLASER {beams} {scan} 0 0 0 0 0 0 1.1 host 0")
    laser = am.analysis.robot_of(log).sensors["laser"].sensor
    assert isinstance(laser, am.sensors.Laser)
    assert laser.beams == beams
    assert math.degrees(laser.fov) == pytest.approx(fov)
    assert len(am.analysis.slam(log, progress=False).path) == 1


def test_a_scan_with_angles_gives_them_to_the_laser(tmp_path: Path) -> None:
    line = "ROBOTLASER1 0 -1.0 2.0 0.5 80 0.01 0 5 1 2 3 4 5 0 0 0 0 0 0 0 0 0 0 0 0 1.0 host 1"
    laser = am.analysis.robot_of(written(tmp_path, line)).sensors["laser"].sensor
    assert isinstance(laser, am.sensors.Laser)
    assert laser.beams == 5
    assert laser.fov == pytest.approx(2.0)
    assert am.analysis.robot_of(written(tmp_path, "ODOM 0 0 0 0 0 0 1.0 host 0", "b.log")).sensors["laser"] is not None
