"""One environment of a scenario and a task, as Gymnasium has it."""

from __future__ import annotations

from typing import Any

import gymnasium as gym
import numpy as np
from gymnasium.vector import AutoresetMode

from amorsim.contracts import Task
from amorsim.learning.vector import SimulationVectorEnv
from amorsim.scenario.spec import Scenario

__all__ = ["SimulationEnv"]


class SimulationEnv(gym.Env[Any, Any]):
    """One environment: ``reset(seed=7)`` simulates replica 7, to the bit as a vector environment does.

    Parameters
    ----------
    scenario, task
        As of `SimulationVectorEnv`; so are the others.
    """

    def __init__(
        self,
        scenario: Scenario,
        task: Task,
        *,
        privileged: bool = False,
        dtype: str = "float32",
        render_mode: str | None = None,
    ) -> None:
        self._many = SimulationVectorEnv(
            scenario,
            task,
            1,
            autoreset_mode=AutoresetMode.DISABLED,
            privileged=privileged,
            dtype=dtype,
            render_mode=render_mode,
        )
        self.render_mode = render_mode
        self.metadata = {key: self._many.metadata[key] for key in ("render_modes", "render_fps")}
        self.action_space = self._many.single_action_space
        self.observation_space = self._many.single_observation_space

    @property
    def simulation(self) -> Any:
        """The simulation, of one replica."""
        return self._many.simulation

    def render(self) -> Any:
        """A picture `(height, width, 3)`; None without pictures."""
        found = self._many.render()
        return None if found is None else found[0]

    def close(self) -> None:
        """Close the window, if there is one."""
        self._many.close()

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        """Begin an episode: with a seed the first of that seed, without one the next."""
        super().reset(seed=seed)
        seen, infos = self._many.reset(seed=seed)
        return _first(seen), _of_first(infos)

    def step(self, action: Any) -> tuple[Any, float, bool, bool, dict[str, Any]]:
        """Take an action and simulate to the next one."""
        seen, reward, terminated, truncated, infos = self._many.step(np.asarray(action)[None])
        return _first(seen), float(reward[0]), bool(terminated[0]), bool(truncated[0]), _of_first(infos)


def _first(seen: Any) -> Any:
    return {key: part[0] for key, part in seen.items()} if isinstance(seen, dict) else seen[0]


def _of_first(infos: dict[str, Any]) -> dict[str, Any]:
    return {
        key: value[0].item() for key, value in infos.items() if not key.startswith("_") and infos.get(f"_{key}", [1])[0]
    }
