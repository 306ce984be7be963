"""Scenarios as worlds of Stage: read again, robots, obstacles and landmarks are where they were, and what they were."""

import math

import attrs
import numpy as np
import pytest
import shapely
from shapely.affinity import rotate, translate

import amorsim as am
from amorsim.foreign.stage.write import stage_models
from amorsim.runs.scenario_argument import placed
from amorsim.scenario.files.resolved import resolved_table
from amorsim.sensors import Bumper, Compass, Fiducial, Laser, Sonar
from amorsim.sensors.bumper import Sector

BODY = am.Shape.polygon([(-0.3, -0.19), (0.14, -0.19), (0.2, 0.0), (0.14, 0.19), (-0.3, 0.19)])
RADIUS, TRACK, BASE = 0.1875 * 0.5, 0.33, 0.5 * 0.33 / 0.38  # as Stage's robots of that size are read
SPEED, CHANGE = 0.8, 2.0  # m/s, m/s^2


def robot(drive, name="rover", **changes):
    given = {
        "shape": BODY,
        "pose": am.Pose(x=1.5, y=2.25, heading=math.radians(30.0)),
        "controller": am.controllers.Wander(sensor="laser"),
        "on_collision": "continue",
        "fiducial": 7,
        "colour": "#ff8000",
        "height": 0.4,
    }
    return am.Robot(name=name, drive=drive, **(given | changes))


def differential(**changes):
    wheels = {"wheel_radius_left": RADIUS, "wheel_radius_right": RADIUS, "track": TRACK}
    return am.drives.Differential(**wheels, rate_max=SPEED / RADIUS, acceleration_max=CHANGE / RADIUS, **changes)


SENSORS = {
    "laser": am.MountedSensor(
        sensor=Laser(beams=91, fov=math.pi, range_min=0.1, range_max=6.0),
        mount=am.Mount(x=0.1, y=0.02, heading=math.radians(5.0)),
        rate=5.0,
        noise=[am.noise.AimGaussian(std=math.radians(0.2)), am.noise.Gaussian(std=0.02, proportional=0.01)],
    ),
    "sonar": am.MountedSensor(
        sensor=Sonar(
            elements=tuple(am.Mount(x=0.1, y=0.05 * k, heading=0.5 * k) for k in (-1, 0, 1)),
            half_angle=math.radians(15.0),
            range_max=3.0,
        ),
        mount=am.Mount(x=0.05),
    ),
    "finder": am.MountedSensor(sensor=Fiducial(fov=math.radians(120.0), range_max=7.0, range_max_id=4.0)),
    "bumper": am.MountedSensor(sensor=Bumper(segments=(Sector(start=-0.6, end=0.2), Sector(start=0.2, end=0.9)))),
}


def scenario(**changes):
    room = am.Map.from_array(np.pad(np.zeros((98, 118)), 1, constant_values=1), resolution=0.05)
    crate = am.Shape.rectangle(0.4, 0.6)
    obstacles = [
        am.Obstacle(name="crate", shape=crate, pose=am.Pose(x=3.0, y=1.0, heading=0.5), height=0.7),
        am.Obstacle(name="post", shape=am.Shape.circle(0.2), pose=am.Pose(x=4.5, y=3.5), fiducial=3, colour="#0000ff"),
    ]
    marks = [
        am.Landmark(id=11, x=0.5, y=4.0, radius=0.1),
        am.Landmark(id=12, x=5.5, y=0.5, radius=0.05, colour="#00ff00"),
    ]
    robots = [robot(differential(), sensors=SENSORS)]
    given = {"map": room, "robots": robots, "obstacles": obstacles, "landmarks": marks, "dt": 0.05, "duration": 30.0}
    return am.Scenario(**(given | changes))


def written(given, folder):
    """A scenario that is written and read again, and what was said to be lost."""
    path = folder / "lab.world"
    saved = am.save_map(given.map, path, use="stage")
    text, lost = stage_models(resolved_table(attrs.evolve(placed(given), map=saved)))
    path.write_text(f"{path.read_text()}\n{text}")
    return am.load(path), lost


def area_of(body):
    turned = rotate(shapely.Polygon(body.shape.outline), body.pose.heading, origin=(0, 0), use_radians=True)
    return translate(turned, body.pose.x, body.pose.y)


def test_bodies_are_where_they_were_and_as_large(tmp_path):
    before = scenario()
    after, _ = written(before, tmp_path)
    assert (after.dt, after.duration) == (before.dt, before.duration)
    pairs = [*zip(before.robots, after.robots, strict=True), *zip(before.obstacles, after.obstacles, strict=True)]
    for was, now in pairs:
        for field in ("name", "fiducial", "height", "colour"):
            assert getattr(now, field) == getattr(was, field)
        # A circle has 32 corners there.
        assert area_of(was).symmetric_difference(area_of(now)).area < 0.02 * area_of(was).area
    pose = after.robots[0].pose
    assert (pose.x, pose.y, pose.heading) == pytest.approx((1.5, 2.25, math.radians(30.0)))
    for was, now in zip(before.landmarks, after.landmarks, strict=True):
        assert (now.id, now.x, now.y, now.colour) == (was.id, was.x, was.y, was.colour)
        assert now.radius == pytest.approx(was.radius, abs=1e-6)


def test_sensors_measure_what_they_did(tmp_path):
    after, lost = written(scenario(), tmp_path)
    sensors = after.robots[0].sensors
    assert set(sensors) == {"encoder", *SENSORS}
    laser, was = sensors["laser"], SENSORS["laser"]
    for name in ("beams", "fov", "range_min", "range_max"):
        assert getattr(laser.sensor, name) == pytest.approx(getattr(was.sensor, name))
    assert laser.rate == was.rate
    for name in ("x", "y", "heading"):
        assert getattr(laser.mount, name) == pytest.approx(getattr(was.mount, name))
    kept = {type(element.noise).__name__: element.noise for element in laser.noise}
    assert kept["AimGaussian"].std == pytest.approx(math.radians(0.2))
    assert (kept["Gaussian"].std, kept["Gaussian"].proportional) == pytest.approx((0.02, 0.01))
    sonar = sensors["sonar"].sensor
    assert sonar.half_angle == pytest.approx(math.radians(15.0))
    assert [element.x for element in sonar.elements] == pytest.approx([0.15] * 3)
    assert [element.heading for element in sonar.elements] == pytest.approx([-0.5, 0.0, 0.5])
    finder = sensors["finder"].sensor
    assert (finder.fov, finder.range_max, finder.range_max_id) == pytest.approx((math.radians(120.0), 7.0, 4.0))
    segments = [(one.start, one.end) for one in sensors["bumper"].sensor.segments]
    np.testing.assert_allclose(segments, [(-0.6, 0.2), (0.2, 0.9)], atol=1e-6)
    assert not [line for line in lost if "left out" in line]


LIMITS = {"rate_max": SPEED / RADIUS, "acceleration_max": CHANGE / RADIUS}
CORNERS = {f"wheel_radius_{end}_{side}": RADIUS for end in ("front", "rear") for side in ("left", "right")}
STEERING = {"steering_max": math.radians(30.0), "steering_rate": math.radians(60.0)}


@pytest.mark.parametrize(
    "drive",
    [
        differential(),
        am.drives.Mecanum(**CORNERS, wheelbase=BASE, track=TRACK, **LIMITS),
        am.drives.Ackermann(wheel_radius=RADIUS, wheelbase=0.3, track=TRACK, **STEERING, **LIMITS),
    ],
    ids=["diff", "omni", "car"],
)
def test_drives_whose_wheels_are_as_stages_are_the_same(drive, tmp_path):
    after, lost = written(scenario(robots=[robot(drive, controller=None)]), tmp_path)
    found = after.robots[0].drive
    assert type(found) is type(drive)
    for name, value in attrs.asdict(drive, recurse=False).items():
        assert getattr(found, name) == (pytest.approx(value, rel=1e-6) if isinstance(value, float) else value), name
    assert not [line for line in lost if "wheel" in line]


def test_what_stage_cannot_hold_is_said(tmp_path):
    rover = robot(
        differential(lag=0.1),
        controller=am.controllers.GoTo(x=1.0, y=1.0),
        sensors={**SENSORS, "compass": am.MountedSensor(sensor=Compass())},
        estimators={"scans": am.estimators.ScanMatching(wheel_variance=1e-4, range_std=0.01)},
    )
    there = am.motions.Loop(waypoints=((3.0, 3.0), (4.0, 3.0)))
    door = am.Obstacle(name="door", shape=am.Shape.rectangle(0.1, 0.5), pose=am.Pose(x=3.0, y=3.0), motion=there)
    _, lost = written(scenario(robots=[rover], obstacles=[door]), tmp_path)
    said = "\n".join(lost)
    for word in ("'goto'", "'compass'", "lag of its motors", "'scans' (scan_matching)", "its motion (loop)"):
        assert word in said, said


def test_starts_that_are_drawn_are_those_of_replica_0(tmp_path):
    start = {"pose": None, "start": am.RandomStart(), "controller": None}
    many = [robot(differential(), name=f"r{k}", **start) for k in range(3)]
    given = scenario(robots=many)
    after, _ = written(given, tmp_path)
    places = [[one.pose.x, one.pose.y] for one in after.robots]
    np.testing.assert_allclose(places, am.Simulation(given).true_pose[:, :2], atol=1e-9)
