"""Environments as Stable-Baselines3 has them. It needs `stable-baselines3`, which no extra of amorsim brings."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt
from gymnasium.vector import AutoresetMode
from stable_baselines3.common.vec_env import VecEnv

from amorsim.array_types import AnyArray, Bools
from amorsim.core.errors import AmorsimError
from amorsim.learning.vector import SimulationVectorEnv

__all__ = ["StableBaselinesVecEnv"]


class StableBaselinesVecEnv(VecEnv):  # type: ignore[misc]
    """A vector environment for the algorithms of Stable-Baselines3.

    ::

        model = PPO("MlpPolicy", StableBaselinesVecEnv(make_vec("amorsim/PointGoal-v0", 64, autoreset_mode="SameStep")))

    Infos are empty but at the end of an episode, which has ``terminal_observation``, ``TimeLimit.truncated``,
    ``is_success`` and ``episode``, its return and length.

    Parameters
    ----------
    envs
        Environments that begin again in the step that ends an episode: ``autoreset_mode="SameStep"``.

    Raises
    ------
    AmorsimError
        For another mode.
    """

    def __init__(self, envs: SimulationVectorEnv) -> None:
        if envs.metadata["autoreset_mode"] is not AutoresetMode.SAME_STEP:
            raise AmorsimError('autoreset_mode: Stable-Baselines3 needs "SameStep"')
        self.envs = envs
        self._return = np.zeros(envs.num_envs)
        self._length = np.zeros(envs.num_envs, dtype=np.int64)
        self._nothing: list[dict[str, Any]] = [{} for _ in range(envs.num_envs)]
        super().__init__(envs.num_envs, envs.single_observation_space, envs.single_action_space)

    def reset(self) -> Any:
        """Begin episodes in all environments: the first ones after `seed`, the next ones without it."""
        seeds = self._seeds
        self._reset_seeds()
        first = None if seeds[0] is None else int(seeds[0])
        self._return[:] = 0.0
        self._length[:] = 0
        return self.envs.reset(seed=first)[0]

    def step_async(self, actions: AnyArray) -> None:
        """Keep the actions `(num_envs, a)` for `step_wait`."""
        self._actions = actions

    def step_wait(self) -> tuple[Any, AnyArray, Bools, list[dict[str, Any]]]:
        """Take the actions, and simulate to the next ones."""
        seen, reward, terminated, truncated, infos = self.envs.step(self._actions)
        self._return += reward
        self._length += 1
        over = terminated | truncated
        listed = self._nothing
        if over.any():
            listed = list(listed)
            successes = infos["final_info"]["is_success"]
            for row in np.flatnonzero(over).tolist():
                listed[row] = {
                    "terminal_observation": infos["final_obs"][row],
                    "TimeLimit.truncated": bool(truncated[row]),
                    "is_success": bool(successes[row]),
                    "episode": {"r": float(self._return[row]), "l": int(self._length[row])},
                }
            self._return[over] = 0.0
            self._length[over] = 0
        return seen, reward.astype(np.float32), over, listed

    def close(self) -> None:
        """Close the environments."""
        self.envs.close()

    def get_attr(self, attr_name: str, indices: Any = None) -> list[Any]:
        """An attribute, once for each environment."""
        return [getattr(self.envs, attr_name)] * len(self._numbers(indices))

    def set_attr(self, attr_name: str, value: Any, indices: Any = None) -> None:
        """Refuse: the environments are one object.

        Raises
        ------
        AmorsimError
            Always.
        """
        raise AmorsimError(f"{attr_name}: the environments are one object, and its attributes are not set")

    def env_method(self, method_name: str, *method_args: Any, indices: Any = None, **method_kwargs: Any) -> list[Any]:
        """The result of a method of the environments, called once and given for each of them."""
        result = getattr(self.envs, method_name)(*method_args, **method_kwargs)
        return [result] * len(self._numbers(indices))

    def env_is_wrapped(self, wrapper_class: Any, indices: Any = None) -> list[bool]:
        """Whether the wrapper is around each environment: around none."""
        return [False] * len(self._numbers(indices))

    def get_images(self) -> Sequence[npt.NDArray[np.uint8] | None]:
        """Pictures of the environments, where they were made with ``render_mode="rgb_array"``."""
        found: Sequence[npt.NDArray[np.uint8]] | None = self.envs.render()
        return [None] * self.num_envs if found is None else found

    def _numbers(self, indices: Any) -> list[int]:
        return list(self._get_indices(indices))
