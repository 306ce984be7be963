"""Obstacles that move: each as its own motion says, checked, and part of the digest."""

from __future__ import annotations

import attrs
import numpy as np
import pytest

import amorsim as am
from amorsim.contracts import Draws, Motion, State, View, parameter
from amorsim.core.shapes import Shape
from tests import building


@attrs.frozen(kw_only=True)
class Push(Motion):
    """Wants to go on at one speed, along a way that is fixed by its static field."""

    speed: float = parameter(0.5, unit="m/s")
    way: str = parameter("x", choices=("x", "y", "nowhere", "flat"), static=True)

    def propose(self, view: View, dt: float, state: State, draws: Draws) -> np.ndarray:
        if self.way == "flat":
            return np.zeros(view.rows)
        moved = np.zeros((view.rows, 3))
        moved[:, "xy".find(self.way)] = (self.speed * dt)[:, 0]
        return moved * (np.nan if self.way == "nowhere" else 1.0)


def post(name: str, x: float, y: float, motion: Motion | None) -> am.Obstacle:
    return am.Obstacle(name=name, shape=Shape.circle(0.2), pose=am.Pose(x=x, y=y), motion=motion)


def world(*obstacles: am.Obstacle, **changes: object) -> am.Simulation:
    robot = building.robot(on_collision="continue", **changes)
    return am.Simulation(building.scenario(robot, obstacles=obstacles))


def test_each_follows_its_own_motion() -> None:
    sim = world(post("a", 1.0, 4.0, Push()), post("b", 4.0, 1.0, Push(way="y", speed=0.2)), post("c", 5.0, 4.0, None))
    sim.run(2.0)
    assert sim.obstacle("a").true_pose == pytest.approx([2.0, 4.0, 0.0])
    assert sim.obstacle("b").true_pose == pytest.approx([4.0, 1.4, 0.0])
    assert sim.obstacle("b").true_twist == pytest.approx([0.0, 0.2, 0.0])
    assert sim.obstacle("c").true_pose == pytest.approx([5.0, 4.0, 0.0])
    with pytest.raises(am.AmorsimError, match="no obstacle 'd'; known obstacles: a, b, c"):
        sim.obstacle("d")


def test_they_are_part_of_the_digest() -> None:
    slow, fast = world(post("a", 1.0, 4.0, Push(speed=0.1))), world(post("a", 1.0, 4.0, Push(speed=0.2)))
    assert slow.digest() == fast.digest()
    slow.step()
    fast.step()
    assert slow.digest() != fast.digest()


def test_a_snapshot_holds_them() -> None:
    sim = world(post("a", 1.0, 4.0, Push()))
    sim.run(0.5)
    snapshot = sim.snapshot()
    sim.run(1.0)
    digest = sim.digest()
    sim.restore(snapshot)
    assert sim.obstacle("a").true_pose[0] == pytest.approx(1.25)
    sim.run(1.0)
    assert sim.digest() == digest


def test_leaning_is_one_collision_until_they_part() -> None:
    sim = world(post("a", 1.0, 2.0, Push()), pose=am.Pose(x=2.0, y=2.0))
    sim.run(3.0)
    assert [event.name for event in sim.events if event.kind == "collision"] == ["rover", "a"]
    sim.robot("rover").drive(forward=1.0)  # away, and then wait for it
    sim.run(0.3)
    sim.robot("rover").drive()
    sim.run(3.0)
    assert [event.name for event in sim.events if event.kind == "collision"] == ["rover", "a"] * 2


def test_leaning_survives_a_snapshot() -> None:
    sim = world(post("a", 1.0, 2.0, Push()), pose=am.Pose(x=2.0, y=2.0))
    sim.run(3.0)
    count = len(sim.events)
    snapshot = sim.snapshot()
    sim.run(0.5)
    sim.restore(snapshot)
    sim.run(0.5)
    assert len(sim.events) == count


@pytest.mark.parametrize("way", ["nowhere", "flat"])
def test_a_motion_that_proposes_nonsense_is_named(way: str) -> None:
    sim = world(post("a", 1.0, 4.0, Push(way=way)))
    with pytest.raises(
        am.ComponentError, match=r"motion \(Push\) of obstacle 'a' at .*: expected (finite|displacements)"
    ):
        sim.step()


def test_what_fixes_shapes_cannot_be_set() -> None:
    robot = building.robot(sensors=building.all_sensors())
    sim = am.Simulation(building.scenario(robot))
    for path in ("sensors.laser.latency", "sensors.laser.beams"):
        with pytest.raises(am.AmorsimError, match="fixed once a simulation is made"):
            sim.set("rover", path, 3)
    with pytest.raises(am.AmorsimError, match=r"no entry 'lasr'; .*[Dd]id you mean 'laser'"):
        sim.set("rover", "sensors.lasr.range_max", 3.0)
    with pytest.raises(am.AmorsimError, match=r"range_max: expected a number \[m\] > 0, got -1.0|expected a number"):
        sim.set("rover", "sensors.laser.range_max", -1.0)
    sim.set("rover", "sensors.laser.range_max", 0.5)
    sim.set("rover", "sensors.laser.noise.gaussian.std", 0.0)
    sim.step()
    assert not np.isfinite(sim.robot("rover").readings["laser"].true).all()
    assert [event.kind for event in sim.events] == ["parameter_set"] * 2
