"""No two bodies overlap and none is in a wall, at any density and speed; and those in contact can part."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import HealthCheck, given
from hypothesis import strategies as st

import amorsim as am
from amorsim.motions import Loop, Oscillate, Pedestrian, SwingDoor, Wander
from tests import building
from tests.examples import settings

LEAST = -1e-9  # [m]: a body that stopped may overlap a third one by a rounding, some 2e-16 m


def check(sim: am.Simulation) -> None:
    world = sim._fleet.world
    zero = np.zeros(len(world.everyone))
    gaps, _ = world.wall_gaps(world.everyone, world.poses, zero)
    assert gaps.min() >= LEAST
    a, b = world.pairs_within(world.poses, zero)
    if len(a):
        assert world.body_gaps(a, world.poses[a], b, world.poses[b], np.zeros(len(a))).min() >= LEAST


MOTIONS = [
    Wander(speed=4.0, course_std=2.0),
    Wander(speed=0.3, blocked="wait"),
    Loop(waypoints=((1.0, 1.0), (7.0, 7.0), (1.0, 7.0)), speed=5.0, blocked="skip", patience=0.1),
    Oscillate(waypoints=((0.5, 4.0), (7.5, 4.0)), speed=2.0),
    Pedestrian(goals=((1.0, 1.0), (7.0, 7.0), (4.0, 4.0)), order="random", blocked="skip", patience=0.5),
    Pedestrian(goals=((4.0, 4.0),), strength=0.0, wall_strength=0.0, speed=3.0),  # all to one place, minding nobody
    SwingDoor(timetable=((0.0, 0.6),), period=1.0, rate=8.0),
]
SHAPES = [
    am.Shape.circle(0.1),
    am.Shape.circle(0.25),
    am.Shape.rectangle(0.5, 0.1),
    am.Shape.rectangle(0.3, 0.05, x=0.17),
    am.Shape.polygon([(0, 0), (0.4, 0), (0.4, 0.1), (0.1, 0.1), (0.1, 0.4), (0, 0.4)]),
]


@pytest.mark.long
@given(
    seed=st.integers(0, 2**32),
    robots=st.integers(1, 60),
    kinds=st.lists(st.tuples(st.sampled_from(MOTIONS), st.sampled_from(SHAPES), st.integers(5, 60)), max_size=5),
    dt=st.sampled_from([0.02, 0.1, 0.5]),
)
@settings(max_examples=8, deadline=None, suppress_health_check=[HealthCheck.too_slow])
def test_nobody_overlaps_anybody(seed: int, robots: int, kinds: list[tuple[object, am.Shape, int]], dt: float) -> None:
    start = am.RandomStart()
    bodies = [
        building.robot(
            name=f"r{i:03d}", shape=SHAPES[i % 5], controller=building.Roam(rate=40.0), on_collision="continue",
            pose=None, start=start,
        )
        for i in range(robots)
    ]  # fmt: skip
    things = [
        am.Obstacle(name=f"o{k}_{i:03d}", shape=shape, motion=motion, start=start)
        for k, (motion, shape, count) in enumerate(kinds)
        for i in range(count)
    ]
    room = building.room(8.0, 8.0, 0.01)
    try:
        sim = am.Simulation(am.Scenario(map=room, robots=bodies, obstacles=things, dt=dt, seed=seed))
    except am.ScenarioError:  # too dense to be placed at random
        return
    check(sim)
    for _ in range(12):
        sim.step()
        check(sim)


def in_and_out(obstacle: am.motions.ObstacleState) -> tuple[float, float]:
    """To the middle of the room for three seconds, and then away from it."""
    x, y = 5.0 - obstacle.x, 5.0 - obstacle.y
    far = max(np.hypot(x, y), 1e-9)
    speed = 2.0 if obstacle.time < 3.0 else -2.0
    return speed * x / far, speed * y / far


def test_hundreds_that_jam_part_again() -> None:
    start = am.RandomStart(random=(1.0, 1.0, 9.0, 9.0))
    people = [
        am.Obstacle(name=f"p{i:03d}", shape=am.Shape.circle(0.12), start=start, motion=in_and_out) for i in range(150)
    ]
    robot = building.robot(pose=am.Pose(x=0.5, y=0.6))
    sim = am.Simulation(building.scenario(robot, obstacles=people, map=building.room(10.0, 10.0, 0.01)))
    for _ in range(30):
        sim.step()
        check(sim)
    before = sim._fleet.world.poses[1:, :2].copy()
    a, _ = sim._fleet.world.pairs_within(sim._fleet.world.poses, np.full(151, 1e-6))
    assert len(a) > 30  # touching pairs
    for _ in range(30):
        sim.step()
        check(sim)
    out = np.linalg.norm(sim._fleet.world.poses[1:, :2] - 5.0, axis=1) - np.linalg.norm(before - 5.0, axis=1)
    assert np.median(out) > 1.5
    assert out.min() > 0.2


def test_robots_in_contact_part() -> None:
    a = building.robot(name="a", shape=am.Shape.circle(0.2), pose=am.Pose(x=2.0, y=2.0), on_collision="continue")
    b = building.robot(name="b", shape=am.Shape.circle(0.2), pose=am.Pose(x=3.0, y=2.0, heading=np.pi),
                       on_collision="continue")  # fmt: skip
    sim = am.Simulation(building.scenario(a, b))
    for name in "ab":
        sim.robot(name).drive(forward=0.5)
    sim.run(2.0)
    check(sim)
    gap = abs(sim.robot("a").true_pose[0] - sim.robot("b").true_pose[0]) - 0.4
    assert gap == pytest.approx(0.0, abs=1e-9)
    for name in "ab":
        sim.robot(name).drive(forward=-0.5)
    sim.run(1.0)
    assert abs(sim.robot("a").true_pose[0] - sim.robot("b").true_pose[0]) == pytest.approx(1.4, abs=1e-6)


def test_moving_obstacles_in_any_order_of_the_file_and_in_any_group() -> None:
    start = am.RandomStart()
    robots = [
        building.robot(name=f"r{i}", controller=building.Roam(), on_collision="continue", pose=None, start=start,
                       sensors=building.all_sensors() if i % 2 else {"encoder": building.encoder()})
        for i in range(4)
    ]  # fmt: skip
    things = [
        am.Obstacle(name=f"o{i:02d}", shape=SHAPES[i % 5], motion=MOTIONS[i % len(MOTIONS)], start=start)
        for i in range(21)
    ]
    room = building.room(8.0, 8.0, 0.01)

    def run(order: int, replicas: list[int]) -> am.Simulation:
        sim = am.Simulation(
            am.Scenario(map=room, robots=robots[::order], obstacles=things[::order], seed=4), replicas=replicas
        )
        sim.run(3.0)
        return sim

    there, back, many = run(1, [2]), run(-1, [2]), run(1, [0, 1, 2])
    assert there.digest() == back.digest()
    # Replicas never see each other's bodies: they stand in the same places, and nobody notices.
    assert many.digest(2) == there.digest(2) != many.digest(1)
    alike = [am.Obstacle(name=o.name, shape=o.shape, motion=o.motion, start=start) for o in things]
    others = [*alike, am.Obstacle(name="z", shape=am.Shape.circle(0.05), pose=am.Pose(x=0.2, y=0.2))]
    # Another obstacle makes another group and changes nobody, if nobody comes by it.
    again = am.Simulation(am.Scenario(map=room, robots=robots, obstacles=others, seed=4), replicas=[2])
    again.run(0.5)
    first = run_for(room, robots, things, 0.5)
    assert (again.robot("r0").true_pose == first.robot("r0").true_pose).all()


def run_for(room: am.Map, robots: list[am.Robot], things: list[am.Obstacle], seconds: float) -> am.Simulation:
    sim = am.Simulation(am.Scenario(map=room, robots=robots, obstacles=things, seed=4), replicas=[2])
    sim.run(seconds)
    return sim
