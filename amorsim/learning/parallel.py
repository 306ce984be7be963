"""The robots of one world as PettingZoo's agents, which act at the same time."""

from __future__ import annotations

from typing import Any

import attrs
import gymnasium as gym
import numpy as np
import numpy.typing as npt
from pettingzoo import ParallelEnv

from amorsim.contracts import Draws, Observable, State, Task
from amorsim.controllers.manual import Manual
from amorsim.core.draws import stream_key
from amorsim.core.errors import AmorsimError
from amorsim.learning.pictures import Pictures, goals_in
from amorsim.learning.vector import RENDER_MODES, SIZE, STUDY, whole_steps
from amorsim.scenario.spec import Scenario
from amorsim.simulation.handle import Known
from amorsim.simulation.simulation import MAX_REPLICA, Simulation

__all__ = ["SimulationParallelEnv"]


class SimulationParallelEnv(ParallelEnv):  # type: ignore[misc]
    """The robots of a scenario as agents, by their names: each has the task for itself, and meets the others.

    ``reset(seed=7)`` simulates replica 7; a later reset without a seed begins its next episode. An agent whose episode
    is over stands where it is, in the way of the others, until all are over.

    Parameters
    ----------
    scenario
        With robots that are alike: of the same model, with sensors of the same names. Their controllers are replaced.
    task
        What each observes, is rewarded for, and draws.
    dtype
        Of observations and actions: ``"float32"`` or ``"float64"``.
    render_mode
        None, or ``"rgb_array"``.

    Raises
    ------
    AmorsimError
        If the robots are not alike, or a period is no whole number of the scenario's steps.
    """

    def __init__(
        self, scenario: Scenario, task: Task, *, dtype: str = "float32", render_mode: str | None = None
    ) -> None:
        if render_mode not in (None, *RENDER_MODES):
            raise AmorsimError(
                f"render_mode: expected None or {' or '.join(map(repr, RENDER_MODES))}, got {render_mode!r}"
            )
        self.task, self.render_mode = task, render_mode
        self.metadata = {
            "name": "amorsim",
            "render_modes": RENDER_MODES,
            "render_fps": round(1.0 / task.period),
            "is_parallelizable": True,
        }
        hand = Manual()
        robots = [attrs.evolve(robot, controller=hand) for robot in scenario.robots]
        self._scenario = attrs.evolve(scenario, robots=robots)
        self._steps_per_action = whole_steps(task.period, scenario.dt, "period")
        self._horizon = whole_steps(task.horizon, task.period, "horizon")
        self._dtype = np.dtype(dtype)
        self._random = np.random.default_rng()
        self._pictures: Pictures | None = None
        self._begin_first(0)  # for the spaces
        self._is_begun = False
        self.possible_agents = list(self.simulation.names)
        self.agents: list[str] = []
        low, high = (bound.astype(self._dtype) for bound in task.action_bounds)
        seen_low, seen_high = (bound.astype(self._dtype) for bound in task.bounds(self._known.robot))
        kind = self._dtype.type
        self.action_spaces = {name: gym.spaces.Box(low, high, dtype=kind) for name in self.possible_agents}
        self.observation_spaces = {
            name: gym.spaces.Box(seen_low, seen_high, dtype=kind) for name in self.possible_agents
        }

    def action_space(self, agent: str) -> Any:
        """The space of an agent's actions."""
        return self.action_spaces[agent]

    def observation_space(self, agent: str) -> Any:
        """The space of an agent's observations."""
        return self.observation_spaces[agent]

    def reset(
        self, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[dict[str, Any], dict[str, Any]]:
        """Begin an episode of all agents: with a seed the first of that seed, without one the next.

        Raises
        ------
        ValueError
            If the seed is no whole number from 0 to 2^32 - 2.
        """
        if seed is not None:
            if not isinstance(seed, (int, np.integer)) or not 0 <= seed <= MAX_REPLICA:
                raise ValueError(f"seed: expected a whole number from 0 to {MAX_REPLICA}, got {seed!r}")
            self._begin_first(int(seed))
        elif self._is_begun:
            self.simulation.reset(replicas=list(self.simulation.replicas))
            self._begin_task()
        else:
            self._begin_first(int(self._random.integers(MAX_REPLICA + 1)))
        self._is_begun = True
        self.agents = list(self.possible_agents)
        return self._observations(), {agent: {} for agent in self.agents}

    def step(
        self, actions: dict[str, Any]
    ) -> tuple[dict[str, Any], dict[str, float], dict[str, bool], dict[str, bool], dict[str, Any]]:
        """Take the agents' actions and simulate to the next ones; those whose episodes are over leave `agents`.

        Raises
        ------
        ValueError
            If an agent has no action, or one of another shape or not finite.
        """
        if not self.agents:
            return {}, {}, {}, {}, {}
        self._take(actions)
        for _ in range(self._steps_per_action):
            self.simulation.step()
        outcome = self.task.judge(self.simulation.truth(self._order), self._episode)
        self._count += 1
        acted = {agent: self._row[agent] for agent in self.agents}
        is_late = self._count >= self._horizon
        terminated = {agent: bool(outcome.is_terminated[row]) for agent, row in acted.items()}
        truncated = {agent: is_late and not terminated[agent] for agent in acted}
        infos = {
            agent: {"is_success": bool(outcome.is_success[row])} if terminated[agent] or is_late else {}
            for agent, row in acted.items()
        }
        seen = self._observations()
        self.agents = [agent for agent in acted if not (terminated[agent] or truncated[agent])]
        return seen, {agent: float(outcome.reward[row]) for agent, row in acted.items()}, terminated, truncated, infos

    def state(self) -> npt.NDArray[Any]:
        """The true quantities of all robots, for a critic: `Task.privileged` `(agents * p,)`."""
        return self.task.privileged(self.simulation.truth(self._order), self._episode).astype(self._dtype).ravel()

    def render(self) -> npt.NDArray[np.uint8] | None:
        """A picture `(height, width, 3)`; None without a ``render_mode``."""
        if self.render_mode is None:
            return None
        if self._pictures is None:
            self._pictures = Pictures(self.simulation, SIZE)
        return self._pictures.draw(0, goals_in(self._episode, slice(None)))

    # -------------------------------------------------------------------------------------------------------- inside

    def _begin_first(self, seed: int) -> None:
        self.simulation = Simulation(self._scenario, seed=STUDY, replicas=[seed])
        self._pictures = None
        names = self.simulation.names
        self._known_names = list(self.simulation.frames()[0].names)
        if sorted(self._known_names) != sorted(names):
            raise AmorsimError(f"expected robots that are alike, got others: {', '.join(names)}")
        self._row = {name: row for row, name in enumerate(self._known_names)}
        self._order = [names.index(name) for name in self._known_names]
        self._begin_task()

    def _begin_task(self) -> None:
        count = len(self._known_names)
        self._action = np.zeros((count, len(self.task.action_bounds[0])))
        self._count = 0
        counter = np.zeros((count, 3), dtype=np.uint32)
        counter[:, 0] = self.simulation.replicas[0]
        counter[:, 1] = self.simulation.episodes[0]
        counter[:, 2] = self._order
        draws = Draws(np.full(count, stream_key(STUDY, "task"), dtype=np.uint64), counter)
        self._episode: State = self.task.begin(self.simulation.truth(self._order), draws)

    @property
    def _known(self) -> Known:
        return self.simulation.known(self._known_names)

    def _take(self, actions: dict[str, Any]) -> None:
        low, high = self.task.action_bounds
        self._action[:] = 0.0
        for agent in self.agents:
            taken = np.asarray(actions.get(agent), dtype=float)
            if taken.shape != low.shape or not np.isfinite(taken).all():
                raise ValueError(f"actions: {agent}: expected finite numbers {low.shape}, got {actions.get(agent)!r}")
            self._action[self._row[agent]] = np.clip(taken, low, high)
        forward, turn, left = self.task.velocities(self._action)
        for name, row in self._row.items():
            is_on = name in self.agents
            ask = (float(part[row]) if is_on else 0.0 for part in (forward, turn, left))
            self.simulation.drive(name, **dict(zip(("forward", "turn", "left"), ask, strict=True)))

    def _observations(self) -> dict[str, Any]:
        seen = self.task.observe(Observable(*self._known, self._action), self._episode).astype(self._dtype)
        return {agent: seen[self._row[agent]].copy() for agent in self.agents}
