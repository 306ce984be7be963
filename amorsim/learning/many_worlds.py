"""Many worlds of several robots at once: PettingZoo's parallel interface, with an axis for the worlds."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from amorsim.array_types import AnyArray, Array, Bools
from amorsim.contracts import Task
from amorsim.learning.worlds import Worlds
from amorsim.scenario.spec import Scenario
from amorsim.simulation.simulation import MAX_REPLICA, Simulation

__all__ = ["SimulationParallelVectorEnv"]

ByAgent = dict[str, Any]


class SimulationParallelVectorEnv:
    """Many worlds of `SimulationParallelEnv` in one simulation: what an agent has there is an array over worlds here.

    World w of ``reset(seed=7)`` is to the bit the one that ``SimulationParallelEnv.reset(seed=7 + w)`` begins. An agent
    whose episode is over stands, with rewards of 0, until all agents of its world are over; the world's next episode
    begins in the step after that, in which actions do nothing there.

    Parameters
    ----------
    scenario, task, dtype
        As of `SimulationParallelEnv`.
    num_worlds
        Number of worlds.
    threads
        That share the simulation's work; it does not change the bits.

    Raises
    ------
    AmorsimError
        If a period is not a whole number of the scenario's steps.
    """

    def __init__(
        self, scenario: Scenario, task: Task, num_worlds: int, *, dtype: str = "float32", threads: int = 1
    ) -> None:
        self.task, self.num_worlds = task, num_worlds
        self._worlds = Worlds(scenario, task, num_worlds, dtype=dtype, threads=threads)
        self.possible_agents = list(self._worlds.agents)
        self.single_action_spaces = dict.fromkeys(self.possible_agents, self._worlds.action_space)
        self.single_observation_spaces = dict(zip(self.possible_agents, self._worlds.observation_spaces, strict=True))
        self._is_begun = False
        self._count = np.zeros(num_worlds, dtype=np.int64)
        self._is_on = np.ones((num_worlds, len(self.possible_agents)), dtype=bool)

    @property
    def simulation(self) -> Simulation:
        """The simulation, whose replicas are the worlds."""
        return self._worlds.simulation

    @property
    def active(self) -> Bools:
        """The agents whose episodes go on `(num_worlds, agents)`."""
        return self._is_on.copy()

    def reset(self, seed: int | Sequence[int] | None = None) -> tuple[ByAgent, ByAgent]:
        """Begin episodes in all worlds: with a seed the first of that and the following seeds, without one the next.

        Raises
        ------
        ValueError
            If the seeds are not so many different whole numbers from 0 to 2^32 - 2.
        """
        if seed is None and self._is_begun:
            self._worlds.begin_again(np.ones(self.num_worlds, dtype=bool))
        else:
            if seed is None:
                seed = int(np.random.default_rng().integers(MAX_REPLICA + 1 - self.num_worlds))
            self._worlds.begin(range(seed, seed + self.num_worlds) if isinstance(seed, (int, np.integer)) else seed)
        self._is_begun = True
        self._count[:] = 0
        self._is_on[:] = True
        return self._observations(), self._infos(np.zeros_like(self._is_on), self._is_on)

    def step(self, actions: Mapping[str, Any]) -> tuple[ByAgent, ByAgent, ByAgent, ByAgent, ByAgent]:
        """Take actions `(num_worlds, a)` of each agent, and simulate to the next ones.

        Returns
        -------
        observations, rewards, terminations, truncations, infos
            By agent, arrays over the worlds. The infos have ``is_success``, and ``active``: who acted in this step.

        Raises
        ------
        ValueError
            If an agent has no actions, or they are of another shape or not finite.
        """
        if not self._is_begun:
            raise ValueError("expected reset() before the first step")
        again = np.asarray(~self._is_on.any(axis=1))
        acted = self._is_on.copy()
        outcome = self._worlds.act(self._taken(actions), acted)
        shape = acted.shape
        self._count += 1
        terminated = outcome.is_terminated.reshape(shape) & acted
        truncated = (self._count >= self._worlds.horizon)[:, None] & acted & ~terminated
        self._is_on = acted & ~(terminated | truncated)
        if again.any():
            self._worlds.begin_again(again)
            self._count[again] = 0
            self._is_on[again] = True
        rewards = np.where(acted, outcome.reward.reshape(shape), 0.0)
        success = outcome.is_success.reshape(shape) & (terminated | truncated)
        reward, ended, late = (self._by_agent(array) for array in (rewards, terminated, truncated))
        return self._observations(), reward, ended, late, self._infos(success, acted)

    def state(self) -> AnyArray:
        """The true quantities of all robots of each world, for a critic `(num_worlds, agents * p)`."""
        return self._worlds.privileged().reshape(self.num_worlds, -1)

    def _taken(self, actions: Mapping[str, Any]) -> Array:
        shape = self.num_worlds, len(self._worlds.low)
        taken = np.empty((self.num_worlds, len(self.possible_agents), shape[1]))
        for column, agent in enumerate(self.possible_agents):
            one = np.asarray(actions.get(agent), dtype=float)
            if one.shape != shape or not np.isfinite(one).all():
                raise ValueError(f"actions: {agent}: expected finite numbers {shape}, got shape {one.shape}")
            taken[:, column] = one
        return taken

    def _observations(self) -> ByAgent:
        return dict(zip(self.possible_agents, self._worlds.observe(), strict=True))

    def _by_agent(self, array: AnyArray) -> ByAgent:
        return {agent: np.ascontiguousarray(array[:, column]) for column, agent in enumerate(self.possible_agents)}

    def _infos(self, success: Bools, acted: Bools) -> ByAgent:
        return {
            agent: {"is_success": success[:, column].copy(), "active": acted[:, column].copy()}
            for column, agent in enumerate(self.possible_agents)
        }
