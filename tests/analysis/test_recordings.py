"""Bags and MCAP files: written from runs, read by their own libraries and by ours."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

import attrs
import numpy as np
import pytest

import amorsim as am
from amorsim.analysis import RunFiles, ape, export_run, read_bag, read_log, read_mcap, run_trajectories
from amorsim.analysis.logs.message_values import command_of, reading_of
from amorsim.simulation.fleet.grouping import reading_size

HALF_DIGIT = 5.1e-7  # files of a run have six digits
SINGLE = 1e-6  # [m] ROS's scans have single precision


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("recordings") / "run"
    changes = [f"robots.rover.sensors.{name}" for name in ("laser.beams=5", "laser.rate=5.0", "laser.latency=0.1")]
    changes += ["robots.rover.sensors.gyro.use='gyro'", "robots.rover.sensors.compass.use='compass'"]
    am.run(am.load("demo", changes), folder, duration=1.0, replicas=2)
    return folder


@pytest.fixture(scope="module")
def bag(run: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    pytest.importorskip("rosbags")
    (path,) = export_run(run, "rosbag", tmp_path_factory.mktemp("bags"))
    return path


@pytest.fixture(scope="module")
def mcap(run: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    pytest.importorskip("mcap")
    (path,) = export_run(run, "mcap", tmp_path_factory.mktemp("mcaps"))
    return path


def recording(kind: str, request: pytest.FixtureRequest) -> Path:
    found: Path = request.getfixturevalue(kind)
    return found


def test_a_bag_is_read_back_by_its_library(run: Path, bag: Path) -> None:
    from rosbags.highlevel import AnyReader

    files = RunFiles(run)
    found: dict[str, list[tuple[int, Any]]] = {}
    with AnyReader([bag]) as reader:
        for connection, time, data in reader.messages():
            found.setdefault(connection.topic, []).append((time, reader.deserialize(data, connection.msgtype)))
    poses, scans = files.table("poses", replica=0), files.table("sensors/laser", replica=0)
    assert [time for time, _ in found["/clock"]] == [round(1e9 * time) for time in poses["time"]]
    assert all(time == each.clock.sec * 10**9 + each.clock.nanosec for time, each in found["/clock"])
    truth = [each.pose.pose.position.x for _, each in found["/rover/ground_truth"]]
    assert truth == poses["true_x"].tolist()
    assert [each.pose.pose.position.y for _, each in found["/rover/odom"]] == poses["estimated_y"].tolist()
    forward = files.table("velocities", replica=0)["estimated_forward"]
    assert [each.twist.twist.linear.x for _, each in found["/rover/odom"]] == forward.tolist()
    # Received when it arrived, stamped when it was measured.
    assert [time for time, _ in found["/rover/laser"]] == [round(1e9 * time) for time in scans["time"]]
    stamps = [each.header.stamp.sec * 10**9 + each.header.stamp.nanosec for _, each in found["/rover/laser"]]
    assert stamps == [round(1e9 * time) for time in scans["stamp"]]
    assert stamps[-1] < found["/rover/laser"][-1][0]
    scan = found["/rover/laser"][0][1]
    assert (scan.angle_min, len(scan.ranges)) == (pytest.approx(-np.pi / 2), 5)
    assert scan.ranges[2] == pytest.approx(scans["measured_2"][0])
    frames = {(each.header.frame_id, each.child_frame_id) for _, message in found["/tf"] for each in message.transforms}
    assert frames == {("rover/odom", "rover/base_link"), ("map", "rover/true_base_link")}
    fixed = {each.child_frame_id for each in found["/tf_static"][0][1].transforms}
    assert {"rover/odom", "rover/laser"} <= fixed
    covariance = found["/rover/estimates/dead_reckoning"][-1][1].pose.covariance.reshape(6, 6)
    assert covariance[5, 5] == files.table("estimates/dead_reckoning", replica=0)["hh"][-1]
    assert np.array_equal(covariance, covariance.T)


@pytest.mark.parametrize("kind", ["bag", "mcap"])
def test_an_estimator_runs_on_a_recorded_run(kind: str, run: Path, request: pytest.FixtureRequest) -> None:
    path, files = recording(kind, request), RunFiles(run)
    robot = files.scenario.robots[0]
    runner = am.EstimatorRunner(robot, "dead_reckoning", dt=files.scenario.dt)
    log = list(read_log(path, robot))
    found = np.array([runner.update(*entry).pose for entry in log])
    _, estimate = run_trajectories(run, replica=0, estimator="dead_reckoning")
    assert [entry.time for entry in log] == pytest.approx(estimate.time.tolist())
    assert np.abs(found - estimate.poses).max() < HALF_DIGIT
    scans = [entry for entry in log if "laser" in entry.readings]
    read = files.table("sensors/laser", replica=0)
    ranges = np.array([[read[f"measured_{i}"][line] for i in range(5)] for line in range(len(scans))])
    assert np.allclose([entry.readings["laser"] for entry in scans], ranges, rtol=0.0, atol=SINGLE)
    assert [entry.ages["laser"] for entry in scans] == pytest.approx((read["time"] - read["stamp"]).tolist())
    for name in ("gyro", "compass"):
        read = files.table(f"sensors/{name}", replica=0)
        assert [entry.readings[name][0] for entry in log] == pytest.approx(read["measured_0"].tolist(), abs=1e-12)
    table = files.table("commands", replica=0)
    # Of the step that ends with the entry; at the start none had been given.
    assert log[0].command is None
    assert [entry.command[0] for entry in log[1:] if entry.command is not None] == table["left"][1:].tolist()


@pytest.mark.parametrize(("kind", "topic"), [("bag", "/rover/ground_truth"), ("mcap", "/rover/true_pose")])
def test_trajectories_are_read(kind: str, topic: str, run: Path, request: pytest.FixtureRequest) -> None:
    path = recording(kind, request)
    read = read_bag if kind == "bag" else read_mcap
    true, estimated = run_trajectories(run, replica=0)
    assert ape(true, read(path, topic)).statistics.max < 1e-12
    if kind == "bag":
        assert ape(true, read_bag(path, "/tf", frame="rover/true_base_link")).statistics.max < 1e-12
        assert ape(estimated, read_bag(path, "/rover/estimates/dead_reckoning")).statistics.max < 1e-12
        assert len(read_bag(next(path.glob("*.mcap")), topic)) == len(true)  # its file alone, too
    else:
        assert ape(true, read_mcap(path, "/tf/rover", frame="rover")).statistics.max < 1e-12


def test_a_bag_is_compressed_within_its_file(bag: Path) -> None:
    """By chunks of the MCAP file, which readers of MCAP open; ROS is told of no compression of its own kind."""
    make_reader = pytest.importorskip("mcap.reader").make_reader
    (path,) = bag.glob("*.mcap")
    with path.open("rb") as file:
        chunks = make_reader(file).get_summary().chunk_indexes
    assert {chunk.compression for chunk in chunks} == {"zstd"}
    assert sum(chunk.compressed_size for chunk in chunks) < 0.3 * sum(chunk.uncompressed_size for chunk in chunks)
    assert 'compression_mode: ""' in (bag / "metadata.yaml").read_text().replace("''", '""')


def test_a_bag_replaces_a_bag_and_nothing_else(run: Path, bag: Path, tmp_path: Path) -> None:
    export_run(run, "rosbag", bag.parent)
    assert len(read_bag(bag, "/rover/odom")) == 11
    (tmp_path / bag.name).mkdir()
    (tmp_path / bag.name / "thesis.tex").touch()
    with pytest.raises(am.RunError, match="exists and is not a bag"):
        export_run(run, "rosbag", tmp_path)
    assert [path.name for path in tmp_path.iterdir()] == [bag.name]


def test_mistakes_are_explained(run: Path, bag: Path, mcap: Path, tmp_path: Path) -> None:
    robot = RunFiles(run).scenario.robots[0]
    with pytest.raises(am.AnalysisError, match=r"several topics have poses; say which with topic=.*/rover/odom"):
        read_bag(bag)
    with pytest.raises(am.AnalysisError, match=r"there is no topic '/rover/odo'.*Did you mean '/rover/odom'"):
        read_bag(bag, "/rover/odo")
    with pytest.raises(am.AnalysisError, match=r"messages on /rover/laser, foxglove.LaserScan, have no pose"):
        read_mcap(mcap, "/rover/laser")
    with pytest.raises(am.AnalysisError, match=r"no poses into the frame 'camera' on the topic /tf"):
        read_bag(bag, "/tf", frame="camera")
    with pytest.raises(am.AnalysisError, match="has no sensor 'lidar'; known sensors: "):
        read_log(bag, robot, topics={"lidar": "/scan"})
    with pytest.raises(am.AnalysisError, match="there is no topic '/scan'; it has: /clock"):
        list(read_log(bag, robot, topics={"laser": "/scan"}))
    with pytest.raises(am.AnalysisError, match="'nav_msgs/Odometry' holds no reading of a Laser"):
        list(read_log(bag, robot, topics={"laser": "/rover/odom"}))
    with pytest.raises(am.AnalysisError, match="'sensor_msgs/JointState' holds no command"):
        list(read_log(bag, robot, command="/rover/encoder"))
    damaged = tmp_path / "damaged.mcap"
    damaged.write_bytes(mcap.read_bytes()[:500])
    (tmp_path / "empty.mcap").touch()
    (tmp_path / "folder").mkdir()
    for path, problem in (
        (damaged, "cannot be read as a recording"),
        (tmp_path / "none.mcap", "there is no such file or folder"),
        (tmp_path / "none", "there is no such file or folder"),
        (tmp_path / "empty.mcap", "the file is empty"),
    ):
        with pytest.raises(am.AnalysisError, match=problem):
            list(read_log(path, robot))
        with pytest.raises(am.AnalysisError, match=problem):
            (read_mcap if path.suffix else read_bag)(path)
    # Each names the folders that it reads.
    with pytest.raises(am.AnalysisError, match=r"without a recording; expected .* run\.json, or .* metadata\.yaml"):
        list(read_log(tmp_path / "folder", robot))
    with pytest.raises(am.AnalysisError, match=r"without a recording; expected that of a rosbag, with metadata\.yaml"):
        read_bag(tmp_path / "folder")
    text = tmp_path / "README.md"
    text.write_text("a text")
    with pytest.raises(am.AnalysisError, match=r"README.md: is not a recording that can be read: expected .* \.mcap"):
        list(read_log(text, robot))


def test_what_is_missing_is_named(run: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("rosbags.rosbag2", "rosbags.highlevel", "mcap.reader"):
        monkeypatch.setitem(sys.modules, name, None)
    with pytest.raises(am.AnalysisError, match=r"pip install \"amorsim\[rosbag\]\""):
        export_run(run, "rosbag", tmp_path)
    (tmp_path / "metadata.yaml").touch()
    with pytest.raises(am.AnalysisError, match=r"pip install \"amorsim\[rosbag\]\""):
        read_bag(tmp_path)
    (tmp_path / "x.mcap").write_bytes(b"x")
    with pytest.raises(am.AnalysisError, match=r"pip install \"amorsim\[mcap\]\""):
        read_mcap(tmp_path / "x.mcap")


class Part:
    """Stands for a message or a part of one."""

    def __init__(self, **parts: Any) -> None:
        self.__dict__ |= parts


def test_messages_of_real_robots_become_readings_and_commands() -> None:
    robot = am.load("demo").robots[0]
    encoder = am.sensors.Encoder(counts_per_revolution=1000.0)
    names = [joint.name for joint in robot.drive.joints]
    joints = Part(name=["arm", *reversed(names)], position=np.array([9.0, 2.0 * np.pi, -np.pi]))
    assert reading_of("sensor_msgs/JointState", joints, encoder, robot, "/j").tolist() == [-500.0, 1000.0]
    laser = am.sensors.Laser(beams=3)
    scan = Part(angle_min=1.5, angle_increment=-1.5, range_min=0.1, range_max=8.0)
    for given, wanted in (([1.0, np.inf, 3.0], [3.0, np.inf, 1.0]), ([-np.inf, 9.0, 0.0], [np.nan, np.inf, -np.inf])):
        scan.ranges = np.array(given, np.float32)
        np.testing.assert_array_equal(reading_of("sensor_msgs/LaserScan", scan, laser, robot, "/s"), wanted)
    nothing = Part(linear=Part(x=0.0, y=0.0, z=0.0), angular=Part(x=0.0, y=0.0, z=1.0))
    left, right = command_of("geometry_msgs/Twist", nothing, robot, "/cmd_vel")
    assert left == pytest.approx(-right)
    assert right > 0.0
    assert command_of("geometry_msgs/TwistStamped", Part(twist=nothing), robot, "/cmd_vel").tolist() == [left, right]


def test_a_scan_is_read_by_its_angles() -> None:
    """The driver of this laser begins ahead; our laser begins behind."""
    robot = am.load_robot("turtlebot3_burger")
    laser = robot.sensors["laser"].sensor
    ranges = np.arange(360.0) + 1.0
    step = 2.0 * np.pi / 360.0
    reach = {"range_min": 0.0, "range_max": 1e3}
    scan = Part(angle_min=0.0, angle_max=2.0 * np.pi, angle_increment=step, ranges=ranges, **reach)
    found = reading_of("sensor_msgs/LaserScan", scan, laser, robot, "/scan")
    assert (found[180], found[270], found[0], found[90]) == (1.0, 91.0, 181.0, 271.0)  # ahead, left, behind, right
    clockwise = Part(angle_min=0.0, angle_increment=-step, ranges=ranges, **reach)
    found = reading_of("sensor_msgs/LaserScan", clockwise, laser, robot, "/scan")
    assert (found[180], found[270], found[0], found[90]) == (1.0, 271.0, 181.0, 91.0)
    narrow = Part(angle_min=-1.0, angle_increment=2.0 / 359.0, ranges=ranges, **reach)
    with pytest.raises(am.AnalysisError, match=r"/scan: .* -180\.0 to 179\.0 degrees, got -57\.3 to"):
        reading_of("sensor_msgs/LaserScan", narrow, laser, robot, "/scan")


@pytest.mark.parametrize("kind", ["run", "rosbag", "mcap"])
def test_each_robot_of_a_mixed_fleet_has_its_own_readings_and_commands(kind: str, tmp_path: Path) -> None:
    """Files of a run have the columns of all robots: of two wheels and of three, of few beams and of many."""
    pytest.importorskip({"run": "numpy", "rosbag": "rosbags", "mcap": "mcap"}[kind])
    rover = am.load_robot("pioneer2dx", name="rover", pose=am.Pose(x=5.0, y=5.0), controller=am.controllers.Wander())
    ahead = am.controllers.Pursuit(waypoints=((25.0, 12.0),))
    car = am.load_robot("car", name="car", pose=am.Pose(x=18.0, y=10.0), controller=ahead)
    few = attrs.evolve(rover.sensors["laser"], sensor=am.sensors.Laser(beams=5))
    rover = attrs.evolve(rover, sensors={**rover.sensors, "laser": few})
    world = am.worlds.forest(seed=3, size=(30.0, 20.0), density=0.02)
    scenario = am.Scenario(map=world, robots=[car, rover], dt=0.1)
    am.run(scenario, tmp_path / "run", duration=1.0)
    files = RunFiles(tmp_path / "run")
    path = files.folder if kind == "run" else export_run(files.folder, kind, tmp_path / "export")[0]
    for robot in files.scenario.robots:
        log = list(read_log(path, robot))
        runner = am.EstimatorRunner(robot, "dead_reckoning", dt=files.scenario.dt)
        found = np.array([runner.update(*entry).pose for entry in log])
        _, estimate = run_trajectories(files, robot=robot.name, estimator="dead_reckoning")
        assert np.abs(found - estimate.poses).max() < 2.0 * SINGLE
        beams = {len(entry.readings["laser"]) for entry in log if "laser" in entry.readings}
        assert beams == {reading_size(robot, "laser")}
        assert all(entry.command is not None and np.isfinite(entry.command).all() for entry in log[1:])


@pytest.mark.parametrize("kind", ["rosbag", "mcap"])
def test_late_and_lost_readings_are_so_in_a_recording(kind: str, tmp_path: Path) -> None:
    """A compass and a GPS are late; they and a sonar lose readings, which are infinite then."""
    pytest.importorskip({"rosbag": "rosbags", "mcap": "mcap"}[kind])
    lost = "noise=[{ use = 'dropout', probability = 0.3 }]"
    changes = [f"sonar.{lost}", "compass.use='compass'", "compass.latency=0.2", f"compass.{lost}"]
    changes += ["gps.use='gps'", "gps.rate=5.0", "gps.latency=0.1", f"gps.{lost}"]
    scenario = am.load("demo", [f"robots.rover.sensors.{each}" for each in changes])
    am.run(scenario, tmp_path / "run", duration=2.0)
    robot = scenario.robots[0]
    written = list(read_log(tmp_path / "run", robot))
    read = list(read_log(export_run(tmp_path / "run", kind, tmp_path / "export")[0], robot))
    assert len(read) == len(written)
    infinite = set()
    for was, found in zip(written, read, strict=True):
        for name in {"compass", "gps", "sonar"} & set(was.readings):
            there = np.isfinite(was.readings[name])
            infinite |= set() if there.all() else {name}
            assert found.ages[name] == pytest.approx(was.ages[name], abs=1e-8)
            assert found.readings[name][there] == pytest.approx(was.readings[name][there], abs=1e-12)
            if name == "compass":  # in a quaternion nothing is infinite
                assert not np.isfinite(found.readings[name][~there]).any()
            else:
                assert np.array_equal(found.readings[name], was.readings[name])
    assert infinite == {"compass", "gps", "sonar"}


STAMP = {"sec": 1, "nsec": 0}
TURNED = {"x": 0.0, "y": 0.0, "z": 0.0, "w": 1.0}


def written(path: Path, kind: str, topic: str, *messages: bytes) -> Path:
    """An MCAP file of these messages, whatever they hold."""
    from mcap.writer import Writer

    with path.open("wb") as stream:
        writer = Writer(stream)
        writer.start(profile="", library="test")
        schema = writer.register_schema(name=kind, encoding="jsonschema", data=b"{}")
        channel = writer.register_channel(topic=topic, message_encoding="json", schema_id=schema)
        for time, data in enumerate(messages):
            writer.add_message(channel, log_time=time * 10**8, data=data, publish_time=time * 10**8)
        writer.finish()
    return path


@pytest.mark.parametrize(
    ("content", "problem"),
    [
        (b"[]", "it has no values"),
        (b"3", "it has no values"),
        (b"{}", "it has no values"),
        (b'{"values": 3}', "expected a list of numbers, .* under values, got 3"),
        (b'{"values": ["x"]}', "expected a list of numbers, .* under values"),
        (b'{"values": [[1.0]]}', "expected a list of numbers, .* under values"),
        (b'{"values": [true]}', "expected a list of numbers, .* under values"),
        (b'{"values": [], "timestamp": 5}', r"it has no timestamp\.sec"),
        (b'{"values": [], "timestamp": {"sec": "x", "nsec": 0}}', r"expected a whole number under timestamp\.sec"),
        (b'{"values": [], "timestamp": {"sec": 1e300, "nsec": 0}}', r"expected a whole number under timestamp\.sec"),
        (
            b'{"values": [], "timestamp": {"sec": 1' + b"0" * 400 + b"}}",
            r"expected a whole number under timestamp\.sec",
        ),
        (b"{", "cannot be read as a recording"),
        (b"[" * 100_000, "nested too deeply"),
        (b"\xff", "cannot be read as a recording"),
    ],
)
def test_a_message_of_another_shape_is_named(tmp_path: Path, content: bytes, problem: str) -> None:
    pytest.importorskip("mcap")
    robot = am.load("demo").robots[0]
    path = written(tmp_path / "odd.mcap", "amorsim.Values", "/rover/gyro", content)
    with pytest.raises(am.AnalysisError, match=problem) as raised:
        list(read_log(path, robot, topics={"encoder": "/rover/gyro"}))
    assert "odd.mcap" in str(raised.value)


@pytest.mark.parametrize(
    ("pose", "problem"),
    [
        ({}, r"it has no pose\.position"),
        ({"position": {"x": 0.0}, "orientation": TURNED}, r"it has no pose\.position\.y"),
        ({"position": {"x": 0.0, "y": None}, "orientation": TURNED}, r"expected a number under pose\.position\.y"),
        ({"position": {"x": 0.0, "y": 0.0}, "orientation": "x"}, r"it has no pose\.orientation\.x"),
    ],
)
def test_a_pose_of_another_shape_is_named(tmp_path: Path, pose: Any, problem: str) -> None:
    pytest.importorskip("mcap")
    content = json.dumps({"timestamp": STAMP, "pose": pose}).encode()
    path = written(tmp_path / "odd.mcap", "foxglove.PoseInFrame", "/pose", content)
    with pytest.raises(am.AnalysisError, match=problem):
        read_mcap(path)


def test_numbers_of_400_digits_are_infinite_and_not_an_error(tmp_path: Path) -> None:
    pytest.importorskip("mcap")
    content = b'{"values": [1' + b"0" * 400 + b', null, "Infinity", 2]}'
    path = written(tmp_path / "odd.mcap", "amorsim.Values", "/a", content)
    (entry,) = read_log(path, am.load("demo").robots[0], topics={"encoder": "/a"})
    assert np.array_equal(entry.readings["encoder"], [np.inf, np.nan, np.inf, 2.0], equal_nan=True)
