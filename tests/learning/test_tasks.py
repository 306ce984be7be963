"""The tasks that come with amorsim: what they reward, when they end, and what a robot of each observes."""

from __future__ import annotations

import math
from typing import Any

import attrs
import numpy as np
import numpy.typing as npt
import pytest

pytest.importorskip("gymnasium", reason="the extra 'learn' is not installed")

import amorsim as am
from amorsim.contracts import TrueState
from amorsim.core.parameters import ParameterError
from amorsim.learning import evaluate, load_environment, make_vec
from amorsim.tasks import FollowLeader, FollowLine, Park
from amorsim.tasks.follow_line import _place_on
from amorsim.tasks.observed import from_robot
from amorsim.testing import check_component

Array = npt.NDArray[np.float64]


def truth(pose: tuple[float, float, float], **others: Any) -> TrueState:
    """The truth of one robot in the office, somewhere else."""
    state = am.Simulation(load_environment("amorsim/PointGoal-v0")).truth()
    return state._replace(pose=np.array([pose]), is_touching=np.array([others.pop("touching", False)]), **others)


# ---------------------------------------------------------------------------------------------------------- the truth


def test_the_truth_has_others_parts_and_lines_of_each_row() -> None:
    sim = am.Simulation(load_environment("amorsim/Follow-v0"), replicas=3)
    sim.run(2.0)
    state = sim.truth([2, 0])
    for row, replica in ((0, 2), (1, 0)):
        assert state.pose[row].tolist() == sim.robot("rover", replica).true_pose.tolist()
        assert state.pose_of("guide")[row].tolist() == sim.obstacle("guide", replica).true_pose.tolist()
        assert state.pose_of("rover")[row].tolist() == state.pose[row].tolist()
    with pytest.raises(am.AmorsimError, match=r"no robot or obstacle 'giude'.*Did you mean 'guide'"):
        state.pose_of("giude")
    assert state.part_pose.shape == (2, 0, 3)
    assert state.lines == ()
    sim = am.Simulation(load_environment("amorsim/Trailer-v0"), replicas=2)
    assert sim.truth([1]).part_pose[0, 0].tolist() == sim.robot("tractor", 1).parts["trailer"].tolist()
    line = am.Simulation(load_environment("amorsim/Line-v0")).truth().lines[0]
    assert line[0].tolist() == line[-1].tolist() == [1.0, 0.12]


def test_the_truth_of_several_robots_has_their_own_trailers() -> None:
    one = load_environment("amorsim/Trailer-v0").robots[0]
    robots = [
        attrs.evolve(one, name=name, start=None, pose=am.Pose(x=x, y=26.0)) for name, x in (("a", 24.0), ("b", 30.0))
    ]
    sim = am.Simulation(attrs.evolve(load_environment("amorsim/Trailer-v0"), robots=robots), replicas=2)
    found = sim.truth([3, 0]).part_pose
    assert found[0, 0].tolist() == sim.robot("b", 1).parts["trailer"].tolist()
    assert found[1, 0].tolist() == sim.robot("a", 0).parts["trailer"].tolist()


# ------------------------------------------------------------------------------------------------------------- leader


@pytest.mark.parametrize(
    ("away", "touching", "reward", "ends", "success"),
    [
        (1.2, False, 0.1, False, True),  # at the gap: 1 for a second
        (1.8, False, 0.05, False, False),  # half a gap farther: a half
        (3.6, False, -0.1, False, False),  # no less than -1
        (4.1, False, -10.1, True, False),  # lost
        (1.2, True, -9.9, True, False),
    ],
)
def test_a_leader_is_followed_at_the_gap(away: float, touching: bool, reward: float, ends: bool, success: bool) -> None:
    task = FollowLeader(leader="guide")
    state = truth((1.0, 2.0, 0.3), touching=touching, pose_of=lambda _: np.array([[1.0, 2.0 + away, 0.0]]))
    found = task.judge(state, task.begin(state, None))  # type: ignore[arg-type] - nothing is drawn
    assert found.reward[0] == pytest.approx(reward)
    assert (bool(found.is_terminated[0]), bool(found.is_success[0])) == (ends, success)


def test_the_leader_is_seen_where_it_is() -> None:
    scenario = load_environment("amorsim/Follow-v0")
    noiseless = scenario.robots[0].sensors | {"fiducial": am.MountedSensor(sensor=am.sensors.Fiducial(range_max=6.0))}
    robot = attrs.evolve(scenario.robots[0], sensors=noiseless, start=None, pose=am.Pose(x=10.0, y=5.0, heading=0.5))
    envs = make_vec(attrs.evolve(scenario, robots=[robot]), 2)
    envs.reset(seed=1)
    seen, *_ = envs.step(np.zeros((2, 2)))
    state = envs.simulation.truth()
    for row in range(2):
        east, north = (state.pose_of("guide")[row] - state.pose[row])[:2]
        bearing = math.atan2(north, east) - state.pose[row, 2]
        assert seen[row, :4] == pytest.approx(
            [1.0, math.hypot(east, north) / 6.0, math.cos(bearing), math.sin(bearing)]
        )
    behind = attrs.evolve(robot, pose=am.Pose(x=13.0, y=6.5, heading=0.0))
    envs = make_vec(attrs.evolve(scenario, robots=[behind]), 1)
    envs.reset(seed=1)
    seen, *_ = envs.step(np.zeros((1, 2)))
    assert seen[0, :4].tolist() == [0.0, 0.0, 0.0, 0.0]


# --------------------------------------------------------------------------------------------------------------- line

SQUARE = np.array([(0.0, 0.0), (2.0, 0.0), (2.0, 1.0), (0.0, 1.0), (0.0, 0.0)])


@pytest.mark.parametrize(
    ("place", "off", "along"),
    [((0.5, 0.1), 0.1, 0.5), ((2.3, 0.4), 0.3, 2.4), ((1.0, 0.9), 0.1, 4.0), ((-3.0, 0.0), 3.0, 0.0)],
)
def test_a_place_is_on_a_line_where_the_line_is_nearest(place: tuple[float, float], off: float, along: float) -> None:
    found = _place_on(SQUARE, np.array([place]))
    assert (found[0][0], found[1][0]) == (pytest.approx(off), pytest.approx(along))


@pytest.mark.long
def test_a_line_is_done_once_round_and_no_way_across_counts() -> None:
    task = FollowLine(width=0.2, speed=1.0, period=0.1)  # 0.4 m a step are no way across
    places = [(0.3 * step, 0.0) for step in range(7)] + [(2.0, 0.1), (2.0, 0.4), (2.0, 0.7), (1.9, 1.0)]
    places += [(1.9 - 0.3 * step, 1.0) for step in range(1, 7)] + [(0.0, 0.9), (0.0, 0.6), (0.0, 0.3), (0.0, 0.0)]
    begin = truth((0.0, 0.0, 0.0), lines=(SQUARE,))
    episode = task.begin(begin, None)  # type: ignore[arg-type] - nothing is drawn
    found = [task.judge(truth((*place, 0.0), lines=(SQUARE,)), episode) for place in places]
    assert [bool(each.is_success[0]) for each in found] == [False] * (len(places) - 1) + [True]
    assert sum(float(each.reward[0]) for each in found) == pytest.approx(10.0)
    back = task.judge(truth((0.3, 0.0, 0.0), lines=(SQUARE,)), episode)
    assert back.reward[0] == pytest.approx(10.0 * 0.3 / 6.0)  # over the seam
    across = task.judge(truth((0.3, 1.0, 0.0), lines=(SQUARE,)), episode)
    assert across.reward[0] == 0.0
    lost = task.judge(truth((0.3, 1.3, 0.0), lines=(SQUARE,)), episode)
    assert (lost.reward[0], bool(lost.is_terminated[0])) == (pytest.approx(-1.0), True)


# ---------------------------------------------------------------------------------------------------------------- bay


def test_a_bay_is_seen_from_the_robot() -> None:
    seen = from_robot(np.array([[1.0, 2.0, math.pi / 2]]), np.array([[1.0, 5.0, math.pi]]))
    assert seen[0] == pytest.approx([3.0, 0.0, 0.0, 1.0], abs=1e-12)


@pytest.mark.parametrize(
    ("pose", "touching", "reward", "ends", "success"),
    [
        ((-1.0, 0.0, 0.0), False, 4.0 - 5.0, False, False),  # 4 m and 1 rad away, 1 m more than before
        ((3.0, 0.0, 1.0), False, 4.0 + 10.0, True, True),
        ((3.0, 0.2, 0.9), False, 4.0 - 0.2 - 0.1 + 10.0, True, True),
        ((3.0, 0.2, 0.7), False, 4.0 - 0.2 - 0.3, False, False),
        ((3.0, 0.0, 1.0), True, 4.0 - 10.0, True, False),
        ((3.0, 0.0, 1.0 + 2.0 * math.pi), False, 4.0 + 10.0, True, True),
    ],
)
def test_a_bay_is_reached_by_place_and_heading(
    pose: tuple[float, float, float], touching: bool, reward: float, ends: bool, success: bool
) -> None:
    task = Park(goals=((3.0, 0.0),), headings=(1.0,), time_reward=0.0)
    episode = {"goal": np.array([[3.0, 0.0, 1.0]]), "away": np.array([4.0])}
    found = task.judge(truth(pose, touching=touching), episode)
    assert found.reward[0] == pytest.approx(reward)
    assert (bool(found.is_terminated[0]), bool(found.is_success[0])) == (ends, success)


def test_of_several_bays_each_is_drawn() -> None:
    task = Park(goals=((29.7, 2.0), (32.0, 8.0), (20.0, 8.0)), headings=(1.5, 0.0, 0.1))
    envs = make_vec(load_environment("amorsim/Dock-v0"), 60, task=task)
    envs.reset(seed=0)
    drawn = {tuple(goal) for goal in envs._worlds.episode["goal"].tolist()}
    assert drawn == {(29.7, 2.0, 1.5), (32.0, 8.0, 0.0), (20.0, 8.0, 0.1)}
    with pytest.raises(ParameterError, match="expected one for each of 3 goals"):
        attrs.evolve(task, headings=(1.0,))


def test_a_trailer_is_seen_by_what_the_robot_knows_of_it() -> None:
    envs = make_vec("amorsim/Trailer-v0", 3, dtype="float64")
    envs.reset(seed=5)
    for _ in range(30):
        seen, *_ = envs.step(np.tile([1.0, 0.6], (3, 1)))
    known, state = envs.simulation.known("tractor"), envs.simulation.truth()
    hitch = np.arctan2(seen[:, 5], seen[:, 4])
    trailer = known.estimate.pose[:, 2] + hitch
    turned = np.arctan2(seen[:, 3], seen[:, 2])
    assert turned == pytest.approx(math.radians(90.0) - trailer)
    assert np.abs(hitch).min() > 0.05
    assert hitch == pytest.approx(state.part_pose[:, 0, 2] - state.pose[:, 2], abs=0.02)  # measured, by errors' size


@pytest.mark.parametrize("name", ["Dock", "Trailer"])
def test_tasks_of_bays_keep_the_contract_in_their_scenes(name: str) -> None:
    scene = load_environment(f"amorsim/{name}-v0")
    assert scene.task is not None
    check_component(scene.task, scene=scene)


# ------------------------------------------------------------------------------------------------------------- drivers


def test_a_controller_drives_in_place_of_actions() -> None:
    controller = am.controllers.Follow(gap=0.8, gain=2.0, speed=0.8)
    envs = make_vec("amorsim/Follow-v0", 10, controller=controller, horizon=10.0)
    found = evaluate(envs, seed=3)
    standing = evaluate(make_vec("amorsim/Follow-v0", 10, horizon=10.0), lambda seen: np.zeros((10, 2)), seed=3)
    assert found.episodes == standing.episodes == 10
    assert found.mean_return > standing.mean_return + 1.0
    # The same controller in the same replica of the scenario drives the same way, to the bit.
    scenario = load_environment("amorsim/Follow-v0")
    robot = attrs.evolve(scenario.robots[0], controller=controller)
    alone = am.Simulation(attrs.evolve(scenario, robots=[robot]), seed=0, replicas=[4])
    envs.reset(seed=3)
    for _ in range(5):
        envs.step(np.zeros((10, 2)))
    alone.run(0.5)
    assert alone.true_pose[0].tolist() == envs.simulation.true_pose[1].tolist()


@pytest.mark.long
def test_an_evaluation_is_of_first_episodes_in_either_mode() -> None:
    def ahead(seen: Array) -> Array:
        return np.tile([0.8, 0.0], (len(seen), 1))

    next_step = evaluate(make_vec("amorsim/PointGoal-v0", 20, horizon=10.0), ahead)
    same_step = evaluate(make_vec("amorsim/PointGoal-v0", 20, horizon=10.0, autoreset_mode="SameStep"), ahead)
    assert next_step == same_step
    assert 0.0 < next_step.failure < 1.0
    assert "20 episodes" in str(next_step)
    with pytest.raises(TypeError, match=r"expected a vector environment, .*got 'amorsim/Follow-v0'"):
        evaluate("amorsim/Follow-v0")  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="got Disabled"):
        evaluate(make_vec("amorsim/PointGoal-v0", 2, autoreset_mode="Disabled"), ahead)


@pytest.mark.parametrize(
    ("name", "changes", "words"),
    [
        (
            "Follow",
            {"finder": "fiducials"},
            "'fiducials', which the robot does not have.*Did you mean 'fiducial'",
        ),
        ("Follow", {"finder": "laser"}, "a Laser does not tell range, bearing and identity"),
        ("Follow", {"leader": "giude"}, r"no robot or obstacle 'giude'.*Did you mean 'guide'"),
        ("PointGoal", {"sensor": "lasr"}, "sensor 'lasr', which the robot does not have.*Did you mean 'laser'"),
        ("PointGoal", {"sensor": "encoder"}, "observes the ranges of 'encoder', which has none"),
        ("Line", {"line": 3}, "expected one of the 1 lines on the floor, from 0, got 3"),
        ("Line", {"sensor": "tape"}, "sensor 'tape', which the robot does not have"),
        ("Dock", {"towed": True}, "towed: the robot has no trailer"),
    ],
)
def test_what_a_task_cannot_do_is_said(name: str, changes: dict[str, Any], words: str) -> None:
    with pytest.raises(am.AmorsimError, match=words):
        make_vec(f"amorsim/{name}-v0", 2, **changes)


def test_without_a_range_sensor_a_task_does_without_ranges() -> None:
    envs = make_vec("amorsim/Follow-v0", 2, sensor="")
    seen, _ = envs.reset(seed=1)
    assert seen.shape == (2, 6)
