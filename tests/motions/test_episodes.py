"""All motions in one world: a replica that starts again leaves the others as they are, and is as if it were alone."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import amorsim as am
from amorsim.contracts import Motion
from amorsim.core.shapes import Shape
from tests import building

WAYS = ((1.0, 1.0), (3.0, 1.0), (3.0, 2.0))


class Patrol:
    """To and fro, counting its steps for itself."""

    def __init__(self) -> None:
        self.steps = 0

    def velocity(self, obstacle: am.motions.ObstacleState) -> tuple[float, float]:
        self.steps += 1
        return (0.0, 0.7) if self.steps % 14 < 7 else (0.0, -0.7)


def drift(obstacle: am.motions.ObstacleState) -> tuple[float, float, float]:
    nearest = np.hypot(*(obstacle.others[:, :2] - [obstacle.x, obstacle.y]).T).min()
    return (0.3, 0.1, 1.0) if nearest > 0.6 else (-0.3, 0.2, -1.0)


def everything(folder: Path) -> am.Scenario:
    """Obstacles of every kind of motion, in each other's way and a robot's, some of which start at random."""
    (folder / "walk.csv").write_text("time,x,y\n0,7.0,1.0\n2,7.0,3.0\n3,6.0,3.0\n")
    m = am.motions
    motions: dict[str, Motion] = {
        "waypoints": m.Waypoints(waypoints=WAYS, speed=1.0),
        "loop": m.Loop(waypoints=((4.0, 1.0), (6.0, 1.0), (5.0, 2.0)), speed=1.5, pause=0.3, blocked="skip"),
        "oscillate": m.Oscillate(waypoints=((1.0, 4.0), (4.0, 4.0)), speed=1.2),
        "track": m.Track(file=str(folder / "walk.csv"), repeat=True),
        "wander": m.Wander(speed=0.8),
        "walker": m.Pedestrian(goals=((1.0, 7.0), (8.0, 7.0)), order="random"),
        "other": m.Pedestrian(goals=((8.0, 7.0), (1.0, 7.0)), blocked="skip", patience=0.2),
        "object": am.Obstacle(name="x", shape=Shape.circle(0.1), motion=Patrol).motion,
        "function": am.Obstacle(name="x", shape=Shape.circle(0.1), motion=drift).motion,
        "swing": m.SwingDoor(timetable=((0.4, 1.7),), period=3.0, blocked="skip"),
        "slide": m.SlidingDoor(timetable=((0.2, 1.0),), blocked="skip", patience=0.1),
    }
    places = {"walker": (2.0, 7.0), "other": (7.0, 7.0), "object": (4.5, 5.5), "function": (6.0, 5.0)}
    places |= {"swing": (8.5, 4.0), "slide": (2.5, 2.6)}
    obstacles = []
    for name, motion in motions.items():
        given = {"pose": am.Pose(x=places[name][0], y=places[name][1])} if name in places else {}
        start = am.RandomStart(random=(1.0, 8.0, 8.0, 9.0)) if name == "wander" else None
        shape = Shape.rectangle(0.8, 0.1, x=0.4) if name in ("swing", "slide") else Shape.circle(0.25)
        obstacles.append(am.Obstacle(name=name, shape=shape, motion=motion, start=start, **given))
    rover = building.robot(
        pose=None,
        start=am.RandomStart(random=(3.0, 4.6, 8.0, 8.0)),
        controller=building.Roam(),
        sensors=building.all_sensors(),
        on_collision="continue",
    )
    return am.Scenario(map=building.room(10.0, 10.0, 0.01), robots=[rover], obstacles=obstacles, dt=0.1, seed=4)


def run(sim: am.Simulation, steps: int = 30) -> am.Simulation:
    for _ in range(steps):
        sim.step()
    return sim


def places(sim: am.Simulation, replica: int) -> dict[str, np.ndarray]:
    names = sorted(obstacle.name for obstacle in sim.scenario.obstacles)
    return {name: sim.obstacle(name, replica).true_pose.copy() for name in names}


@pytest.mark.long
def test_a_replica_starts_again_and_leaves_the_others(tmp_path: Path) -> None:
    made = everything(tmp_path)
    sim = am.Simulation(made, replicas=3)
    first = places(sim, 1)
    moved = set()
    for _ in range(30):
        sim.step()
        moved |= {name for name, place in places(sim, 1).items() if (place != first[name]).any()}
    assert moved == set(first)
    assert {event.name for event in sim.events} >= {"rover"}
    others = [event for event in sim.events if event.replica != 1]
    sim.reset(replicas=[1])
    assert sim.ticks.tolist() == [30, 0, 30]
    again = places(sim, 1)
    drawn = {obstacle.name for obstacle in made.obstacles if obstacle.start is not None}
    assert drawn
    for name, place in first.items():
        assert (again[name] == place).all() == (name not in drawn)  # a random start is drawn again
    assert sim.events == others
    run(sim)
    undisturbed = run(am.Simulation(made, replicas=3), 60)
    for replica in (0, 2):
        np.testing.assert_equal(places(sim, replica), places(undisturbed, replica))
        assert sim.digest(replica) == undisturbed.digest(replica)
    alone = run(am.Simulation(made, replicas=[1]))
    alone.reset()
    run(alone)
    np.testing.assert_equal(places(sim, 1), places(alone, 1))
    assert sim.digest(1) == alone.digest(1)
    assert sim.digest(1) != undisturbed.digest(1)  # another episode, other draws


@pytest.mark.parametrize("replicas", [1, 3])
def test_a_snapshot_in_the_middle_holds_all_motions(tmp_path: Path, replicas: int) -> None:
    sim = run(am.Simulation(everything(tmp_path), replicas=replicas), 13)
    snapshot = sim.snapshot()
    wanted = run(sim).digest()
    sim.restore(snapshot)
    assert run(sim).digest() == wanted


def test_a_seed_starts_all_again(tmp_path: Path) -> None:
    sim = run(am.Simulation(everything(tmp_path), replicas=2))
    sim.reset(seed=9)
    assert run(sim).digest() == run(am.Simulation(everything(tmp_path), replicas=2, seed=9)).digest()
