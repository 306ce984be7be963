"""A contact that goes on is one collision, however often the bodies touch while it does."""

from __future__ import annotations

import math

import amorsim as am
from amorsim.core.shapes import Shape
from amorsim.simulation.contact.contact_ends import PARTED
from tests import building


def at_the_wall(replicas: int = 1, **changes: object) -> am.Simulation:
    """A round robot that leans on the wall at x = 6 m, looking at it."""
    given: dict[str, object] = {
        "shape": Shape.circle(0.2),
        "pose": am.Pose(x=5.7, y=2.5),
        "on_collision": "continue",
    }
    sim = am.Simulation(building.scenario(building.robot(**(given | changes))), replicas=replicas)
    go(sim, 1.0, 0.0, 3)
    assert [event.kind for event in sim.events] == ["collision"] * replicas
    return sim


def go(sim: am.Simulation, forward: float, turn: float, steps: int = 1) -> None:
    for name in sim.names:
        for replica in sim.replicas:
            sim.robot(name, replica).drive(forward, turn)
    for _ in range(steps):
        sim.step()


def gap(sim: am.Simulation) -> float:
    """How far [m] the robot is from the wall, whose cells begin at x = 5.999 m."""
    return 5.999 - 0.2 - float(sim.true_pose[0, 0])


def wriggle(sim: am.Simulation, steps: int) -> None:
    """Turn on the spot in one step, and press on in the next."""
    for i in range(steps):
        go(sim, 0.0, 0.1 if i % 4 < 2 else -0.1)
        assert not sim.touching.any()
        go(sim, 0.2, 0.0)
        assert sim.touching.all()


def test_turning_and_pressing_on_by_turns_is_one_contact() -> None:
    sim = at_the_wall()
    wriggle(sim, 20)
    assert len(sim.events) == 1


def test_sliding_along_a_wall_is_one_contact() -> None:
    """It presses against the wall, turns off it when it touches, and leaves it by less than a millimetre each time."""
    sim = at_the_wall(pose=am.Pose(x=5.7, y=0.5, heading=0.0))
    sim.set_pose("rover", (5.79, 0.5, math.pi / 2))
    touched, apart = 0, 0.0
    for _ in range(300):
        heading = float(sim.true_pose[0, 2]) - math.pi / 2
        go(sim, 0.0 if sim.touching[0] else 0.1, 0.2 if sim.touching[0] else -1.0 * (heading + 0.02))
        was_there = touched > 0
        touched += int(sim.touching[0])
        apart = max(apart, gap(sim)) if was_there else 0.0
    assert touched > 10
    assert 1e-5 < apart < PARTED
    assert sim.true_pose[0, 1] > 1.0
    assert [event.kind for event in sim.events] == ["collision", "pose_set", "collision"]


def test_those_that_parted_meet_again() -> None:
    sim = at_the_wall()
    for apart, events in ((0.9 * PARTED, 1), (1.1 * PARTED, 2)):
        go(sim, -apart / sim.dt, 0.0)
        assert abs(gap(sim) - apart) < 1e-9
        go(sim, 0.5, 0.0, 2)
        assert sim.touching.all()
        assert len(sim.events) == events


def test_two_that_push_one_another_met_once() -> None:
    pair = [
        building.robot(
            name=name, shape=Shape.circle(0.2), pose=am.Pose(x=x, y=2.0, heading=heading), on_collision="continue"
        )
        for name, x, heading in (("east", 2.0, 0.0), ("west", 3.0, math.pi))
    ]
    sim = am.Simulation(building.scenario(*pair))
    go(sim, 1.0, 0.0, 5)
    wriggle(sim, 5)
    assert [(event.name, event.other) for event in sim.events] == [("east", "west"), ("west", "east")]
    go(sim, -0.5, 0.0, 2)
    go(sim, 0.5, 0.0, 3)
    assert len(sim.events) == 4


def test_a_snapshot_keeps_what_is_in_contact() -> None:
    sim = at_the_wall()
    go(sim, 0.0, 0.1)
    assert not sim.touching.any()
    kept = sim.snapshot()
    go(sim, -1.0, 0.0, 3)
    sim.restore(kept)
    wriggle(sim, 2)
    assert len(sim.events) == 1
    fresh = am.Simulation(sim.scenario)
    fresh.restore(kept.to_bytes())
    wriggle(fresh, 2)
    assert len(fresh.events) == 1


def test_one_replica_starts_again_and_the_other_goes_on() -> None:
    sim = at_the_wall(replicas=2)
    sim.reset(replicas=[1])
    assert [event.replica for event in sim.events] == [0]
    go(sim, 0.0, 0.1)
    go(sim, 1.0, 0.0, 3)
    assert [event.replica for event in sim.events] == [0, 1]


def test_a_body_put_elsewhere_or_handed_over_meets_again() -> None:
    sim = at_the_wall()
    sim.set_pose("rover", sim.true_pose[0] - (1e-4, 0.0, 0.0))
    go(sim, 0.5, 0.0)
    assert [event.kind for event in sim.events] == ["collision", "pose_set", "collision"]

    goes_on = building.robot(
        pose=am.Pose(x=5.7, y=2.5), controller=lambda readings, estimate, clock: am.Twist(0.5, 0.0)
    )
    sim = am.Simulation(building.scenario(goes_on))
    sim.run(1.0)
    assert [event.kind for event in sim.events] == ["collision", "controller_ended"]
    sim.hand_over("rover")
    sim.step()
    sim.hand_over("rover", "controller")
    sim.step()
    assert [event.kind for event in sim.events[-3:]] == ["handed_over", "collision", "controller_ended"]


def test_a_robot_that_has_left_the_wall_has_no_contact() -> None:
    sim = at_the_wall()
    assert sim._fleet.contacts
    go(sim, -1.0, 0.0)
    assert not sim._fleet.contacts


def test_one_that_creeps_away_without_a_look_at_walls_has_parted_too() -> None:
    sim = at_the_wall()
    for _ in range(200):
        go(sim, -1e-4, 0.0)
        assert bool(sim._fleet.contacts) == (gap(sim) <= PARTED)
    assert gap(sim) > 1.5 * PARTED
