"""Pedestrians: at their speed in the open, off the walls, around one another and around robots, if they are set to."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import amorsim as am
from amorsim.motions import Pedestrian
from tests import building
from tests.motions.worlds import DT, obstacle, track, world

CALM = {"velocity_noise": 0.0, "speed_std": 0.0}
BODY = am.Shape.circle(0.22)


def walker(name: str, x: float, y: float, **changes: object) -> am.Obstacle:
    return obstacle(Pedestrian(**(CALM | changes)), name=name, shape=BODY, pose=am.Pose(x=x, y=y))


def test_he_takes_up_his_speed_exponentially_and_comes_to_his_goal() -> None:
    # In the middle of a large room walls push by less than 1e-9 m/s^2.
    sim = world(walker("thing", 4.0, 10.0, goals=((14.0, 10.0),)), size=20.0)
    poses = track(sim, 120)
    speeds = np.diff(poses[:, 0]) / DT
    time = DT * np.arange(1, 21)
    assert poses[1:21, 0] - 4.0 == pytest.approx(1.34 * (time - 0.5 * (1.0 - np.exp(-time / 0.5))), abs=1e-7)
    assert poses[-1, 0] == pytest.approx(14.0, abs=0.75)  # at the last goal he stands
    assert speeds[-1] < 0.01


def gone(
    dt: float,
    *,
    duration: float = 3.0,
    start: float = 4.0,
    robot: am.Robot | None = None,
    post: float | None = None,
    **changes: object,
):
    """Where he is after some time, in steps of `dt`; 2 m on, a post may stand as far [m] to his left."""
    walk = walker("thing", start, 10.0, **changes)
    posts = [] if post is None else [am.Obstacle(name="post", shape=BODY, pose=am.Pose(x=start + 2.0, y=10.0 + post))]
    robot = robot or building.robot(pose=am.Pose(x=1.0, y=1.0), on_collision="continue")
    sim = am.Simulation(building.scenario(robot, map=building.room(20.0, 20.0, 0.01), obstacles=[walk, *posts], dt=dt))
    sim.run(duration)
    assert not sim.events
    return sim.obstacle("thing").true_pose[:2].copy()


@pytest.mark.parametrize("dt", [0.02, 0.1, 0.5])
def test_in_the_open_his_way_does_not_depend_on_the_step(dt: float) -> None:
    expected = 1.34 * (3.0 - 0.5 * (1.0 - np.exp(-3.0 / 0.5)))
    assert gone(dt, goals=((14.0, 10.0),)) == pytest.approx([4.0 + expected, 10.0], abs=1e-7)


def test_before_a_wall_his_way_depends_on_the_step_by_its_square() -> None:
    """He walks up to a wall: after 2.2 s he is where it brakes him hardest."""
    true = gone(0.0125, start=16.7, duration=2.2)[0]
    coarse, fine = (gone(dt, start=16.7, duration=2.2)[0] - true for dt in (0.1, 0.05))
    assert abs(coarse) < 0.01
    assert abs(fine) < 0.4 * abs(coarse)


@pytest.mark.parametrize(
    ("case", "largest"),
    [
        ({"post": 0.5}, 0.002),
        ({"post": 1.0}, 0.0002),
        ({"post": 0.5, "relative": True}, 0.004),
        ({"goals": ((6.0, 10.0), (6.0, 14.0))}, 0.0004),
    ],
)
def test_past_what_stands_and_round_a_goal_his_way_depends_on_the_step_by_its_square(
    case: dict[str, object], largest: float
) -> None:
    """The post goes out of his sight within a step, and within a step he reaches the goal at which he turns."""
    case = {"goals": ((14.0, 10.0),)} | case
    true = gone(0.01, **case)
    coarse, fine = (np.hypot(*(gone(dt, **case) - true)) for dt in (0.1, 0.05))
    assert coarse < largest
    assert fine < 0.4 * coarse


def test_wavering_spreads_him_alike_at_any_step() -> None:
    """Without a wish, the Ornstein-Uhlenbeck process and its integral: their variances, over 400 replicas."""
    tau, waver, time = 0.5, 0.1, 2.0
    gone_ = 1.0 - np.exp(-time / tau)
    expected = waver**2 * tau**3 * (time / tau - gone_ - 0.5 * gone_**2)
    for dt in (0.05, 0.5):
        walk = walker("thing", 10.0, 10.0, speed=1.0, goals=((10.0, 10.0),), order="once", velocity_noise=waver)
        robot = building.robot(pose=am.Pose(x=1.0, y=1.0))
        room = building.room(20.0, 20.0, 0.01)
        sim = am.Simulation(building.scenario(robot, map=room, obstacles=[walk], dt=dt), replicas=400)
        sim.run(time)
        (group,) = sim._fleet.obstacles
        spread = group.true_pose[:, :2].var(axis=0)
        assert spread == pytest.approx([expected, expected], rel=5.0 * np.sqrt(2.0 / 400))


def test_desired_speeds_are_spread_over_pedestrians() -> None:
    # 300 replicas: the mean of 300 draws is within 4 * 0.26 / sqrt(300), their deviation within 4 / sqrt(600) of it.
    sim = world(walker("thing", 10.0, 10.0, goals=((18.0, 10.0),), speed_std=0.26), size=20.0, replicas=300)
    sim.step()
    speeds = sim._fleet.obstacles[0].state["speed"][:, 0]
    assert np.mean(speeds) == pytest.approx(1.34, abs=4 * 0.26 / np.sqrt(300))
    assert np.std(speeds) == pytest.approx(0.26, rel=4 / np.sqrt(600))


def test_without_goals_he_goes_on_as_he_looks_and_walls_keep_him_off() -> None:
    sim = world(walker("thing", 7.0, 5.0), robot=building.robot(pose=am.Pose(x=1.0, y=9.0)))
    poses = track(sim, 100)
    assert poses[:, 1] == pytest.approx(5.0, abs=1e-6)
    # Before the wall its push and his drive cancel: 10 / 0.2 exp(-d / 0.2) = 1.34 / 0.5.
    assert 10.0 - poses[-1, 0] == pytest.approx(0.2 * np.log(50.0 / 2.68), abs=0.02)
    assert not sim.events


@pytest.mark.parametrize("avoids", [True, False])
def test_he_goes_round_a_robot_or_does_not_mind_it(avoids: bool) -> None:
    robot = building.robot(shape=am.Shape.circle(0.3), pose=am.Pose(x=5.0, y=5.05), on_collision="continue")
    sim = world(walker("thing", 2.0, 5.0, goals=((8.0, 5.0),), avoid_robots=avoids, relative=True), robot=robot)
    poses = track(sim, 80)
    met = {event.other for event in sim.events if event.name == "thing"}
    if avoids:
        assert not met
        assert poses[-1, 0] > 7.0
        assert poses[:, 1].min() < 4.7
    else:
        assert met == {"rover"}
        assert poses[-1, 0] < 4.6


def test_two_that_meet_pass_one_another() -> None:
    a = walker("a", 3.0, 5.0, goals=((8.0, 5.0),))
    b = walker("b", 8.0, 5.1, goals=((3.0, 5.0),))
    sim = world(a, b)
    ways = []
    for _ in range(70):
        sim.step()
        ways.append([sim.obstacle(name).true_pose[:2].copy() for name in "ab"])
    ways = np.array(ways)
    assert not sim.events
    assert np.linalg.norm(ways[:, 0] - ways[:, 1], axis=1).min() > 0.44
    assert ways[-1, 0, 0] > 7.0
    assert ways[-1, 1, 0] < 4.0


@pytest.mark.parametrize(("width", "passes"), [(0.8, False), (1.0, True)])
def test_a_route_through_a_door_and_how_narrow_it_may_be(width: float, passes: bool, tmp_path: Path) -> None:
    """As the docs say: goals on either side of a door lead through it, but not through one of 0.8 m."""
    low, high = round(3000 - 500 * width), round(3000 + 500 * width)
    outer = "0 0 8000 0\n8000 0 8000 6000\n8000 6000 0 6000\n0 6000 0 0\n"
    (tmp_path / "gate.wld").write_text(f"{outer}4000 0 4000 {low}\n4000 {high} 4000 6000\n", encoding="utf-8")
    goals = ((3.6, 3.0), (4.6, 3.0), (6.5, 4.5))
    motion = Pedestrian(goals=goals, order="once", relative=True, step_time=1.0, tolerance=0.4, **CALM)
    walk = obstacle(motion, shape=am.Shape.circle(0.2), pose=am.Pose(x=1.5, y=1.5))
    robot = building.robot(pose=am.Pose(x=1.0, y=5.0))
    gate = am.load_map(tmp_path / "gate.wld", resolution=0.02)
    sim = am.Simulation(building.scenario(robot, map=gate, obstacles=[walk], dt=DT))
    sim.run(15.0)
    assert (sim.obstacle("thing").true_pose[0] > 4.4) == passes


def test_goals_in_turn_and_at_random_and_given_up() -> None:
    goals = ((2.0, 5.0), (5.0, 8.0), (8.0, 5.0))
    sim = world(walker("thing", 5.0, 5.0, goals=goals, order="random"), replicas=60)
    sim.step()
    goal = sim._fleet.obstacles[0].state["goal"]
    assert set(goal.ravel().tolist()) == {0, 1, 2}
    seen = [set() for _ in range(60)]
    last, changed = goal.copy(), 0
    for _ in range(150):
        sim.step()
        goal = sim._fleet.obstacles[0].state["goal"]
        changed += int((goal != last).sum())
        last = goal.copy()
        for row, number in enumerate(goal[:, 0].tolist()):
            seen[row].add(number)
    assert changed > 60
    assert sum(len(numbers) == 3 for numbers in seen) > 10
    once = track(world(walker("thing", 5.0, 5.0, goals=goals, order="once")), 150)
    assert once[-1, :2] == pytest.approx([8.0, 5.0], abs=0.8)


def test_a_crowd_is_the_same_alone_and_among_replicas_and_after_a_snapshot() -> None:
    crowd = am.load("crowd")
    many = am.Simulation(crowd, replicas=[0, 5])
    alone = am.Simulation(crowd, replicas=[5])
    for sim in (many, alone):
        sim.run(1.0)
    snapshot = many.snapshot()
    for sim in (many, alone):
        sim.run(1.0)
    digest = many.digest(5)
    assert alone.digest(5) == digest != many.digest(0)
    many.restore(snapshot)
    many.run(1.0)
    assert many.digest(5) == digest
    threaded = am.Simulation(crowd, replicas=[5], threads=2)
    threaded.run(2.0)
    assert threaded.digest(5) == digest
