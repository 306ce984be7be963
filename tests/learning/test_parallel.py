"""The robots of one world as agents: PettingZoo's rules, and for one robot the bits of Gymnasium's environment."""

from __future__ import annotations

import importlib.util
import warnings
from typing import Any

import attrs
import numpy as np
import pytest

pytest.importorskip("gymnasium", reason="the extra 'learn' is not installed")
pytest.importorskip("pettingzoo", reason="the extra 'learn' is not installed")

from pettingzoo.test import parallel_api_test, parallel_seed_test

import amorsim as am
from amorsim.learning import make, make_parallel, make_parallel_vec
from amorsim.tasks import PointGoal
from tests import building
from tests.learning.test_vector import small

TASK = PointGoal(horizon=2.0, distance=(0.5, 1.5), clearance=0.3)


def crowd(count: int = 3, **changes: Any) -> am.Scenario:
    """Some of the robots of `small`."""
    robot = small(**changes).robots[0]
    return building.scenario(*(attrs.evolve(robot, name=f"r{number}") for number in range(count)))


def mixed() -> am.Scenario:
    """A robot of `crowd` between two others, on wheels farther apart and with a laser of 5 beams."""
    first, _, last = crowd().robots
    drive = attrs.evolve(first.drive, track=0.5)
    laser = attrs.evolve(first.sensors["laser"], sensor=am.sensors.Laser(beams=5))
    others = [attrs.evolve(one, drive=drive, sensors=one.sensors | {"laser": laser}) for one in (first, last)]
    return building.scenario(others[0], crowd().robots[1], others[1])


def env(count: int = 3, **given: Any) -> Any:
    return make_parallel(crowd(count), task=TASK, **given)


def test_it_passes_pettingzoos_tests_without_a_warning() -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        parallel_api_test(env(), num_cycles=100)
        parallel_seed_test(env, num_cycles=30)


def test_crossing_is_found_by_name() -> None:
    crossing = make_parallel("amorsim/Crossing-v0", horizon=1.0)
    assert len(crossing.possible_agents) == 8
    parallel_api_test(crossing, num_cycles=12)


def test_one_agent_has_the_bits_of_a_single_environment() -> None:
    one, single = env(1, dtype="float64"), make(crowd(1), task=TASK, dtype="float64")
    random = np.random.default_rng(3)
    for seed in (7, None):
        seen, _ = one.reset(seed=seed)
        wanted, _ = single.reset(seed=seed)
        while one.agents:
            assert seen["r0"].tobytes() == wanted.tobytes()
            action = random.uniform(-1.0, 1.0, 2)
            seen, rewards, terminated, truncated, infos = one.step({"r0": action})
            wanted, reward, is_terminated, is_truncated, info = single.step(action)
            assert (rewards["r0"], terminated["r0"], truncated["r0"]) == (reward, is_terminated, is_truncated)
        assert infos["r0"]["is_success"] == info["is_success"]


def test_robots_of_several_models_have_spaces_of_their_own() -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        parallel_api_test(make_parallel(mixed(), task=TASK), num_cycles=100)
        parallel_seed_test(lambda: make_parallel(mixed(), task=TASK), num_cycles=30)
    agents = make_parallel(mixed(), task=TASK, dtype="float64")
    assert [agents.observation_space(agent).shape for agent in agents.possible_agents] == [(10,), (14,), (10,)]
    agents.reset(seed=5)
    given = {agent: np.array([0.1 * number, 0.3 - 0.1 * number]) for number, agent in enumerate(agents.agents)}
    for _ in range(3):
        seen, *_ = agents.step(given)
    assert set(seen) == set(given)
    # Each sees its own goal, action and ranges, whatever group its row is in.
    away = agents._worlds.episode["goal"] - agents.simulation.estimated_pose[:, :2]
    for row, (agent, found) in enumerate(seen.items()):
        ranges = np.ravel(agents.simulation.robot(agent).readings["laser"].measured)
        assert found[0] == pytest.approx(np.hypot(*away[row]), rel=1e-12)
        np.testing.assert_array_equal(found[3:5], given[agent])
        np.testing.assert_array_equal(found[5:], np.clip(np.fmin(ranges / 8.0, 1.0), 0.0, 1.0), err_msg=agent)


def test_many_mixed_worlds_see_what_each_sees_alone() -> None:
    many = make_parallel_vec(mixed(), 3, task=TASK, dtype="float64")
    alone = [make_parallel(mixed(), task=TASK, dtype="float64") for _ in range(3)]
    seen, wanted = (
        many.reset(seed=[7, 1, 9])[0],
        [one.reset(seed=seed)[0] for one, seed in zip(alone, (7, 1, 9), strict=True)],
    )
    actions = np.random.default_rng(2).uniform(-1.0, 1.0, (3, 3, 2))
    for _ in range(4):
        for agent, found in seen.items():
            for world in range(3):
                np.testing.assert_array_equal(found[world], wanted[world][agent])
        if not many.active.all():
            break
        seen = many.step({agent: actions[row] for row, agent in enumerate(seen)})[0]
        wanted = [
            one.step({agent: actions[row, world] for row, agent in enumerate(seen)})[0]
            for world, one in enumerate(alone)
        ]


def test_an_agent_whose_episode_is_over_stands_in_the_way_of_the_others() -> None:
    agents = make_parallel(crowd(2), task=PointGoal(horizon=4.0, distance=(0.5, 3.0), tolerance=0.3))
    for seed in range(40):
        agents.reset(seed=seed)
        while len(agents.agents) == 2:
            before = agents.simulation.true_pose.copy()
            agents.step({agent: np.array([1.0, 0.3]) for agent in agents.agents})
        if len(agents.agents) == 1:
            break
    (left,) = agents.agents
    gone = ({"r0", "r1"} - {left}).pop()
    place = agents.simulation.names.index(gone)
    agents.step({left: np.array([1.0, 0.0])})
    before = agents.simulation.true_pose[place].copy()
    seen, *_ = agents.step({left: np.array([1.0, 0.0])})
    assert list(seen) == [left]
    assert (agents.simulation.true_pose[place] == before).all()


def test_what_is_wrong_is_said() -> None:
    others = building.scenario(crowd(1).robots[0], building.robot(name="other"))
    with pytest.raises(am.AmorsimError, match="observes the sensor 'laser', which the robot does not have"):
        make_parallel(others, task=TASK)
    agents = env()
    agents.reset(seed=1)
    with pytest.raises(ValueError, match="r1: expected finite numbers"):
        agents.step({"r0": np.zeros(2), "r2": np.zeros(2)})
    with pytest.raises(ValueError, match="seed"):
        agents.reset(seed=-1)
    with pytest.raises(am.AmorsimError, match="render_mode"):
        env(render_mode="ansi")
    with pytest.raises(am.AmorsimError, match="row by row"):
        agents.simulation.known(["r1", "r0", "r2"])


def test_a_picture_has_all_robots_and_their_goals() -> None:
    agents = env(render_mode="rgb_array")
    agents.reset(seed=1)
    picture = agents.render()
    assert picture.dtype == np.uint8
    assert picture.shape[2] == 3
    orange = (np.abs(picture.astype(int) - (0xD9, 0x5F, 0x02)) < 30).all(axis=2)
    assert orange.any()
    assert env().render() is None


def test_a_critic_sees_what_is_true() -> None:
    agents = env()
    agents.reset(seed=1)
    assert agents.state().shape == (18,)
    assert np.isin(agents.simulation.true_pose.astype(np.float32), agents.state()).all()


def test_without_pettingzoo_it_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None)
    with pytest.raises(am.AmorsimError, match="amorsim\\[learn\\]"):
        make_parallel("amorsim/Crossing-v0")


# ---------------------------------------------------------------------------------------------------------- many worlds


def actions_for(world: int, step: int, agents: list[str]) -> dict[str, Any]:
    """Some actions that depend on the world, the step and the agent alone."""
    return {agent: np.array([0.8, np.sin(0.7 * world + 0.2 * step + n)]) for n, agent in enumerate(agents)}


@pytest.mark.parametrize("threads", [1, 2])
def test_each_of_many_worlds_has_the_bits_of_a_world_alone(threads: int) -> None:
    many = make_parallel_vec(crowd(3), 5, task=TASK, dtype="float64", threads=threads)
    singles = [env(3, dtype="float64") for _ in range(5)]
    agents = many.possible_agents
    seen, _ = many.reset(seed=4)
    alone = [single.reset(seed=4 + world)[0] for world, single in enumerate(singles)]
    begun_again = 0
    for step in range(60):
        for world, single in enumerate(singles):
            for agent in single.agents:
                assert seen[agent][world].tobytes() == alone[world][agent].tobytes()
        over = [not single.agents for single in singles]
        taken = {agent: np.zeros((5, 2)) for agent in agents}
        for world in range(5):
            for agent, action in actions_for(world, step, agents).items():
                taken[agent][world] = action
        seen, rewards, terminated, truncated, infos = many.step(taken)
        for world, single in enumerate(singles):
            if over[world]:
                alone[world] = single.reset()[0]
                begun_again += 1
                assert not any(infos[agent]["active"][world] or rewards[agent][world] for agent in agents)
                continue
            acting = list(single.agents)
            found = single.step({agent: taken[agent][world] for agent in acting})
            alone[world] = found[0]
            for agent in agents:
                assert infos[agent]["active"][world] == (agent in acting)
                wanted = [part[agent] for part in found[1:4]] if agent in acting else [0.0, False, False]
                assert [part[agent][world] for part in (rewards, terminated, truncated)] == wanted
                assert infos[agent]["is_success"][world] == found[4].get(agent, {}).get("is_success", False)
        assert [bool(on.any()) for on in many.active] == [bool(single.agents) for single in singles]
    assert begun_again > 5


def test_many_worlds_refuse_what_is_wrong_in_words() -> None:
    many = make_parallel_vec(crowd(2), 3, task=TASK)
    with pytest.raises(ValueError, match="expected reset"):
        many.step({})
    seen, infos = many.reset(seed=[7, 1, 9])
    assert seen["r0"].shape == (3, *many.single_observation_spaces["r0"].shape)
    assert many.simulation.replicas == (7, 1, 9)
    assert not infos["r1"]["is_success"].any()
    assert many.state().shape == (3, 12)
    with pytest.raises(ValueError, match=r"actions: r1: expected finite numbers \(3, 2\)"):
        many.step({"r0": np.zeros((3, 2)), "r1": np.zeros((2, 2))})
    with pytest.raises(ValueError, match="expected 3 different whole numbers"):
        many.reset(seed=[1, 1, 2])
    several = make_parallel_vec(mixed(), 2, task=TASK)
    assert {agent: part.shape for agent, part in several.reset(seed=1)[0].items()} == {
        agent: (2, *space.shape) for agent, space in several.single_observation_spaces.items()
    }
