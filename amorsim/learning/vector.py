"""A Gymnasium vector environment whose environments are the replicas of one simulation."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import gymnasium as gym
import numpy as np
import numpy.typing as npt
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space

from amorsim.array_types import Array, Bools
from amorsim.contracts import Controller, StepOutcome, Task
from amorsim.core.errors import AmorsimError
from amorsim.learning.pictures import RENDER_MODES, Pictures, check_render_mode, goals_in
from amorsim.learning.worlds import Worlds
from amorsim.scenario.parameter_paths import value_in
from amorsim.scenario.spec import Scenario
from amorsim.simulation.simulation import MAX_REPLICA, Simulation

__all__ = ["SimulationVectorEnv"]


_LARGE = 1e6  # no true quantity is larger


class SimulationVectorEnv(VectorEnv[Any, Any, Any]):
    """Environments in one simulation: replica k of it is the environment whose seed is k.

    So ``reset(seed=7)`` of 100 environments simulates the replicas 7 to 106, and environment i is to the bit the single
    one that is reset with the seed 7 + i: whatever the number of environments, threads, and the autoreset mode. A later
    reset without a seed begins the next episode, whose starts, noise and task differ. An episode is known by its seed
    and its number, which the info ``episode_number`` has.

    Parameters
    ----------
    scenario
        With one robot, whose controller the actions replace.
    task
        What is observed, rewarded and drawn.
    num_envs
        Number of environments.
    autoreset_mode
        As Gymnasium has it: ``"NextStep"``, ``"SameStep"`` or ``"Disabled"``.
    privileged
        Whether observations are a dictionary: ``"observation"``, and ``"privileged"`` with true quantities for a
        critic.
    dtype
        Of observations and actions: ``"float32"`` or ``"float64"``.
    threads
        That share the simulation's work; it does not change the bits.
    render_mode
        None; ``"rgb_array"``: `render` returns a picture of each environment, as Gymnasium's `RecordVideo` takes them;
        or ``"human"``, of one environment: the Simulator's window opens in the browser and shows each step, not faster
        than the robot acts. Errors can be set in it while the policy drives.
    controller
        That drives in place of the actions, which do nothing then: to see what it reaches, as `evaluate` does.
    drawn
        Whether the infos of `reset` have ``"drawn"``: the true values that were drawn for each environment's robot, by
        their paths, as ``infos["drawn"]["drive.track"]`` `(num_envs,)`.

    Raises
    ------
    AmorsimError
        If the scenario has another number of robots than one, or a period is not a whole number of its steps.
    """

    def __init__(
        self,
        scenario: Scenario,
        task: Task,
        num_envs: int = 1,
        *,
        autoreset_mode: str | AutoresetMode = AutoresetMode.NEXT_STEP,
        privileged: bool = False,
        dtype: str = "float32",
        threads: int = 1,
        render_mode: str | None = None,
        controller: Controller | None = None,
        drawn: bool = False,
    ) -> None:
        if len(scenario.robots) != 1:
            raise AmorsimError(
                f"expected a scenario with one robot, got one with {len(scenario.robots)}; make_parallel and "
                "make_parallel_vec take several"
            )
        self.task = task
        self.num_envs = num_envs
        self.autoreset_mode = AutoresetMode(autoreset_mode)  # as Gymnasium's own vector environments have it, too
        check_render_mode(render_mode, num_envs)
        self.render_mode = render_mode
        self.metadata = {
            "render_modes": RENDER_MODES,
            "render_fps": round(1.0 / task.period),
            "autoreset_mode": self.autoreset_mode,
        }
        self._pictures: Pictures | None = None
        self._worlds = Worlds(scenario, task, num_envs, dtype=dtype, threads=threads, controller=controller)
        draws = [path for path, error in scenario.robots[0].errors.items() if error.is_drawn]
        self._drawn_paths = draws if drawn else []
        self._is_privileged = privileged
        self._is_begun = False
        self._make_spaces()
        self._count = np.zeros(num_envs, dtype=np.int64)  # actions in each episode
        self._is_over = np.zeros(num_envs, dtype=bool)

    @property
    def simulation(self) -> Simulation:
        """The simulation, whose replicas are the environments."""
        return self._worlds.simulation

    def _make_spaces(self) -> None:
        worlds = self._worlds
        self.single_action_space = worlds.action_space
        space: gym.Space[Any] = worlds.observation_spaces[0]
        if self._is_privileged:
            size = worlds.privileged().shape[2]
            wide = gym.spaces.Box(-_LARGE, _LARGE, (size,), dtype=worlds.dtype.type)
            space = gym.spaces.Dict({"observation": space, "privileged": wide})
        self.single_observation_space = space
        self.action_space = batch_space(self.single_action_space, self.num_envs)
        self.observation_space = batch_space(space, self.num_envs)

    # -------------------------------------------------------------------------------------------------------- episodes

    def reset(
        self, *, seed: int | Sequence[int | None] | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Any, dict[str, Any]]:
        """Begin episodes: in all environments, or in those of ``options["reset_mask"]``.

        Parameters
        ----------
        seed
            A whole number, the first environment's; the others have the following ones. Or a list with one for each. A
            seed begins the first episode of its environment, None the next episode.

        Raises
        ------
        ValueError
            If the seeds are not so many different whole numbers, from 0 to 2^32 - 2; or with a mask.
        """
        mask = self._mask(options)
        if seed is not None:
            if not mask.all():
                raise ValueError("seed: with a reset_mask no seed can be given: a seed is that of an environment")
            self._begin_first(self._seeds(seed))
        elif self._is_begun:
            self._worlds.begin_again(mask)
        elif not mask.all():
            raise ValueError("reset_mask: expected all environments at the first reset")
        else:
            first = int(self.np_random.integers(MAX_REPLICA + 1 - self.num_envs))
            self._begin_first(range(first, first + self.num_envs))
        self._count[mask] = 0
        self._is_over[mask] = False
        infos = self._infos(mask)
        if self._drawn_paths:
            infos |= {"drawn": self._drawn(mask), "_drawn": mask.copy()}
        self._show()
        return self._observations(), infos

    def _drawn(self, mask: Bools) -> dict[str, Any]:
        """The true values that were drawn for the robots, with masks of the environments in `mask`."""
        (name,) = self._worlds.agents
        robots = [self.simulation.robot(name, number).true for number in self.simulation.replicas]
        found: dict[str, Any] = {}
        for path in self._drawn_paths:
            found[path] = np.array([float(value_in(robot, path.split("."))) for robot in robots])
            found[f"_{path}"] = mask.copy()
        return found

    def _seeds(self, seed: int | Sequence[int | None]) -> list[int]:
        if isinstance(seed, (int, np.integer)):
            given: list[Any] = list(range(int(seed), int(seed) + self.num_envs))
        else:
            given = list(seed)
        are_fine = all(isinstance(one, (int, np.integer)) and 0 <= one <= MAX_REPLICA for one in given)
        if not are_fine or len(set(given)) != self.num_envs:
            raise ValueError(
                f"seed: expected one for each of {self.num_envs} environments, different whole numbers from 0 to "
                f"{MAX_REPLICA}, or the first of so many; got {seed!r}"
            )
        return [int(one) for one in given]

    def _mask(self, options: dict[str, Any] | None) -> Bools:
        mask = (options or {}).get("reset_mask")
        if mask is None:
            return np.ones(self.num_envs, dtype=bool)
        if not isinstance(mask, np.ndarray) or mask.dtype != np.bool_:
            raise TypeError(f"reset_mask: expected a numpy array of bool, got {type(mask).__name__}")
        if mask.shape != (self.num_envs,) or not mask.any():
            raise ValueError(f"reset_mask: expected shape ({self.num_envs},) and at least one True, got {mask!r}")
        return mask.copy()

    def _begin_first(self, seeds: Sequence[int]) -> None:
        """Begin the first episodes of these seeds in all environments."""
        self._worlds.begin(seeds)
        self._pictures = None
        self._is_begun = True

    # ------------------------------------------------------------------------------------------------------------ step

    def step(self, actions: Any) -> tuple[Any, Array, Bools, Bools, dict[str, Any]]:
        """Take actions `(num_envs, a)` and simulate to the next ones.

        Raises
        ------
        ValueError
            If the actions have another shape or are not finite; if episodes are over and nobody began new ones.
        """
        if not self._is_begun:
            raise ValueError("expected reset() before the first step")
        again = self._is_over
        some_again = bool(np.count_nonzero(again))
        if self.autoreset_mode is AutoresetMode.DISABLED and some_again:
            raise ValueError(
                f"{int(again.sum())} episodes are over: begin others with reset(options={{'reset_mask': ...}}) first"
            )
        outcome = self._worlds.act(self._taken(actions))
        self._count += 1
        reward, terminated = outcome.reward.copy(), outcome.is_terminated.copy()
        truncated = (self._count >= self._worlds.horizon) & ~terminated
        if some_again:  # the mode is NEXT_STEP: in these the action was for nothing
            self._worlds.begin_again(again)
            reward[again] = 0.0
            terminated[again] = truncated[again] = False
            self._count[again] = 0
        self._is_over = terminated | truncated
        infos = self._infos(again | self._is_over, outcome)
        if self.autoreset_mode is AutoresetMode.SAME_STEP and np.count_nonzero(self._is_over):
            infos |= self._finals(infos)
            over = self._is_over
            self._worlds.begin_again(over)
            self._count[over] = 0
            self._is_over = np.zeros(self.num_envs, dtype=bool)
            infos |= self._infos(over)
        self._show()
        return self._observations(), reward, terminated, truncated, infos

    def _taken(self, actions: Any) -> Array:
        """The actions `(num_envs, 1, a)`."""
        taken = np.asarray(actions, dtype=float)
        expected = self.num_envs, len(self._worlds.low)
        if taken.shape != expected or np.count_nonzero(np.isfinite(taken)) < taken.size:
            raise ValueError(f"actions: expected finite numbers {expected}, got shape {taken.shape}")
        return taken[:, None]

    # ------------------------------------------------------------------------------------------------- what is seen

    def render(self) -> tuple[npt.NDArray[np.uint8], ...] | None:
        """A picture `(height, width, 3)` of each environment; None without pictures."""
        if self.render_mode != "rgb_array":
            return None
        if not self._is_begun:
            raise ValueError("expected reset() before the first picture")
        if self._pictures is None:
            self._pictures = Pictures(self.simulation)
        return tuple(self._pictures.draw(row, goals_in(self._worlds.episode, [row])) for row in range(self.num_envs))

    def _show(self) -> None:
        if self.render_mode == "human":
            self._worlds.show()

    def close_extras(self, **_: Any) -> None:
        """Close the window, if there is one."""
        self._worlds.close()

    def _observations(self) -> Any:
        """Arrays of their own: the next step does not change them."""
        seen = self._worlds.observe()[0]
        if not self._is_privileged:
            return seen
        return {"observation": seen, "privileged": self._worlds.privileged()[:, 0]}

    def _infos(self, which: Bools, outcome: StepOutcome | None = None) -> dict[str, Any]:
        """Infos as Gymnasium has them: arrays, and masks of the environments that they are about."""
        infos: dict[str, Any] = {"episode_number": self.simulation.episodes.copy(), "_episode_number": which.copy()}
        if outcome is not None and np.count_nonzero(self._is_over):
            infos |= {"is_success": outcome.is_success & self._is_over, "_is_success": self._is_over.copy()}
        return infos

    def _finals(self, infos: dict[str, Any]) -> dict[str, Any]:
        """The last observations and infos of episodes that end in this step and begin again in it."""
        over, seen = self._is_over, self._observations()
        final = np.full(self.num_envs, None, dtype=object)
        for row in np.flatnonzero(over).tolist():
            final[row] = {key: part[row] for key, part in seen.items()} if isinstance(seen, dict) else seen[row]
        kept = {key: value for key, value in infos.items() if not key.startswith("_")}
        about = {f"_{key}": over.copy() for key in kept}
        return {
            "final_obs": final,
            "_final_obs": over.copy(),
            "final_info": {**kept, **about},
            "_final_info": over.copy(),
        }
