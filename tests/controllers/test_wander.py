import functools
import math
from pathlib import Path

import numpy as np
import pytest

import amorsim.maps.wld
from amorsim.contracts import Mount
from amorsim.controllers import Wander
from amorsim.core.errors import ComponentError
from amorsim.core.maps.map import Map
from amorsim.core.parameters import ParameterError
from amorsim.core.shapes import Shape
from amorsim.drives import Differential
from amorsim.estimators import DeadReckoning
from amorsim.maps.wld import Wld
from amorsim.noise import Gaussian, Quantize
from amorsim.scenario.spec import Deviation, Distribution, MountedSensor, Pose, Robot, Scenario
from amorsim.sensors import Encoder, Gyro, Laser, Sonar
from amorsim.simulation.simulation import Simulation
from tests.building import chain, room

# The Pioneer 2DX, roughly: footprint [m] and ring [mm, mm, deg].
OUTLINE = [(0.21, 0.12), (0.12, 0.2125), (-0.18, 0.2125), (-0.301, 0.12)]
RING = [
    (69, 136, 90), (114, 119, 50), (148, 78, 30), (166, 27, 10),
    (-157, 136, 90), (-203, 119, 130), (-237, 78, 150), (-255, 27, 170),
]  # fmt: skip


@functools.cache
def office() -> Map:
    return Wld().load(Path(amorsim.maps.wld.__file__).parents[1] / "scenarios" / "office.wld")


def make_robot(controller, *, acceleration=None, errors=None, pose=None, **laser):
    mirrored = [*RING, *((x, -y, -heading) for x, y, heading in RING)]
    elements = tuple(Mount(x=x / 1e3, y=y / 1e3, heading=math.radians(a)) for x, y, a in mirrored)
    sensors = {"encoder": MountedSensor(sensor=Encoder(counts_per_revolution=39400.0), noise=chain(Quantize(step=1.0)))}
    if controller.sensor == "sonar":
        sensors["sonar"] = MountedSensor(sensor=Sonar(elements=elements), noise=chain(Gaussian(std=0.005)))
    else:
        sensors["laser"] = MountedSensor(
            sensor=Laser(),
            mount=Mount(x=0.017, y=0.008),
            noise=chain(Gaussian(std=0.005), Quantize(step=0.01)),
            **laser,
        )
    if pose is None:
        start = office().start
        pose = Pose(x=start[0], y=start[1], heading=start[2])
    return Robot(
        shape=Shape.polygon([*OUTLINE, *((x, -y) for x, y in OUTLINE[::-1])]),
        drive=Differential(
            wheel_radius_left=0.0825,
            wheel_radius_right=0.0825,
            track=0.33,
            rate_max=20.0,
            acceleration_max=acceleration,
        ),
        sensors=sensors,
        estimators={"dead_reckoning": DeadReckoning()},
        controller=controller,
        errors=errors or {},
        pose=pose,
    )


DRIFT = {
    "drive.wheel_radius_left": Deviation(scale=Distribution(kind="normal", values=(1.0, 0.01))),
    "drive.track": Deviation(scale=Distribution(kind="normal", values=(1.0, 0.02))),
}


def simulate(robot, *, world=None, seed=0, replicas=1):
    scenario = Scenario(map=office() if world is None else world, robots=(robot,), dt=0.1, seed=seed)
    return Simulation(scenario, replicas=replicas)


def paths(sim, duration):
    """True poses after each second, (T, N, 3)."""
    poses = [sim.true_pose.copy()]
    for _ in range(round(duration)):
        sim.run(1.0)
        poses.append(sim.true_pose.copy())
    return np.array(poses)


def assert_roams(sim, duration, *, every=30.0, least=1.0):
    """No collision, and in any `every` seconds each robot gets `least` metres about."""
    poses = paths(sim, duration)
    assert sim.events == []
    window = int(every)
    for first in range(0, len(poses) - window, window // 2):
        part = poses[first : first + window + 1, :, :2]
        assert np.hypot(*(part.max(axis=0) - part.min(axis=0)).T).min() > least
    return poses


def test_it_wanders_about_an_office():
    poses = assert_roams(simulate(make_robot(Wander(), errors=DRIFT), replicas=6), 90.0)
    length = np.hypot(*np.diff(poses[:, :, :2], axis=0).transpose(2, 0, 1)).sum(axis=0)
    assert length.min() > 15.0
    assert len({tuple(pose) for pose in poses[-1].round(1)}) == 6  # each went its own way


def test_it_wanders_by_a_ring_of_sonars():
    assert_roams(simulate(make_robot(Wander(sensor="sonar")), replicas=2), 45.0)


def test_it_takes_its_wheels_limits_into_account():
    assert_roams(simulate(make_robot(Wander(), acceleration=0.3 / 0.0825), replicas=6), 60.0)


def test_it_takes_the_age_of_a_scan_into_account():
    assert_roams(simulate(make_robot(Wander(), rate=5.0, latency=0.25), replicas=6), 60.0, least=0.5)


@pytest.mark.parametrize("heading", [0.0, math.pi])
def test_it_gets_away_from_a_wall_that_leaves_no_room_to_turn(heading):
    robot = make_robot(Wander(), pose=Pose(x=3.0, y=0.25, heading=heading))
    assert_roams(simulate(robot, world=room(), replicas=4), 60.0)


def test_it_stands_still_where_it_is_shut_in_and_touches_nothing():
    sim = simulate(make_robot(Wander(), pose=Pose(x=0.45, y=0.45)), world=room(0.9, 0.9), replicas=4)
    poses = paths(sim, 60.0)
    assert sim.events == []
    assert np.hypot(*(poses[:, :, :2] - 0.45).transpose(2, 0, 1)).max() < 0.12


def test_replicas_go_as_they_go_alone():
    robot = make_robot(Wander(), errors=DRIFT)
    together, alone = simulate(robot, replicas=5), simulate(robot, replicas=[3])
    for sim in (together, alone):
        sim.run(20.0)
    assert together.digest(3) == alone.digest(3)


@pytest.mark.long
@pytest.mark.parametrize("seed", range(20))
def test_it_never_gets_stuck_in_five_minutes(seed):
    poses = assert_roams(simulate(make_robot(Wander(), errors=DRIFT), seed=seed), 300.0)
    cells = {(int(x), int(y)) for x, y in poses[:, 0, :2]}
    assert len(cells) > 30  # square metres: it does not go round and round


@pytest.mark.long
def test_hours_by_laser():
    poses = assert_roams(simulate(make_robot(Wander(), errors=DRIFT), replicas=16), 3600.0, every=60.0)
    for row in range(16):
        assert len({(int(x / 2), int(y / 2)) for x, y in poses[:, row, :2]}) > 45  # of 96 squares of 2 m


@pytest.mark.long
def test_minutes_by_sonar():
    assert_roams(simulate(make_robot(Wander(sensor="sonar"), errors=DRIFT), replicas=8), 300.0, every=60.0)


def test_a_robot_without_the_sensor_gets_a_message_with_what_it_has():
    robot = make_robot(Wander())
    with pytest.raises(ComponentError, match=r"'lazer'.*its range sensors: 'laser'.*Did you mean 'laser'\?"):
        simulate(
            Robot(
                shape=robot.shape,
                drive=robot.drive,
                sensors=robot.sensors,
                controller=Wander(sensor="lazer"),
                pose=robot.pose,
            )
        )


def test_a_sensor_that_sees_no_ranges_is_refused():
    robot = make_robot(Wander())
    with pytest.raises(ComponentError, match="a Gyro has no bearings"):
        simulate(
            Robot(
                shape=robot.shape,
                drive=robot.drive,
                sensors={"laser": MountedSensor(sensor=Gyro())},
                controller=Wander(),
                pose=robot.pose,
            )
        )


@pytest.mark.parametrize(
    ("make", "name"),
    [
        (lambda: Wander(speed=0.0), "speed"),
        (lambda: Wander(clearance=-0.1), "clearance"),
        (lambda: Wander(turn_rate=math.nan), "turn_rate"),
        (lambda: Wander(sensor=3), "sensor"),
    ],
)
def test_a_value_that_makes_no_sense_is_refused_by_name(make, name):
    with pytest.raises(ParameterError, match=name):
        make()
