"""Driving to goals by the dynamic window approach."""

import math

import numpy as np
import pytest

import amorsim as am
from amorsim.core.errors import ComponentError
from tests.building import chain, drive, encoder

ROOM = [(-2, -3, 8, -3), (8, -3, 8, 3), (8, 3, -2, 3), (-2, 3, -2, -3)]


def make(controller, *, sensor=None, shape=None, start=None, **changes):
    """A robot with a laser that sees all ahead of it, and wheels that speed up slowly."""
    return am.Robot(
        name=changes.pop("name", "rover"),
        shape=shape or am.Shape.rectangle(0.5, 0.4),
        drive=changes.pop("drive", None) or drive(rate_max=15.0, acceleration_max=8.0),
        sensors={
            "encoder": am.MountedSensor(sensor=encoder()),
            "laser": am.MountedSensor(
                sensor=sensor or am.sensors.Laser(beams=121, fov=math.radians(240.0), range_max=6.0),
                noise=chain(am.noise.Gaussian(std=0.005)),
            ),
        },
        estimators={"wheels": am.estimators.DeadReckoning()},
        controller=controller,
        pose=start or am.Pose(),
        on_collision="end",
        **changes,
    )


def simulate(robots, walls=(), *, duration, replicas=1, threads=1, obstacles=()):
    world = am.Map.from_segments([*ROOM, *walls], resolution=0.01)
    scenario = am.Scenario(map=world, robots=robots, obstacles=list(obstacles), dt=0.1)
    simulation = am.Simulation(scenario, replicas=replicas, threads=threads)
    simulation.run(duration)
    return simulation


def said(simulation):
    return [(event.name, event.path, event.value) for event in simulation.events if event.kind == "report"]


def test_it_passes_posts_and_stops_at_its_goals():
    posts = [(x, y, x, y + 0.3) for x, y in ((2.0, -0.2), (3.2, 0.4), (3.3, -0.9), (4.5, 0.0))]
    controller = am.controllers.Dwa(goals=((6.0, 0.5), (6.5, -1.5)), speed=0.6, horizon=2.5)
    simulation = simulate([make(controller)], posts, duration=40.0)
    assert [event for event in simulation.events if event.kind == "collision"] == []
    assert said(simulation) == [("rover", "goal_reached", "1 of 2"), ("rover", "goal_reached", "2 of 2")]
    first, second = (event.time for event in simulation.events)
    assert 10.0 < first < second < 35.0
    assert np.hypot(*(simulation.true_pose[0, :2] - (6.5, -1.5))) < 0.2
    assert np.abs(simulation.robot("rover").true_twist).max() < 1e-6


def test_a_dead_end_stops_it_and_it_says_so():
    trap = [(2.0, -1.0, 2.0, 1.0), (2.0, -1.0, 0.8, -1.0), (2.0, 1.0, 0.8, 1.0)]
    simulation = simulate([make(am.controllers.Dwa(goals=((5.0, 0.0),)))], trap, duration=25.0)
    assert said(simulation) == [("rover", "blocked", "no progress")]
    assert simulation.active.all()


def test_its_arcs_are_beliefs():
    simulation = simulate([make(am.controllers.Dwa(goals=((5.0, 0.0),)))], duration=2.0)
    beliefs = simulation.frames()[0].beliefs["controller"]
    arcs = beliefs["arcs"]
    assert arcs.shape == (1, 7, 21, 3)
    assert beliefs["twist"].shape == (1, 2)
    v, w, _ = arcs.reshape(-1, 3)[np.nanargmin(arcs[..., 2])]
    assert beliefs["twist"][0].tolist() == [v, w]


def test_rows_and_threads_change_nothing():
    robots = [
        make(am.controllers.Dwa(goals=((5.0, y),), speed=0.4 + 0.1 * n), name=f"r{n}", start=am.Pose(y=y))
        for n, y in enumerate((-2.0, 0.0, 2.0))
    ]
    together = simulate(robots, duration=6.0, replicas=2)
    threaded = simulate(robots, duration=6.0, replicas=2, threads=2)
    assert together.digest() == threaded.digest()
    alone = simulate(robots, duration=6.0, replicas=[1])
    assert alone.digest(1) == together.digest(1)


@pytest.mark.parametrize("kind", ["car", "synchro", "sonar"])
def test_it_drives_any_drive_by_laser_or_sonar(kind):
    goals = ((5.5, 1.0),)
    controller = am.controllers.Dwa(goals=goals, speed=0.5, clearance=0.1)
    changes = {}
    if kind == "car":
        changes["drive"] = am.drives.Ackermann(
            wheel_radius=0.1, wheelbase=0.4, track=0.3, steering_max=0.6, rate_max=10.0, steering_rate=3.0
        )
    elif kind == "synchro":
        changes["drive"] = am.drives.Synchro(wheel_radius=0.1, rate_max=10.0, steering_rate_max=3.0)
        changes["shape"] = am.Shape.circle(0.25)
    else:
        mounts = tuple(am.Mount(heading=math.radians(15.0 * n)) for n in range(-8, 9))
        changes["sensor"] = am.sensors.Sonar(elements=mounts, half_angle=math.radians(8.0), range_max=4.0)
    simulation = simulate([make(controller, **changes)], [(2.5, -0.6, 2.5, 0.0)], duration=30.0)
    assert said(simulation) == [("rover", "goal_reached", "1 of 1")]


def test_it_needs_goals_and_a_range_sensor():
    with pytest.raises(ComponentError, match=r"dwa by itself needs goals.*'rover' has none"):
        simulate([make(am.controllers.Dwa())], duration=0.1)
    with pytest.raises(ComponentError, match="uses the sensor 'lidar', which the robot does not have"):
        simulate([make(am.controllers.Dwa(goals=((1.0, 0.0),), sensor="lidar"))], duration=0.1)
