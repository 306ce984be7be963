"""The robots of one world as PettingZoo's agents, which act at the same time."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
from pettingzoo import ParallelEnv

from amorsim.array_types import AnyArray, Array, Bools
from amorsim.contracts import Task
from amorsim.learning.pictures import RENDER_MODES, Pictures, check_render_mode, goals_in
from amorsim.learning.worlds import Worlds
from amorsim.scenario.spec import Scenario
from amorsim.simulation.simulation import MAX_REPLICA, Simulation

__all__ = ["SimulationParallelEnv"]


class SimulationParallelEnv(ParallelEnv):  # type: ignore[misc]
    """The robots of a scenario as agents, by their names: each has the task for itself, and meets the others.

    ``reset(seed=7)`` simulates replica 7; a later reset without a seed begins its next episode. An agent whose episode
    is over stands where it is, in the way of the others, until all are over.

    Parameters
    ----------
    scenario
        Its robots may be of several models: each agent has an observation space of its own. Their controllers are
        replaced.
    task
        What each observes, is rewarded for, and draws.
    dtype
        Of observations and actions: ``"float32"`` or ``"float64"``.
    render_mode
        None, ``"rgb_array"``, or ``"human"``: the Simulator's window, as of `SimulationVectorEnv`.

    Raises
    ------
    AmorsimError
        If a period is not a whole number of the scenario's steps.
    """

    def __init__(
        self, scenario: Scenario, task: Task, *, dtype: str = "float32", render_mode: str | None = None
    ) -> None:
        check_render_mode(render_mode, 1)
        self.task, self.render_mode = task, render_mode
        self.metadata = {
            "name": "amorsim",
            "render_modes": RENDER_MODES,
            "render_fps": round(1.0 / task.period),
            "is_parallelizable": True,
        }
        self._worlds = Worlds(scenario, task, 1, dtype=dtype)
        self._random = np.random.default_rng()
        self._pictures: Pictures | None = None
        self._is_begun, self._count = False, 0
        self.possible_agents = list(self._worlds.agents)
        self.agents: list[str] = []
        self.action_spaces = dict.fromkeys(self.possible_agents, self._worlds.action_space)
        self.observation_spaces = dict(zip(self.possible_agents, self._worlds.observation_spaces, strict=True))

    @property
    def simulation(self) -> Simulation:
        """The simulation, of one replica."""
        return self._worlds.simulation

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
            If the seed is not a whole number from 0 to 2^32 - 2.
        """
        if seed is None and self._is_begun:
            self._worlds.begin_again(np.array([True]))
        else:
            self._worlds.begin([int(self._random.integers(MAX_REPLICA + 1)) if seed is None else seed])
            self._pictures = None
        self._is_begun, self._count = True, 0
        self.agents = list(self.possible_agents)
        self._show()
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
        outcome = self._worlds.act(*self._taken(actions))
        self._count += 1
        acted = {agent: self.possible_agents.index(agent) for agent in self.agents}
        is_late = self._count >= self._worlds.horizon
        terminated = {agent: bool(outcome.is_terminated[row]) for agent, row in acted.items()}
        truncated = {agent: is_late and not terminated[agent] for agent in acted}
        infos = {
            agent: {"is_success": bool(outcome.is_success[row])} if terminated[agent] or is_late else {}
            for agent, row in acted.items()
        }
        self._show()
        seen = self._observations()
        self.agents = [agent for agent in acted if not (terminated[agent] or truncated[agent])]
        return seen, {agent: float(outcome.reward[row]) for agent, row in acted.items()}, terminated, truncated, infos

    def state(self) -> AnyArray:
        """The true quantities of all robots, for a critic: `Task.privileged` `(agents * p,)`."""
        return self._worlds.privileged().ravel()

    def render(self) -> npt.NDArray[np.uint8] | None:
        """A picture `(height, width, 3)`; None without pictures."""
        if self.render_mode != "rgb_array":
            return None
        if self._pictures is None:
            self._pictures = Pictures(self.simulation)
        return self._pictures.draw(0, goals_in(self._worlds.episode, slice(None)))

    def close(self) -> None:
        """Close the window, if there is one."""
        self._worlds.close()

    def _show(self) -> None:
        if self.render_mode == "human":
            self._worlds.show()

    def _taken(self, actions: dict[str, Any]) -> tuple[Array, Bools]:
        """The actions `(1, A, a)`, and who acts `(1, A)`."""
        worlds = self._worlds
        taken = np.zeros((1, len(worlds.agents), len(worlds.low)))
        is_on = np.zeros((1, len(worlds.agents)), dtype=bool)
        for agent in self.agents:
            one = np.asarray(actions.get(agent), dtype=float)
            if one.shape != worlds.low.shape or not np.isfinite(one).all():
                raise ValueError(
                    f"actions: {agent}: expected finite numbers {worlds.low.shape}, got {actions.get(agent)!r}"
                )
            column = worlds.agents.index(agent)
            taken[0, column], is_on[0, column] = one, True
        return taken, is_on

    def _observations(self) -> dict[str, Any]:
        seen = dict(zip(self.possible_agents, self._worlds.observe(), strict=True))
        return {agent: seen[agent][0] for agent in self.agents}
