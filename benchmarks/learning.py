"""Environments for learners: PointGoal through Gymnasium, beside the same simulation without it, and a world of VMAS."""

from __future__ import annotations

import importlib.util
from collections.abc import Callable

import gymnasium as gym
import numpy as np

import amorsim.learning  # noqa: F401 - makes the tasks known
from amorsim.learning.vector import SimulationVectorEnv
from benchmarks.contest import Clock
from benchmarks.results import Ratio, Row, ratio_of

__all__ = ["measure"]

SECTION = "learning"
_NAME = "amorsim/PointGoal-v0"
_SIZES = (1, 100, 1000)
_STEPS = {1: 2000, 100: 200, 1000: 60}  # of a round
_UNIT = "environment steps/s"


def measure(rounds: int, quick: bool, clock: Clock, say: Callable[[str], None]) -> list[Row]:
    """Environment steps a second: through Gymnasium's interface, of the simulation alone, and of VMAS with 181 beams."""
    rows = []
    for count in _SIZES[: 2 if quick else None]:
        say(f"learning: {count} environments")
        rows += _contest(count, rounds, _STEPS[count] // (10 if quick else 1), clock)
    return rows


def _contest(count: int, rounds: int, steps: int, clock: Clock) -> list[Row]:
    sides = {"amorsim, through Gymnasium": _through_gymnasium(count), "amorsim, the simulation alone": _alone(count)}
    if importlib.util.find_spec("vmas") is not None:
        sides["VMAS"] = _vmas(count)
    rates: dict[str, list[float]] = {side: [] for side in sides}
    for step in sides.values():
        for _ in range(3):
            step()
    for _ in range(rounds):
        for side, step in sides.items():
            began = clock()
            for _ in range(steps):
                step()
            rates[side].append(steps * count / (clock() - began))
    ours = rates["amorsim, through Gymnasium"]
    extra = (
        1e6 * count * (1.0 / float(np.median(ours)) - 1.0 / float(np.median(rates["amorsim, the simulation alone"])))
    )
    notes = {
        "amorsim, through Gymnasium": f"181 exact beams; {extra:.0f} us a step more than the simulation alone",
        "VMAS": "a world of its own: navigation, one agent, a lidar of 181 beams, steps of 0.1 s, on the processor",
    }
    return [
        Row(
            section=SECTION,
            setting=f"PointGoal, {count} environments",
            side=side,
            unit=_UNIT,
            rounds=tuple(found),
            ratio=None if found is ours else Ratio(spread=ratio_of(ours, found), counts=True),
            note=notes.get(side, "driven by the same actions"),
        )
        for side, found in rates.items()
    ]


def _through_gymnasium(count: int) -> Callable[[], None]:
    envs = gym.make_vec(_NAME, num_envs=count, autoreset_mode="SameStep", threads=2)
    envs.reset(seed=0)
    actions = envs.action_space.sample()

    def step() -> None:
        envs.step(actions)

    return step


def _alone(count: int) -> Callable[[], None]:
    """The simulation of such environments, without observations, rewards and new episodes."""
    envs = gym.make_vec(_NAME, num_envs=count, threads=2).unwrapped
    assert isinstance(envs, SimulationVectorEnv)
    envs.reset(seed=0)
    simulation, name = envs.simulation, envs.simulation.names[0]
    forward, turn, left = envs.task.velocities(envs.action_space.sample().astype(float))

    def step() -> None:
        simulation.drive(name, forward=forward, turn=turn, left=left)
        simulation.step()

    return step


def _vmas(count: int) -> Callable[[], None]:
    from vmas import make_env

    world = make_env(
        "navigation",
        num_envs=count,
        device="cpu",
        n_agents=1,
        lidar_range=8.0,
        n_lidar_rays=181,
        collisions=True,
        max_steps=None,
    )
    world.reset()
    actions = [world.get_random_action(agent) for agent in world.agents]

    def step() -> None:
        world.step(actions)

    return step
