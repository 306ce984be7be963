"""Environments for learners: PointGoal through Gymnasium, what its interface costs, and a world of VMAS."""

from __future__ import annotations

import importlib.util
from collections.abc import Callable
from typing import Any

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
_OURS, _STANDING, _ALONE = "amorsim", "amorsim, standing", "the simulation alone, standing"


def measure(rounds: int, quick: bool, clock: Clock, say: Callable[[str], None]) -> list[Row]:
    """Environment steps a second: with random actions; standing, with Gymnasium's interface and without; of VMAS."""
    rows = []
    for count in _SIZES[: 2 if quick else None]:
        say(f"learning: {count} environments")
        rows += _contest(count, rounds, _STEPS[count] // (10 if quick else 1), clock)
    return rows


def _contest(count: int, rounds: int, steps: int, clock: Clock) -> list[Row]:
    sides = {_OURS: _stepper(_made(count)), _STANDING: _stepper(_made(count), stands=True), _ALONE: _alone(count)}
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
    with_it, without = (float(np.median(rates[side])) for side in (_STANDING, _ALONE))
    cost = 1e6 * count * (1.0 / with_it - 1.0 / without)
    notes = {
        _OURS: "random actions, 181 exact beams, two threads; whoever touches anything begins anew",
        _STANDING: f"nobody moves, so that no episode ends: the interface costs {cost:.0f} us a step",
        _ALONE: "no observations and no rewards",
        "VMAS": "a world of its own: navigation, one agent, a lidar of 181 beams, on the processor",
    }
    return [
        Row(
            section=SECTION,
            setting=f"PointGoal, {count} environments",
            side=side,
            unit="environment steps/s",
            rounds=tuple(found),
            ratio=Ratio(spread=ratio_of(rates[_OURS], found), counts=True) if side == "VMAS" else None,
            note=notes[side],
        )
        for side, found in rates.items()
    ]


def _made(count: int) -> Any:
    envs = gym.make_vec(_NAME, num_envs=count, autoreset_mode="SameStep", threads=2, horizon=1e4)
    envs.reset(seed=0)
    return envs


def _stepper(envs: Any, *, stands: bool = False) -> Callable[[], None]:
    actions = envs.action_space.sample() * (0.0 if stands else 1.0)

    def step() -> None:
        envs.step(actions)

    return step


def _alone(count: int) -> Callable[[], None]:
    envs = _made(count).unwrapped
    assert isinstance(envs, SimulationVectorEnv)
    simulation, name = envs.simulation, envs.simulation.names[0]
    forward, turn, left = envs.task.velocities(np.zeros((count, 2)))

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
