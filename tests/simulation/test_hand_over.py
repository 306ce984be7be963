"""Robots that go over from their controllers to a hand, and back, while a simulation runs."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import amorsim as am
from tests import building

USERS = """
import amorsim as am

class Counting:
    def __init__(self):
        self.calls = 0

    def command(self, readings, estimate, clock):
        self.calls += 1
        return am.Twist(forward=0.01 * self.calls, turn=0.2)
"""


class Counting:
    """Faster at every call, so that a call too many or too few shows."""

    def __init__(self) -> None:
        self.calls = 0

    def command(self, readings: Any, estimate: Any, clock: Any) -> am.Twist:
        self.calls += 1
        return am.Twist(forward=0.01 * self.calls, turn=0.2)


def fleet(count: int, **changes: Any) -> am.Simulation:
    robots = [
        building.robot(name=f"r{i}", controller=Counting, pose=am.Pose(x=1.0 + 1.2 * i, y=2.0), **changes)
        for i in range(count)
    ]
    return am.Simulation(building.scenario(*robots))


def steps(simulation: am.Simulation, count: int) -> None:
    for _ in range(count):
        simulation.step()


def test_a_robot_stands_until_the_hand_moves_it() -> None:
    simulation = fleet(1)
    steps(simulation, 5)
    simulation.hand_over("r0")
    robot = simulation.robot("r0")
    assert robot.is_by_hand
    steps(simulation, 1)
    before = robot.true_pose.copy()
    steps(simulation, 3)
    np.testing.assert_array_equal(robot.true_pose, before)
    robot.drive(forward=0.5)
    steps(simulation, 10)
    assert robot.true_pose[:2] - before[:2] == pytest.approx([0.5 * np.cos(before[2]), 0.5 * np.sin(before[2])])


def test_the_controller_goes_on_from_where_it_was() -> None:
    simulation, twin = fleet(1), fleet(1)
    steps(simulation, 5)
    simulation.hand_over("r0")
    steps(simulation, 7)
    simulation.hand_over("r0", "controller")
    steps(simulation, 4)
    steps(twin, 9)
    # Nine calls in both, none while the hand had it.
    frames = [s.frames()[0].command for s in (simulation, twin)]
    np.testing.assert_array_equal(*frames)


def test_others_of_its_group_do_not_notice() -> None:
    handed, left = fleet(3), fleet(3)
    for simulation in (handed, left):
        steps(simulation, 4)
    handed.hand_over("r1")
    for simulation in (handed, left):
        steps(simulation, 6)
    assert len(handed.frames()) == 1  # one group, or this tells nothing
    for name in ("r0", "r2"):
        np.testing.assert_array_equal(handed.robot(name).true_pose, left.robot(name).true_pose)
    assert (handed.robot("r1").true_pose != left.robot("r1").true_pose).any()


def test_draws_of_a_built_in_controller_are_the_same_without_its_neighbours() -> None:
    def roam(hand: bool) -> Any:
        robots = [
            building.robot(name=f"r{i}", controller=building.Roam(rate=1.0), pose=am.Pose(x=1.5 + 1.5 * i, y=2.0))
            for i in range(3)
        ]
        simulation = am.Simulation(building.scenario(*robots))
        steps(simulation, 15)
        if hand:
            simulation.hand_over("r0")
        steps(simulation, 15)
        return [simulation.robot(f"r{i}").true_pose.copy() for i in (1, 2)]

    np.testing.assert_array_equal(roam(True), roam(False))


def test_a_collision_does_not_end_a_hand_and_a_controller_may_be_revived() -> None:
    simulation = am.Simulation(
        building.scenario(building.robot(controller=lambda readings, estimate, clock: am.Twist(0.5, 0.0)))
    )
    robot = simulation.robot("rover")
    simulation.hand_over("rover")
    robot.drive(forward=2.0)
    steps(simulation, 40)
    assert [event.kind for event in simulation.events] == ["handed_over", "collision"]
    assert simulation.touching.tolist() == [True]
    robot.drive(forward=-1.0)
    steps(simulation, 20)
    assert simulation.touching.tolist() == [False]
    simulation.hand_over("rover", "controller")
    steps(simulation, 60)  # until it ends at the wall
    assert simulation.events[-1].kind == "controller_ended"
    assert not simulation.active.any()
    simulation.hand_over("rover", "controller")
    assert simulation.active.all()


def test_snapshots_and_resets_hold_who_drives() -> None:
    simulation = fleet(2)
    steps(simulation, 3)
    simulation.hand_over("r1")
    simulation.robot("r1").drive(forward=0.3)
    kept = simulation.snapshot()
    steps(simulation, 5)
    digest = simulation.digest()
    simulation.hand_over("r1", "controller")
    steps(simulation, 2)
    simulation.restore(kept)
    assert simulation.by_hand.tolist() == [False, True]
    steps(simulation, 5)
    assert simulation.digest() == digest
    simulation.reset()
    assert not simulation.by_hand.any()


def test_a_mistake_is_reported() -> None:
    simulation = fleet(1)
    with pytest.raises(am.AmorsimError, match="expected to hand it over to 'hand' or 'controller', got 'me'"):
        simulation.hand_over("r0", "me")
    with pytest.raises(am.AmorsimError, match=r"take the robot over with hand_over\('r0'\)"):
        simulation.robot("r0").drive(0.1)
    alone = am.Simulation(building.scenario(building.robot(controller=None)))
    alone.hand_over("rover")
    alone.robot("rover").drive(0.1)
    with pytest.raises(am.AmorsimError, match="has no controller"):
        alone.hand_over("rover", "controller")


@pytest.mark.long
def test_a_run_with_a_hand_in_between_reproduces(tmp_path: Path) -> None:
    (tmp_path / "users.py").write_text(USERS)
    (tmp_path / "room.wld").write_text(
        "width 6000\nheight 5000\n0 0 6000 0\n6000 0 6000 5000\n6000 5000 0 5000\n0 5000 0 0"
    )
    (tmp_path / "scenario.toml").write_text(
        """
        format = 1
        world = { map = "room.wld" }
        simulation = { duration = 4.0 }
        [[robots]]
        name = "a"
        model = "pioneer2dx"
        pose = { x = 1.5, y = 1.5 }
        controller = { use = "users.py:Counting" }
        [[robots]]
        name = "b"
        model = "pioneer2dx"
        pose = { x = 1.5, y = 3.5 }
        controller = { use = "users.py:Counting" }
        """
    )
    simulation = am.Simulation(am.load(tmp_path / "scenario.toml"))
    with am.record(simulation, tmp_path / "run") as session:
        for tick in range(40):
            if tick == 10:
                simulation.hand_over("b")
            if 12 <= tick < 25:
                simulation.robot("b").drive(forward=0.1 + 0.01 * tick, turn=-0.3)
            if tick == 25:
                simulation.hand_over("b", "controller")
            if tick == 30:
                simulation.hand_over("a")
            simulation.step()
            session.keep()
    outcome = am.reproduce(tmp_path / "run")
    assert outcome.is_exact, str(outcome)
    # Without the hand it would be another run, which the comparison notices.
    events = tmp_path / "run" / "events.csv"
    lines = events.read_text().splitlines(keepends=True)
    events.write_text("".join(line for line in lines if "handed_over" not in line))
    assert not am.reproduce(tmp_path / "run").is_same


def test_all_replicas_are_driven_at_once_as_they_are_one_by_one() -> None:
    robots = [
        building.robot(name="a", controller=am.controllers.Manual(speed=0.4)),
        building.robot(
            name="b",
            pose=am.Pose(x=3.0, y=3.0),
            controller=am.controllers.Pursuit(waypoints=((4.0, 4.0), (1.0, 4.0))),
        ),
    ]
    scenario = building.scenario(*robots)
    one, all_ = (am.Simulation(scenario, replicas=[4, 7, 9]) for _ in range(2))
    random = np.random.default_rng(2)
    for sim in (one, all_):
        for replica in (4, 7, 9):
            sim.hand_over("b", replica=replica)
    for _ in range(6):
        forward, turn = random.normal(size=(2, 3))
        for name in ("a", "b"):
            all_.drive(name, forward=forward, turn=turn)
            for k, replica in enumerate((4, 7, 9)):
                one.robot(name, replica).drive(forward=forward[k], turn=turn[k])
        one.step()
        all_.step()
    assert all_.digest() == one.digest()


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"name": "c"}, "no robot 'c'"),
        ({"name": np.zeros((2, 3))}, "no robot"),
        ({"name": "b"}, "only the 'manual' controller takes commands"),
        ({"name": "a", "forward": [1.0, 2.0, 3.0]}, "one for each of 2 replicas"),
        ({"name": "a", "turn": float("nan")}, "expected for forward, left and turn a finite number"),
        ({"name": "a", "left": 10**400}, "expected for forward, left and turn a finite number"),
        ({"name": "a", "left": "fast"}, "expected for forward, left and turn a finite number"),
    ],
)
def test_what_cannot_be_driven_is_refused(given: dict[str, Any], words: str) -> None:
    robots = [
        building.robot(name="a", controller=am.controllers.Manual()),
        building.robot(
            name="b",
            pose=am.Pose(x=3.0, y=3.0),
            controller=am.controllers.Pursuit(waypoints=((4.0, 4.0), (1.0, 4.0))),
        ),
    ]
    sim = am.Simulation(building.scenario(*robots), replicas=2)
    with pytest.raises(am.AmorsimError, match=words):
        sim.drive(**given)


def test_wrong_arguments_are_refused_in_words() -> None:
    scenario = building.scenario(building.robot(name="a"))
    sim = am.Simulation(scenario)
    wrong: list[tuple[str, Callable[[], Any]]] = [
        ("rows: expected numbers from 0 to 0", lambda: sim.truth([1])),
        ("rows: expected numbers from 0 to 0", lambda: sim.truth([-1])),
        ("progress: expected True or False", lambda: sim.run(0.1, progress=np.zeros(3))),  # type: ignore[arg-type]
        ("replicas", lambda: am.Simulation(scenario, replicas=np.array(2.0))),  # type: ignore[arg-type]
    ]
    for words, call in wrong:
        with pytest.raises(am.AmorsimError, match=words):
            call()


def test_what_no_robot_knows_is_refused() -> None:
    sim = am.Simulation(building.scenario(building.robot(name="a")))
    for name, words in (("b", "no robot 'b'"), ([], "expected the name of a robot"), (["a", "a"], "expected all")):
        with pytest.raises(am.AmorsimError, match=words):
            sim.known(name)
