"""Vector environments of amorsim: Gymnasium's rules, and the same bits alone and among many."""

from __future__ import annotations

import importlib.util
import queue
import warnings
from pathlib import Path
from typing import Any

import pytest

gym = pytest.importorskip("gymnasium", reason="the extra 'learn' is not installed")

import numpy as np  # noqa: E402
import numpy.typing as npt  # noqa: E402
from gymnasium.utils.env_checker import check_env  # noqa: E402
from gymnasium.vector import AutoresetMode  # noqa: E402

import amorsim as am  # noqa: E402
import amorsim.learning  # noqa: E402
from amorsim.learning import SimulationVectorEnv, load_environment, make, make_vec  # noqa: E402
from amorsim.tasks import PointGoal  # noqa: E402
from amorsim.tasks.goals import goal_within  # noqa: E402
from amorsim.testing import check_vector_env  # noqa: E402
from tests import building  # noqa: E402
from tests.some_cases import one_in  # noqa: E402

ROOT = Path(__file__).resolve().parents[2]
TASK = PointGoal(horizon=2.0, distance=(0.5, 1.5), clearance=0.3)


def small(**changes: Any) -> am.Scenario:
    """A robot with a laser of nine beams in a small room, which starts anywhere in it."""
    laser = am.MountedSensor(
        sensor=am.sensors.Laser(beams=9), noise=building.chain(am.noise.Gaussian(std=0.02)), latency=0.1
    )
    robot = building.robot(
        name="rover",
        pose=None,
        start=am.RandomStart(clearance=0.1),
        sensors={"encoder": building.all_sensors()["encoder"], "laser": laser},
        **changes,
    )
    return building.scenario(robot)


def envs(count: int, **given: Any) -> SimulationVectorEnv:
    return make_vec(small(), count, task=TASK, **given)


@pytest.mark.parametrize("mode", list(AutoresetMode))
@pytest.mark.parametrize("privileged", [False, True])
def test_it_keeps_the_rules_of_gymnasium(mode: AutoresetMode, privileged: bool) -> None:
    check_vector_env(envs(3, autoreset_mode=mode, privileged=privileged), steps=70)


@pytest.mark.parametrize("dtype", ["float32", "float64"])
def test_one_passes_gymnasiums_checker_without_a_warning(dtype: str) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        check_env(make(small(), task=TASK, dtype=dtype), skip_render_check=True)


def test_gymnasium_finds_the_tasks_by_name() -> None:
    found = gym.make_vec("amorsim/PointGoal-v0", num_envs=2, distance=(1.0, 2.0))
    seen, _ = found.reset(seed=4)
    assert seen.shape == (2, 186)
    one = gym.make("amorsim/PointGoal-v0", distance=(1.0, 2.0))
    np.testing.assert_array_equal(one.reset(seed=5)[0], seen[1])
    assert found.metadata["autoreset_mode"] is AutoresetMode.NEXT_STEP
    assert found.autoreset_mode is AutoresetMode.NEXT_STEP  # where TorchRL looks, as Gymnasium's own have it


@pytest.mark.parametrize("name", one_in(4, amorsim.learning.TASKS))
def test_each_environment_keeps_the_rules(name: str) -> None:
    check_vector_env(gym.make_vec(name, num_envs=3, horizon=2.0), steps=45)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        check_env(gym.make(name, horizon=2.0).unwrapped, skip_render_check=True)


def actions_of(seed: int, steps: int) -> npt.NDArray[np.float32]:
    return np.random.default_rng(seed).uniform(-1.0, 1.0, (steps, 2)).astype(np.float32)


def followed(number: int, count: int, *, steps: int = 60, **given: Any) -> list[list[float]]:
    """What the environment of a seed goes through: each observation and reward that is not of a wait."""
    many = envs(count, **given)
    first = number - count // 2
    row = number - first
    seen, _ = many.reset(seed=first)
    actions = {seed: actions_of(seed, steps) for seed in range(first, first + count)}
    place = dict.fromkeys(actions, 0)  # how many of its actions each has taken
    waits = np.zeros(count, dtype=bool)
    found = [seen[row].tolist()]
    mode = AutoresetMode(given.get("autoreset_mode", "NextStep"))
    while place[number] < steps:
        if mode is AutoresetMode.DISABLED and waits.any():
            seen, _ = many.reset(options={"reset_mask": waits})
            if waits[row]:
                found.append(seen[row].tolist())
        taken = np.array([actions[seed][min(place[seed], steps - 1)] for seed in actions])
        seen, reward, terminated, truncated, infos = many.step(taken)
        acted = ~waits if mode is AutoresetMode.NEXT_STEP else np.ones(count, dtype=bool)
        for seed, one in zip(place, acted, strict=True):
            place[seed] += int(one)
        ended = terminated | truncated
        if mode is AutoresetMode.SAME_STEP and ended[row]:
            found.append([*infos["final_obs"][row].tolist(), reward[row]])
            found += [seen[row].tolist()] if place[number] < steps else []
        else:
            found.append([*seen[row].tolist(), *([reward[row]] if acted[row] else [])])
        waits = ended
    return found


@pytest.mark.parametrize("mode", ["NextStep", "SameStep", "Disabled"])
def test_an_environment_is_the_same_alone_and_among_many_in_each_mode(mode: str) -> None:
    alone = followed(20, 1)
    assert sum(len(one) == len(alone[0]) for one in alone) >= 2  # some episodes begin again
    assert followed(20, 7, autoreset_mode=mode, threads=2) == alone
    assert followed(20, 40, autoreset_mode=mode) == alone


def test_observations_are_of_what_the_robot_knows_alone() -> None:
    """Where the truth is changed and what is known is not, no observation moves."""
    many = envs(4)
    many.reset(seed=1)
    seen = many._observations()
    group = many.simulation._fleet.groups[0]
    group.true_pose += 5.0
    group.true_twist += 1.0
    for device in group.sensors.values():
        device.true[:] = 77.0
    np.testing.assert_array_equal(many._observations(), seen)


def test_an_episode_can_be_repeated_from_its_seed_and_number() -> None:
    many = envs(3)
    many.reset(seed=50)
    for _ in range(3):
        seen, infos = many.reset()
    assert infos["episode_number"].tolist() == [3, 3, 3]
    one = make(small(), task=TASK)
    one.reset(seed=51)
    for _ in range(3):
        again, info = one.reset()
    assert info == {"episode_number": 3}
    np.testing.assert_array_equal(again, seen[1])
    goals = many._worlds.episode["goal"]
    assert len(np.unique(goals, axis=0)) == 3


def test_goals_are_drawn_as_far_as_asked_and_clear_of_walls() -> None:
    many = envs(200)
    many.reset(seed=0)
    goals = many._worlds.episode["goal"]
    away = np.hypot(*(goals - many.simulation.true_pose[:, :2]).T)
    # The way leads over eight neighbours of squares 0.05 m wide, so it is up to 8.3 % longer than the straight line.
    assert away.min() >= 0.5 / 1.083 - 0.05
    assert away.max() <= 1.5 + 0.05
    assert am.analysis.distances_to_walls(goals, small().map.segments).min() >= 0.3


def judged(task: PointGoal, before: float, to: float, touching: bool) -> Any:
    episode = {"goal": np.zeros((1, 2)), "distance": np.array([before])}
    pose = np.array([[to, 0.0, 0.0]])
    truth = am.Simulation(small()).truth()._replace(pose=pose, is_touching=np.array([touching]))
    return task.judge(truth, episode)


@pytest.mark.parametrize(
    ("to", "touching", "reward", "ends", "success"),
    [
        (1.7, False, 0.3 - 0.01, False, False),
        (2.1, False, -0.1 - 0.01, False, False),
        (0.3, False, 1.7 - 0.01 + 10.0, True, True),
        (0.3, True, 1.7 - 0.01 - 10.0, True, False),
    ],
)
def test_a_reward_is_what_the_page_says(to: float, touching: bool, reward: float, ends: bool, success: bool) -> None:
    outcome = judged(PointGoal(), 2.0, to, touching)
    assert outcome.reward[0] == pytest.approx(reward)
    assert (outcome.is_terminated[0], outcome.is_success[0]) == (ends, success)


@pytest.mark.long
def test_a_drive_by_the_observation_reaches_the_goal() -> None:
    """A rule that turns towards the observed goal succeeds in an empty room, whatever the seed."""
    many = make_vec(small(), 64, task=PointGoal(distance=(0.5, 1.5), clearance=0.6), autoreset_mode="SameStep")
    seen, _ = many.reset(seed=0)
    done = np.zeros(64, dtype=bool)
    success = np.zeros(64, dtype=bool)
    for _ in range(300):
        bearing = np.arctan2(seen[:, 2], seen[:, 1])
        ahead = np.where(np.abs(bearing) < 0.3, 0.6, 0.0)
        seen, _, _, _, infos = many.step(np.column_stack((ahead, np.clip(2.0 * bearing, -1, 1))).astype(np.float32))
        if "is_success" in infos:
            new = infos["_is_success"] & ~done
            success |= infos["is_success"] & new
            done |= new
    assert done.all()
    assert success.all()


def test_goals_lie_where_a_way_leads() -> None:
    """Behind a wall with a door, a goal is as far as the way through the door, and never in a closed room."""
    walls = [(0, 0, 8, 0), (8, 0, 8, 4), (8, 4, 0, 4), (0, 4, 0, 0), (4, 0, 4, 3), (6, 0, 6, 4)]
    world = am.Map.from_segments(np.array(walls, dtype=float), resolution=0.05)
    start = np.array([3.5, 0.5])
    numbers = (np.arange(400) + 0.5) / 400
    given = {"clearance": 0.3, "way_clearance": 0.3}
    goals = np.array([goal_within(world, start, 1.0, 4.0, number, **given) for number in numbers.tolist()])
    # The way over the wall's end is at least 3 m up, and then down again on the other side.
    beyond = goals[:, 0] > 4.0
    assert goals[:, 0].max() < 6.0
    assert beyond.any()
    over = np.hypot(3.7 - start[0], 3.3 - start[1]) + np.hypot(*(goals[beyond] - [4.3, 3.3]).T) + 0.6
    assert over.min() <= 4.0 + 0.1
    assert (over <= 4.0 * 1.02).all()
    assert goals[beyond, 1].min() > 2.0


@pytest.mark.long
def test_a_picture_shows_robot_and_goal_of_each_environment() -> None:
    many = envs(2, render_mode="rgb_array")
    assert many.metadata["render_fps"] == 10
    with pytest.raises(ValueError, match="before the first picture"):
        envs(1, render_mode="rgb_array").render()
    many.reset(seed=3)
    first = many.render()
    many.step(np.ones((2, 2), dtype=np.float32))
    later = many.render()
    for before, after in zip(first, later, strict=True):
        assert before.dtype == np.uint8
        assert before.shape[2] == 3
        assert (before != after).any()
        assert (before == [217, 95, 2]).all(axis=2).any()  # the goal's colour
    assert envs(2).render() is None
    check_env(gym.make("amorsim/PointGoal-v0", render_mode="rgb_array").unwrapped)


def test_time_is_up_after_the_horizon() -> None:
    many = envs(2, autoreset_mode="Disabled")
    many.reset(seed=3)
    for step in range(1, 21):
        _, _, terminated, truncated, _ = many.step(np.zeros((2, 2), dtype=np.float32))
        assert not terminated.any()
        assert truncated.all() == (step == 20)
    with pytest.raises(ValueError, match="2 episodes are over"):
        many.step(np.zeros((2, 2), dtype=np.float32))


def test_each_generated_world_has_goals_of_its_own(tmp_path: Path) -> None:
    text = (ROOT / "amorsim/learning/scenarios/point-goal.toml").read_text()
    file = tmp_path / "mazes.toml"
    file.write_text(text.replace('map = "../../scenarios/office.wld"', 'map = { generate = "maze", corridor = 1.5 }'))
    many = make_vec(file, 3, task=TASK)
    many.reset(seed=7)
    for row, goal in enumerate(many._worlds.episode["goal"]):
        around = np.linspace(-np.pi, np.pi, 64)
        assert many.simulation.map_of(7 + row).cast_rays([[*goal, 0.0]], around, 9.0).min() >= 0.3
    np.testing.assert_array_equal(make(file, task=TASK).reset(seed=8)[0], many.reset(seed=7)[0][1])


@pytest.mark.parametrize(
    ("does", "error", "words"),
    [
        (lambda many: many.step(np.zeros((3, 2))), ValueError, r"expected reset\(\)"),
        (lambda many: many.reset(seed=[1, 1, 2]), ValueError, "different whole numbers"),
        (lambda many: many.reset(seed=-1), ValueError, "different whole numbers"),
        (lambda many: many.reset(seed=[1, 2]), ValueError, "one for each of 3"),
        (lambda many: many.reset(options={"reset_mask": [True]}), TypeError, "numpy array of bool"),
        (lambda many: many.reset(options={"reset_mask": np.zeros(3, dtype=bool)}), ValueError, "at least one True"),
        (lambda many: (many.reset(), many.step(np.zeros((2, 2)))), ValueError, "expected finite numbers"),
        (lambda many: (many.reset(), many.step(np.full((3, 2), np.nan))), ValueError, "expected finite numbers"),
    ],
)
def test_wrong_calls_are_refused_in_words(does: Any, error: type[Exception], words: str) -> None:
    with pytest.raises(error, match=words):
        does(envs(3))


def test_without_gymnasium_it_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(importlib.util, "find_spec", lambda *_: None)
    with pytest.raises(am.AmorsimError, match=r'extra "learn": python -m pip install'):
        importlib.reload(amorsim.learning)


def test_wrong_tasks_are_refused_in_words() -> None:
    with pytest.raises(ValueError, match=r"no environment 'amorsim/PointGaol-v0'.*Did you mean 'amorsim/PointGoal-v0'"):
        make_vec("amorsim/PointGaol-v0")
    with pytest.raises(am.AmorsimError, match="one robot, got one with 2"):
        make_vec(
            building.scenario(*(building.robot(name=n, pose=am.Pose(x=x)) for n, x in (("a", 1.0), ("b", 3.0)))),
            task=TASK,
        )
    with pytest.raises(am.AmorsimError, match="period: expected a whole number of steps"):
        make_vec(small(), task=PointGoal(period=0.07))
    with pytest.raises(am.AmorsimError, match="render_mode: expected None or 'rgb_array' or 'human', got 'ansi'"):
        make_vec(small(), task=TASK, render_mode="ansi")


def test_what_was_drawn_is_in_the_infos_where_asked() -> None:
    envs = make_vec("amorsim/PointGoal-v0", 3, drawn=True)
    _, infos = envs.reset(seed=[7, 2, 9])
    paths = ["drive.track", "drive.wheel_radius_left"]
    assert sorted(infos["drawn"]) == sorted(paths + [f"_{path}" for path in paths])
    assert infos["_drawn"].all()
    scenario = load_environment("amorsim/PointGoal-v0")
    for row, seed in enumerate((7, 2, 9)):
        drive: Any = am.Simulation(scenario, seed=0, replicas=[seed]).robot("rover").true.drive
        assert infos["drawn"]["drive.track"][row] == drive.track
        assert infos["drawn"]["drive.wheel_radius_left"][row] == drive.wheel_radius_left
    assert len(set(infos["drawn"]["drive.track"])) == 3
    _, infos = envs.reset(options={"reset_mask": np.array([False, True, False])})
    assert infos["drawn"]["_drive.track"].tolist() == infos["_drawn"].tolist() == [False, True, False]
    _, infos = make_vec("amorsim/PointGoal-v0", 2).reset(seed=1)
    assert "drawn" not in infos


@pytest.mark.long
def test_a_window_shows_one_environment_and_changes_no_bit(monkeypatch: pytest.MonkeyPatch) -> None:
    opened: queue.SimpleQueue[str] = queue.SimpleQueue()
    monkeypatch.setattr("webbrowser.open", opened.put)
    seen = []
    for render_mode in (None, "human"):
        env = make("amorsim/PointGoal-v0", render_mode=render_mode)
        first, _ = env.reset(seed=3)
        seen.append([first, *(env.step(env.action_space.high)[0] for _ in range(3)), env.reset()[0]])
        assert env.render() is None
        env.close()
    for without, watched in zip(*seen, strict=True):
        assert without.tobytes() == watched.tobytes()
    assert opened.get(timeout=60.0).startswith("file:")
    assert opened.empty()
    with pytest.raises(am.AmorsimError, match="'human' shows one environment, got 2"):
        make_vec("amorsim/PointGoal-v0", 2, render_mode="human")
