"""What avoiders know of the others: by what these tell, and by the marks that they carry."""

from __future__ import annotations

import math

import attrs
import numpy as np
import pytest

import amorsim as am
from tests.building import drive, encoder

KINDS = [am.controllers.Orca, am.controllers.HumanLike, am.controllers.Hrvo, am.controllers.SocialForce]


def robot(name, controller, pose, sensor, mount=None, fiducial=0):
    mounted = am.MountedSensor(sensor=sensor, mount=mount or am.Mount())
    return am.Robot(
        name=name,
        shape=am.Shape.circle(0.2),
        drive=drive(rate_max=20.0),
        sensors={"encoder": am.MountedSensor(sensor=encoder()), "others": mounted},
        estimators={"wheels": am.estimators.DeadReckoning()},
        controller=controller,
        pose=pose,
        fiducial=fiducial,
        on_collision="continue",
    )


def simulate(robots, **more):
    room = am.Map.from_segments([], resolution=0.05, extent=(-10, -10, 10, 10))
    return am.Simulation(am.Scenario(map=room, robots=robots, dt=0.1), **more)


def known(simulation, name):
    """What a robot knows of the nearest other: x, y, vx, vy and radius."""
    frame = next(frame for frame in simulation.frames() if name in frame.names)
    return frame.beliefs["controller"]["others"][list(frame.names).index(name), 0]


def pair(watches, sensor, mount=None, **given):
    """A robot that stands and watches another, which drives past it at 0.3 m/s to the right of what it sees."""
    a = robot("a", watches(goals=((0.0, 0.0),), sensor="others", tolerance=0.2, **given), am.Pose(), sensor, mount)
    passing = am.controllers.GoTo(x=2.0, y=-4.0, speed=0.3)
    b = robot("b", passing, am.Pose(x=2.0, y=1.0, heading=-0.5 * math.pi), sensor, fiducial=7)
    return simulate([a, b])


@pytest.mark.parametrize("mount", [None, am.Mount(x=0.1, y=-0.05, heading=0.8)])
def test_marks_tell_places_and_from_one_to_the_next_velocities(mount):
    simulation = pair(am.controllers.Orca, am.sensors.Fiducial(fov=2.0 * math.pi, slots=3), mount, others_radius=0.25)
    simulation.step()
    assert known(simulation, "a")[2:4].tolist() == [0.0, 0.0]  # seen once
    simulation.run(3.0)
    # It decided on what it saw at the beginning of the last step.
    y = simulation.robot("b").true_pose[1] + 0.03
    np.testing.assert_allclose(known(simulation, "a"), [2.0, y, 0.0, -0.3, 0.25], atol=2e-3)


def test_the_others_are_taken_to_be_as_large_as_the_robot_unless_it_says():
    simulation = pair(am.controllers.Hrvo, am.sensors.Fiducial(fov=2.0 * math.pi))
    simulation.step()
    assert known(simulation, "a")[4] == 0.2


def test_marks_without_an_identity_stand():
    sensor = am.sensors.Fiducial(fov=2.0 * math.pi, range_max_id=0.5)
    simulation = pair(am.controllers.Orca, sensor)
    simulation.run(2.0)
    assert known(simulation, "a")[2:4].tolist() == [0.0, 0.0]
    assert known(simulation, "a")[0] == pytest.approx(2.0, abs=1e-3)


def test_velocities_settle_though_readings_come_late():
    """Every 0.4 s a reading, 0.2 s old: what is known between them goes on."""
    sensor = am.sensors.Fiducial(fov=2.0 * math.pi)
    scenario = pair(am.controllers.Orca, sensor).scenario
    slow = [
        attrs.evolve(one, sensors=one.sensors | {"others": attrs.evolve(one.sensors["others"], rate=2.5, latency=0.2)})
        for one in scenario.robots
    ]
    simulation = simulate(slow)
    simulation.run(4.0)
    y = simulation.robot("b").true_pose[1] + 0.03
    np.testing.assert_allclose(known(simulation, "a"), [2.0, y, 0.0, -0.3, 0.2], atol=5e-3)


@pytest.mark.parametrize("mount", [am.Mount(heading=math.pi), am.Mount(x=0.1, y=-0.1, heading=-1.0)])
def test_what_neighbours_tell_is_taken_from_where_the_sensor_is_mounted(mount):
    plain, turned = (pair(am.controllers.Orca, am.sensors.Neighbours(slots=2), one) for one in (None, mount))
    for simulation in (plain, turned):
        simulation.run(2.0)
    np.testing.assert_allclose(known(turned, "a"), known(plain, "a"), atol=1e-9)


@pytest.mark.parametrize("kind", KINDS)
def test_two_that_see_each_others_marks_pass_each_other(kind):
    sensor, given = am.sensors.Fiducial(fov=2.0 * math.pi), {"speed": 0.5, "clearance": 0.1, "sensor": "others"}
    a = robot("a", kind(goals=((3.0, 0.0),), **given), am.Pose(x=-3.0, y=0.05), sensor, fiducial=1)
    b = robot("b", kind(goals=((-3.0, 0.0),), **given), am.Pose(x=3.0, y=-0.05, heading=math.pi), sensor, fiducial=2)
    simulation = simulate([a, b])
    nearest = math.inf
    for _ in range(250):
        simulation.step()
        nearest = min(nearest, math.dist(*simulation.true_pose[:, :2]))
    assert sorted((event.name, event.path) for event in simulation.events) == [
        ("a", "goal_reached"),
        ("b", "goal_reached"),
    ]
    assert 0.4 < nearest < 2.0


def test_a_row_that_sees_marks_does_not_depend_on_others():
    robots = [
        robot(
            f"r{n}",
            am.controllers.HumanLike(goals=((-2.0 * c, -2.0 * s),), sensor="others"),
            am.Pose(x=2.0 * c, y=2.0 * s),
            am.sensors.Fiducial(),
            fiducial=n + 1,
        )
        for n, (c, s) in enumerate((math.cos(a), math.sin(a)) for a in (0.0, 2.1, 4.2))
    ]
    together, alone = simulate(robots, replicas=3), simulate(robots, replicas=[1])
    together.run(3.0)
    alone.run(3.0)
    assert alone.digest(1) == together.digest(1)
