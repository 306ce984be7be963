"""Recordings as real robots leave them: odometry and scans by their own names, which arrive late."""

import itertools
import math
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import attrs
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import amorsim as am
from amorsim.analysis import read_log, slam
from amorsim.analysis.logs.frames import Frames
from amorsim.analysis.logs.run_log import LogEntry
from amorsim.analysis.logs.scan_geometry import ScanGeometry, laser_with
from amorsim.analysis.logs.wheels_at_scans import with_wheels_at_scans
from amorsim.sensors import Laser
from tests import building

LATE = 0.04  # [s] after they were measured scans arrive
BEAMS = 360
MOUNT = am.Mount(x=0.12, y=-0.05, heading=math.pi / 2.0)


def driven() -> am.Simulation:
    """A robot with a laser all around in a room, which drives two rounds."""
    laser = am.MountedSensor(sensor=Laser(beams=BEAMS, fov=2.0 * math.pi, range_max=12.0), rate=5.0, mount=MOUNT)
    robot = building.robot(
        pose=am.Pose(x=1.5, y=1.5),
        controller=am.controllers.Square(side=2.0, speed=0.5),
        sensors={"encoder": building.all_sensors()["encoder"], "laser": laser},
        errors={"drive.wheel_radius_left": am.Deviation(scale=1.01)},
    )
    return am.Simulation(building.scenario(robot), seed=2)


@pytest.fixture(scope="module")
def bag(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Any]:
    """A rosbag of ``/odom``, ``/scan`` and ``/battery``, and the true path in the frame of its start."""
    from rosbags.rosbag2 import Writer
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS2_HUMBLE)

    def make(name: str, *values: Any) -> Any:
        return store.types[name.replace("/", "/msg/")](*values)

    def header(time: float, frame: str) -> Any:
        stamp = make("builtin_interfaces/Time", int(time), int(time % 1.0 * 1e9))
        return make("std_msgs/Header", stamp, frame)

    def transform(parent: str, child: str, x: float, y: float, z: float, heading: float) -> Any:
        turned = make("geometry_msgs/Quaternion", 0.0, 0.0, math.sin(0.5 * heading), math.cos(0.5 * heading))
        moved = make("geometry_msgs/Transform", make("geometry_msgs/Vector3", x, y, z), turned)
        return make("geometry_msgs/TransformStamped", header(0.0, parent), child, moved)

    path, sim = tmp_path_factory.mktemp("bag") / "monday", driven()
    start, begun, truth, messages = sim.true_pose.copy(), sim.estimated_pose.copy(), [], []
    nothing = make("geometry_msgs/Twist", *(make("geometry_msgs/Vector3", 0.0, 0.0, 0.0) for _ in range(2)))
    for step in range(400):
        time = 1e3 + step * sim.dt
        x, y, heading = am.relative(begun, sim.estimated_pose)[0].tolist()
        truth.append((time, *am.relative(start, sim.true_pose)[0].tolist()))
        turned = make("geometry_msgs/Quaternion", 0.0, 0.0, math.sin(0.5 * heading), math.cos(0.5 * heading))
        pose = make("geometry_msgs/Pose", make("geometry_msgs/Point", x + 3.0, y - 1.0, 0.0), turned)
        pose = make("geometry_msgs/PoseWithCovariance", pose, np.zeros(36))
        twist = make("geometry_msgs/TwistWithCovariance", nothing, np.zeros(36))
        if step % 2 or step == 0:  # between the scans
            messages.append((time, "/odom", make("nav_msgs/Odometry", header(time, "odom"), "footprint", pose, twist)))
        reading = sim.frames()[0].readings["laser"][1]
        if reading.fresh[0, 0]:
            # This driver begins ahead, and has 0 where nothing returned.
            ranges = np.roll(reading.measured[0], -BEAMS // 2)
            ranges = np.where(np.isfinite(ranges), ranges, 0.0).astype(np.float32)
            beams = 0.0, 2.0 * math.pi, 2.0 * math.pi / BEAMS, 0.0, 0.2, 0.1, 12.0
            scan = make("sensor_msgs/LaserScan", header(time, "lidar"), *beams, ranges, np.zeros(0, np.float32))
            messages.append((time + LATE, "/scan", scan))
        sim.step()
    messages.append((1e3, "/battery", make("std_msgs/Float64", 12.0)))
    # The base point, between the wheels on the ground, is a child of the chassis, as on many robots.
    chassis = transform("chassis", "footprint", 0.1, 0.0, -0.05, 0.0)
    tower = transform("chassis", "tower", 0.0, 0.0, 0.3, math.pi / 2.0)
    lidar = transform("tower", "lidar", -0.05, -0.22, 0.1, 0.0)
    messages.append((1e3 + 1.0, "/tf_static", make("tf2_msgs/TFMessage", [lidar, chassis])))
    messages.append((1e3 + 1.1, "/tf_static", make("tf2_msgs/TFMessage", [tower])))
    with Writer(path, version=9) as writer:
        kinds = {topic: message.__msgtype__ for _, topic, message in messages}
        connections = {topic: writer.add_connection(topic, kind, typestore=store) for topic, kind in kinds.items()}
        for time, topic, message in sorted(messages, key=lambda each: each[0]):
            data = store.serialize_cdr(message, kinds[topic])
            writer.write(connections[topic], round(time * 1e9), data)
    return path, np.array(truth)


def test_a_bag_becomes_a_path_without_further_words(bag: tuple[Path, Any]) -> None:
    """Its topics and the beams of its laser are found, and scans count when they were measured."""
    path, truth = bag
    found = slam(path, progress=False)
    assert found.scans.shape[1] == BEAMS
    assert len(found.path) > 30
    true = am.analysis.Trajectory(time=truth[:, 0], poses=truth[:, 1:])
    path_off, wheels_off = (am.analysis.ape(true, one, align="none").position for one in (found.path, found.odometry))
    assert path_off.mean() < 0.003
    assert path_off.max() < 0.04  # where it brakes between two readings; 0.051 if they count as they come
    assert wheels_off.max() > 0.2


def test_the_laser_is_mounted_where_the_frames_have_it(bag: tuple[Path, Any]) -> None:
    mount = am.analysis.robot_of(bag[0]).sensors["laser"].mount
    assert (mount.x, mount.y, mount.heading) == pytest.approx((MOUNT.x, MOUNT.y, MOUNT.heading))


def turned(roll: float, heading: float) -> Any:
    x, y, z, w = Rotation.from_euler("xz", [roll, heading]).as_quat().tolist()
    return SimpleNamespace(
        translation=SimpleNamespace(x=1.0, y=2.0, z=0.5), rotation=SimpleNamespace(x=x, y=y, z=z, w=w)
    )


def test_a_frame_is_looked_up_in_the_base_and_not_guessed() -> None:
    frames = Frames()
    frames.add("/base", "laser", turned(0.0, 0.5))  # with the slash of ROS 1
    frames.add("other", "camera", turned(0.0, 0.0))
    for base in ("base", "/base", ""):
        mount = frames.mount("/laser", base, "a.bag")
        assert mount is not None
        assert (mount.x, mount.y, mount.heading) == pytest.approx((1.0, 2.0, 0.5))
    assert frames.mount("laser", "other", "a.bag") is None
    assert frames.mount("laser", "wheel", "a.bag") is None
    assert frames.mount("sonar", "base", "a.bag") is None
    frames.add("laser", "base", turned(0.0, 0.0))  # a circle ends
    assert frames.mount("laser", "wheel", "a.bag") is None


def test_a_laser_upside_down_is_refused() -> None:
    frames = Frames()
    frames.add("base", "laser", turned(math.pi, 0.0))
    with pytest.raises(am.AnalysisError, match=r"a\.bag: by /tf_static the laser, 'laser', hangs upside down"):
        frames.mount("laser", "base", "a.bag")


def test_a_scan_has_the_time_at_which_it_was_measured(bag: tuple[Path, Any]) -> None:
    path, _ = bag
    robot = am.analysis.robot_of(path)
    arrived, measured = (
        [entry for entry in read_log(path, robot, as_measured=as_measured) if "laser" in entry.readings]
        for as_measured in (False, True)
    )
    for late, one in zip(arrived, measured, strict=True):
        assert late.time - one.time == pytest.approx(LATE, abs=1e-6)
        assert late.ages["laser"] == pytest.approx(LATE, abs=1e-6)
        assert one.ages["laser"] == 0.0
    times = [entry.time for entry in read_log(path, robot, as_measured=True)]
    assert all(before < after for before, after in itertools.pairwise(times))


def test_topics_that_could_be_meant_otherwise_have_to_be_given(bag: tuple[Path, Any]) -> None:
    path, _ = bag
    two = am.load_robot("pioneer2dx-lms200", pose=am.Pose())
    two = attrs.evolve(two, sensors={**two.sensors, "second": two.sensors["laser"]})
    words = r"are alike: topics /scan, sensors laser, second; say .* as \{'laser': '/scan'\}"
    with pytest.raises(am.AnalysisError, match=words):
        list(read_log(path, two))
    with pytest.raises(am.AnalysisError, match=r"there is none of the topics /robot/sonar.*; say which topic has"):
        list(read_log(path, attrs.evolve(two, sensors={"sonar": am.load_robot("pioneer2dx").sensors["sonar"]})))


def joints_alone(folder: Path, *others: str) -> Path:
    """A rosbag with the angles of wheels, and with empty odometry of these names."""
    from rosbags.rosbag2 import Writer
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS2_HUMBLE)
    with Writer(folder / "bag", version=9) as writer:
        header = store.types["std_msgs/msg/Header"](store.types["builtin_interfaces/msg/Time"](1, 0), "base")
        kind = "sensor_msgs/msg/JointState"
        message = store.types[kind](header, ["l", "r"], np.array([1.0, 2.0]), np.zeros(0), np.zeros(0))
        writer.write(writer.add_connection("/joints", kind, typestore=store), 10**9, store.serialize_cdr(message, kind))
        for name in others:
            writer.add_connection(name, "nav_msgs/msg/Odometry", typestore=store)
    return folder / "bag"


def test_angles_of_wheels_need_the_robot_that_made_them(tmp_path: Path) -> None:
    path = joints_alone(tmp_path)
    for topics in (None, {"encoder": "/joints"}):
        with pytest.raises(am.AnalysisError, match=r"angles of wheels tell how far .*; name the robot that made it"):
            slam(path, topics=topics, progress=False)
    robot = am.load_robot("turtlebot3_burger", pose=am.Pose())
    assert [sorted(entry.readings) for entry in read_log(path, robot)] == [["encoder"]]


def test_odometry_in_metres_is_taken_before_angles_and_one_of_two_has_to_be_named(tmp_path: Path) -> None:
    robot = am.load_robot("turtlebot3_burger", pose=am.Pose())
    for name, others in (("one", ["/odom"]), ("two", ["/odom", "/filtered"])):
        (tmp_path / name).mkdir()
        path = joints_alone(tmp_path / name, *others)
        if name == "one":
            assert list(read_log(path, robot)) == []
        else:
            with pytest.raises(am.AnalysisError, match=r"are alike: topics /filtered, /odom, sensors encoder; say"):
                list(read_log(path, robot))


def test_the_beams_that_a_robot_needs_are_said(bag: tuple[Path, Any]) -> None:
    path, _ = bag
    words = r"/scan: a scan of 360 beams, .* has 180; .* laser = { beams = 360, fov_deg = 360, range_max = 12 }"
    with pytest.raises(am.AnalysisError, match=words):
        list(read_log(path, am.load_robot("pioneer2dx-lms200", pose=am.Pose())))


def test_a_scan_on_a_topic_that_is_not_there_is_not_another_one(bag: tuple[Path, Any]) -> None:
    path, _ = bag
    for topics in ({"laser": "/scann", "encoder": "/odom"}, {"laser": "/battery"}):
        laser = am.analysis.robot_of(path, topics).sensors["laser"].sensor
        assert isinstance(laser, Laser)
        assert laser.beams == 180
    with pytest.raises(am.AnalysisError, match=r"there is no topic '/scann'.*Did you mean '/scan'\?"):
        slam(path, topics={"laser": "/scann"}, progress=False)


def test_a_scan_between_two_readings_has_the_counts_between_them() -> None:
    sensor = am.sensors.Encoder(counts_per_revolution=1000.0)

    def entry(time: float, **readings: list[float]) -> LogEntry:
        return LogEntry(time, {name: np.array(values) for name, values in readings.items()}, None, {})

    entries = [
        entry(0.5, laser=[1.0]),
        entry(1.0, wheels=[0.0, 10.0]),
        entry(1.5, laser=[1.0]),
        entry(1.75, gyro=[0.1]),
        entry(1.8, wheels=[math.nan, 0.0]),
        entry(2.0, wheels=[100.0, 20.0], laser=[1.0]),
        entry(2.5, laser=[1.0]),
        entry(3.0, wheels=[1e5, 20.0]),  # a hundred turns: the counter began anew
        entry(3.5, laser=[1.0]),
    ]
    found = with_wheels_at_scans(entries, "laser", "wheels", sensor)
    assert found[2].readings["wheels"].tolist() == [50.0, 15.0]
    assert found[2].readings["laser"].tolist() == [1.0]
    assert [one for number, one in enumerate(found) if number != 2] == [
        one for number, one in enumerate(entries) if number != 2
    ]
    assert with_wheels_at_scans(entries[:1], "laser", "wheels", sensor) == entries[:1]


@pytest.mark.parametrize("bias", [0.5, -0.5])
def test_readings_that_noise_leads_out_of_the_range_are_exported_and_read(bias: float, tmp_path: Path) -> None:
    """In ROS what is beyond a scan's range_min and range_max does not count, so these hold all readings."""
    unit = am.MountedSensor(
        sensor=Laser(beams=8, fov=math.pi, range_min=1.9, range_max=2.3),
        noise=building.chain(am.noise.Bias(value=bias)),
    )
    one = building.robot(
        pose=am.Pose(x=1.2, y=2.0), sensors={"encoder": building.all_sensors()["encoder"], "laser": unit}
    )
    am.run(building.scenario(one), tmp_path / "run", duration=0.2, progress=False)
    (path,) = am.analysis.export_run(tmp_path / "run", "rosbag", tmp_path / "export")
    given, back = (
        np.array([entry.readings["laser"] for entry in read_log(source, one) if "laser" in entry.readings])
        for source in (tmp_path / "run", path)
    )
    assert ((given[np.isfinite(given)] < 1.9) | (given[np.isfinite(given)] > 2.3)).any()
    np.testing.assert_allclose(back, given, atol=1e-6)


def test_odometry_needs_wheels_that_only_roll(bag: tuple[Path, Any]) -> None:
    path, _ = bag
    car = am.load_robot("car", pose=am.Pose())
    with pytest.raises(am.AnalysisError, match=r"/odom: poses by odometry become counts .* those of robot .* steer"):
        list(read_log(path, car, topics={"encoder": "/odom"}))


@pytest.mark.parametrize(
    ("geometry", "fov", "range_max"),
    [
        (ScanGeometry(360, math.radians(359.0), 3.5), 2.0 * math.pi, 3.5),  # the last beam is one before the first
        (ScanGeometry(720, 2.0 * math.pi, 12.0), 2.0 * math.pi - 1e-6, 12.0),  # it is the first again
        (ScanGeometry(1081, math.radians(270.0), 30.0), math.radians(270.0), 30.0),
        (ScanGeometry(181, math.pi, math.inf), math.pi, 8.0),
        (ScanGeometry(181, math.pi, None), math.pi, 8.0),
        (ScanGeometry(1, 0.0, 4.0), math.pi, 4.0),
    ],
)
def test_a_laser_gets_the_beams_of_a_scan(geometry: ScanGeometry, fov: float, range_max: float) -> None:
    laser = laser_with(geometry, Laser())
    assert (laser.beams, laser.range_max) == (geometry.beams, range_max)
    assert laser.fov == pytest.approx(fov)
    bearings = laser.bearings()[0]
    if geometry.beams > 1:
        assert np.diff(bearings) == pytest.approx(geometry.span / (geometry.beams - 1))
