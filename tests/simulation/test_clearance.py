"""The clearance that is kept of every body: never more than its gap, and without it the bits are the same."""

from __future__ import annotations

import contextlib
from typing import Any

import attrs
import numpy as np
import pytest
from hypothesis import HealthCheck, example, given
from hypothesis import strategies as st

import amorsim as am
from amorsim.contracts import Drive
from amorsim.drives.differential import Differential
from amorsim.motions import Loop, Pedestrian, SwingDoor, Wander
from amorsim.simulation.contact import resolve as contact
from tests import building
from tests.examples import settings
from tests.simulation.rigs import rig, tractor


@attrs.frozen(kw_only=True)
class Other(Differential):
    """The same drive, but one whose paths only it knows."""

    def displacement(self, before: Any, after: Any, fraction: Any) -> Any:
        return Drive.displacement(self, before, after, fraction)


MOTIONS = (
    None,
    Wander(speed=1.0),
    Loop(waypoints=((1.0, 1.0), (7.0, 7.0)), speed=3.0, blocked="skip", patience=0.1),
    Pedestrian(goals=((1.0, 1.0), (7.0, 7.0)), order="random", blocked="skip", patience=0.5),
    SwingDoor(timetable=((0.0, 0.6),), period=1.0, rate=3.0),
)


def world_of(seed: int, robots: int, obstacles: int, dt: float, rate: float) -> am.Simulation:
    """Two replicas of a room with robots, some with trailers and some on paths of their own, and obstacles."""
    rng = np.random.default_rng(seed)
    places = [(0.9 + 1.8 * (n % 5), 0.9 + 1.8 * (n // 5)) for n in rng.permutation(25)]
    fleet = []
    for i in range(robots):
        x, y = places.pop()
        given: dict[str, Any] = {
            "name": f"r{i:02}",
            "controller": building.Roam(rate=float(rng.uniform(0.2, 1.0)) * rate),
            "on_collision": "continue",
        }
        pose = am.Pose(x=x, y=y, heading=float(rng.uniform(-3.0, 3.0)))
        if i % 3 == 1:
            small = {"trailer_length": 0.35, "hitch_offset": 0.1, "trailer_width": 0.2, "trailer_rear": 0.1}
            drive: Drive = tractor(**small, trailer_front=0.05)
            fleet.append(rig(**given, pose=pose, shape=am.Shape.circle(0.15), drive=drive))
        else:
            kind = Other if i % 3 == 2 else Differential
            drive = kind(**attrs.asdict(building.drive(), recurse=False))
            fleet.append(building.robot(**given, pose=pose, drive=drive))
    things = [
        am.Obstacle(
            name=f"o{i:02}",
            shape=(am.Shape.circle(0.2), am.Shape.rectangle(0.5, 0.1))[i % 2],
            pose=am.Pose(x=places[i][0], y=places[i][1], heading=float(rng.uniform(-3.0, 3.0))),
            motion=MOTIONS[int(rng.integers(len(MOTIONS)))],
        )
        for i in range(obstacles)
    ]
    room = building.room(9.0, 9.0, 0.01)
    return am.Simulation(building.scenario(*fleet, obstacles=things, map=room, dt=dt, seed=seed), replicas=2)


def same(one: am.Simulation, two: am.Simulation) -> None:
    assert one._fleet.world.poses.tobytes() == two._fleet.world.poses.tobytes()
    assert one._fleet.touching == two._fleet.touching
    assert one._fleet.contacts == two._fleet.contacts


def check_bounds(sim: am.Simulation) -> None:
    """What is recorded of poses at which the bodies are is no more than their gaps, but for rounding."""
    world = sim._fleet.world
    record = world.clearance
    holds = (record.at == world.poses).all(axis=1).reshape(2, -1).all(axis=1).repeat(world.count)
    far = np.full(len(world.everyone), 100.0)
    gaps, _ = world.wall_gaps(world.everyone, world.poses, far)
    assert (record.walls[holds] <= np.maximum(gaps[holds], 0.0)).all()
    first, second = np.triu_indices(world.count, 1)
    for start in world.first[:-1]:
        a, b = start + first, start + second
        apart = world.owner[a] != world.owner[b]
        a, b = a[apart], b[apart]
        gaps = world.body_gaps(a, world.poses[a], b, world.poses[b], np.full(len(a), 100.0))
        for body in (a, b):
            assert (record.others[body] <= np.maximum(gaps, 0.0))[holds[body]].all()


CHANGES = ("steps", "steps", "steps", "reset", "restore", "teleport", "set", "by hand")


def change(sim: am.Simulation, what: str, number: int, kept: list[am.Snapshot]) -> None:
    """One of `CHANGES`, by its number; what the simulation refuses is refused."""
    name, replica = sim.names[number % len(sim.names)], number % 2
    if what == "reset":
        sim.reset(replicas=None if number % 3 == 0 else [replica])
    elif what == "restore":
        kept.append(sim.snapshot())
        sim.restore(kept[number % len(kept)])
    elif what == "teleport":
        at = np.random.default_rng(number).uniform((0.3, 0.3, -3.0), (8.7, 8.7, 3.0))
        with contextlib.suppress(am.AmorsimError):  # it would overlap something
            sim.set_pose(name, at.tolist(), replica=replica)
    elif what == "set":
        with contextlib.suppress(am.AmorsimError):  # with it the robot would overlap something
            sim.set(name, "drive.wheel_radius_left", 0.05 + 0.001 * (number % 100))
    elif what == "by hand":
        sim.hand_over(name, replica=replica)
        sim.robot(name, replica=replica).drive(forward=1.0 + number % 7)


@pytest.mark.long
@settings(max_examples=12, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(
    seed=st.integers(0, 2**32 - 1),
    robots=st.integers(1, 9),
    obstacles=st.integers(0, 12),
    dt=st.sampled_from([0.02, 0.1, 0.5]),
    rate=st.sampled_from([2.0, 10.0, 60.0]),
    changes=st.lists(st.tuples(st.sampled_from(CHANGES), st.integers(0, 10**6)), min_size=3, max_size=8),
)
@example(seed=0, robots=4, obstacles=6, dt=0.5, rate=60.0, changes=[("steps", 0)] * 4 + [("set", 1)])
def test_a_world_with_records_has_the_bits_of_one_that_drops_them_every_step(
    seed: int, robots: int, obstacles: int, dt: float, rate: float, changes: list[tuple[str, int]]
) -> None:
    kept, dropped = (world_of(seed, robots, obstacles, dt, rate) for _ in range(2))
    snapshots: tuple[list[am.Snapshot], list[am.Snapshot]] = ([], [])
    for what, number in [*changes, ("steps", 1)]:
        for sim, mine in zip((kept, dropped), snapshots, strict=True):
            change(sim, what, number, mine)
        for _ in range(6):
            dropped._fleet.world.clearance.at.fill(np.nan)
            kept.step()
            dropped.step()
            same(kept, dropped)
            check_bounds(kept)
    assert kept.events == dropped.events
    assert kept.digest() == dropped.digest()


def count_looks(sim: am.Simulation, steps: int, monkeypatch: pytest.MonkeyPatch) -> int:
    """How many bodies look around in some steps."""
    looks = [0]
    look_around = contact.look_around

    def counted(first: int, last: int, *given: Any) -> None:
        looks[0] += last - first
        look_around(first, last, *given)

    monkeypatch.setattr(contact, "look_around", counted)
    for _ in range(steps):
        sim.step()
    monkeypatch.undo()
    return looks[0]


def test_bodies_far_apart_seldom_look_around(monkeypatch: pytest.MonkeyPatch) -> None:
    """Robots, pedestrians and trailers in a field: each looks about once in 32 steps, as far ahead as it looks."""
    robots = [building.robot(name=f"r{i}", pose=am.Pose(x=-20.0 + 10.0 * i, y=0.0)) for i in range(3)]
    rigs = [rig(f"t{i}", x=-20.0 + 10.0 * i, y=10.0) for i in range(3)]
    posts = [am.Obstacle(name=f"o{i}", shape=am.Shape.circle(0.2), pose=am.Pose(x=5.0 * i, y=20.0)) for i in range(3)]
    straight = Wander(speed=1.0, course_std=0.0)
    walkers = [attrs.evolve(post, name=f"w{i}", pose=am.Pose(x=5.0 * i, y=30.0), motion=straight)
               for i, post in enumerate(posts)]  # fmt: skip
    sim = am.Simulation(building.scenario(*robots, *rigs, obstacles=[*posts, *walkers], map=building.empty(), dt=0.02))
    for name in sim.names:
        sim.robot(name).drive(forward=1.0)
    sim.run(1.0)  # until they have set out
    moving = 3 + 2 * 3 + 3
    assert 0 < count_looks(sim, 96, monkeypatch) <= 4 * moving


def test_who_stands_does_not_look_around(monkeypatch: pytest.MonkeyPatch) -> None:
    """One robot drives through a forest of posts that all but touch one another."""
    posts = [
        am.Obstacle(name=f"o{i:03}", shape=am.Shape.circle(0.2), pose=am.Pose(x=0.41 * i - 20.0, y=-2.0))
        for i in range(100)
    ]
    robot = building.robot(pose=am.Pose(x=-20.0, y=0.0, heading=0.0))
    sim = am.Simulation(building.scenario(robot, obstacles=posts, map=building.empty(), dt=0.02))
    sim.robot("rover").drive(forward=1.0)
    assert count_looks(sim, 100, monkeypatch) <= 100


def test_a_robot_put_in_the_way_of_another_is_met() -> None:
    """Both had room all around them, and the other was not moved."""
    fleet = [building.robot(name=name, pose=am.Pose(x=x, y=0.0)) for name, x in (("one", 0.0), ("two", 50.0))]
    sim = am.Simulation(building.scenario(*fleet, map=building.empty(), dt=0.02))
    for name in sim.names:
        sim.robot(name).drive(forward=0.5)
    sim.run(2.0)
    x = float(sim.robot("two").true_pose[0])
    sim.set_pose("one", (x + 0.6, 0.0, 0.0))
    sim.robot("one").drive(forward=0.0)
    sim.run(1.0)
    assert [event.other for event in sim.events if event.kind == "collision"] == ["two", "one"]
    assert sim.robot("one").true_pose[0] - sim.robot("two").true_pose[0] == pytest.approx(0.5, abs=1e-9)
