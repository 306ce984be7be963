"""Avoiders among robots that tell one another where they are."""

import math

import numpy as np
import pytest

import amorsim as am
from amorsim.core.errors import ComponentError
from tests.building import drive, encoder

KINDS = [am.controllers.Orca, am.controllers.HumanLike, am.controllers.Hrvo, am.controllers.SocialForce]


def robot(name, controller, pose, radius=0.2, **sensor):
    return am.Robot(
        name=name,
        shape=am.Shape.circle(radius),
        drive=drive(rate_max=20.0),
        sensors={
            "encoder": am.MountedSensor(sensor=encoder()),
            "neighbours": am.MountedSensor(sensor=am.sensors.Neighbours(**sensor)),
        },
        estimators={"wheels": am.estimators.DeadReckoning()},
        controller=controller,
        pose=pose,
        on_collision="continue",
    )


def simulate(robots, *, replicas=1):
    room = am.Map.from_segments([], resolution=0.05, extent=(-10, -10, 10, 10))
    return am.Simulation(am.Scenario(map=room, robots=robots, dt=0.1), replicas=replicas)


def words(simulation):
    return sorted((event.name, event.path or event.kind) for event in simulation.events)


@pytest.mark.parametrize("kind", KINDS)
def test_two_that_meet_pass_each_other(kind):
    # A little aside, so that they need not agree on a side.
    given = {"speed": 0.5, "clearance": 0.1}
    a = robot("a", kind(goals=((3.0, 0.0),), **given), am.Pose(x=-3.0, y=0.05))
    b = robot("b", kind(goals=((-3.0, 0.0),), **given), am.Pose(x=3.0, y=-0.05, heading=math.pi))
    simulation = simulate([a, b])
    nearest = math.inf
    for _ in range(250):
        simulation.step()
        nearest = min(nearest, math.dist(*simulation.true_pose[:, :2]))
    assert words(simulation) == [("a", "goal_reached"), ("b", "goal_reached")]
    assert 0.4 < nearest < 2.0


@pytest.mark.parametrize("kind", KINDS)
def test_one_alone_goes_straight(kind):
    simulation = simulate([robot("a", kind(goals=((2.0, 1.0),), speed=0.5), am.Pose())])
    simulation.run(12.0)
    assert words(simulation) == [("a", "goal_reached")]
    assert simulation.events[0].time < 8.0


def test_a_deadlock_is_reported():
    """One stands where the other wants to go."""
    stands = robot("b", am.controllers.GoTo(x=3.0, y=0.0), am.Pose(x=3.0))
    simulation = simulate([robot("a", am.controllers.Orca(goals=((3.0, 0.0),), patience=5.0), am.Pose()), stands])
    simulation.run(25.0)
    assert words(simulation) == [("a", "deadlock")]


def test_goals_may_go_round():
    controller = am.controllers.HumanLike(goals=((1.0, 0.0), (-1.0, 0.0)), loop=True, speed=0.5)
    simulation = simulate([robot("a", controller, am.Pose())])
    simulation.run(20.0)
    assert [event.value for event in simulation.events][:3] == ["1 of 2", "2 of 2", "1 of 2"]


def test_neighbours_tell_where_they_are_and_how_fast():
    a = robot("a", None, am.Pose(x=1.0, y=2.0, heading=0.5 * math.pi), slots=2, range_max=4.0)
    b = robot("b", am.controllers.GoTo(x=4.0, y=3.0, speed=0.3), am.Pose(x=2.0, y=3.0), radius=0.3, slots=2)
    far = robot("c", None, am.Pose(x=-9.0, y=-9.0), slots=2)
    simulation = simulate([a, b, far])
    simulation.run(1.0)
    x = simulation.robot("b").true_pose[0]
    table = simulation.robot("a").readings["neighbours"].true.reshape(-1, 6)
    ahead, left = 1.0, -(x - 1.0)
    np.testing.assert_allclose(table[0], [math.hypot(ahead, left), ahead, left, 0.0, -0.3, 0.3], atol=1e-9)
    assert table[1].tolist() == [math.inf, math.inf, math.inf, 0.0, 0.0, 0.0]


def test_a_row_does_not_depend_on_others():
    robots = [
        robot(f"r{n}", am.controllers.HumanLike(goals=((-2.0 * c, -2.0 * s),)), am.Pose(x=2.0 * c, y=2.0 * s))
        for n, (c, s) in enumerate((math.cos(a), math.sin(a)) for a in (0.0, 2.1, 4.2))
    ]
    together = simulate(robots, replicas=3)
    together.run(3.0)
    alone = simulate(robots, replicas=[1])
    alone.run(3.0)
    assert alone.digest(1) == together.digest(1)


def test_it_needs_a_sensor_of_neighbours():
    lost = robot("a", am.controllers.Orca(goals=((1.0, 0.0),), sensor="encoder"), am.Pose())
    with pytest.raises(ComponentError, match=r"orca uses the sensor 'encoder', which is no 'neighbours'"):
        simulate([lost])
