"""How well a policy, a rule or a controller does in an environment."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from gymnasium.vector import AutoresetMode, VectorEnv

from amorsim.array_types import AnyArray
from amorsim.core.error_text import in_words

__all__ = ["Evaluation", "evaluate"]


class Evaluation(NamedTuple):
    """The outcome of one episode in each environment; shares from 0 to 1."""

    episodes: int
    success: float  # share of the episodes that ended with the task done
    failure: float  # share that ended by what happened, without success: a collision, a leader that was lost
    mean_return: float  # the sum of an episode's rewards, on average
    mean_steps: float  # actions in an episode, on average

    def __str__(self) -> str:
        return (
            f"{self.episodes} episodes: {self.success:.1%} done, {self.failure:.1%} failed, return "
            f"{self.mean_return:.2f}, {self.mean_steps:.0f} steps on average"
        )


def evaluate(
    envs: VectorEnv[Any, Any, Any], act: Callable[[Any], AnyArray] | None = None, *, seed: int = 0
) -> Evaluation:
    """Let each environment play the first episode of its seed, and tell how they end.

    ::

        evaluate(make_vec("amorsim/PointGoal-v0", 200), lambda seen: model.predict(seen, deterministic=True)[0])
        evaluate(make_vec("amorsim/Follow-v0", 200, controller=am.controllers.Follow()))

    Parameters
    ----------
    envs
        Environments that begin again by themselves, in the next step or in the same. Their infos have ``is_success``.
    act
        The actions for the observations of all; None where a controller drives.
    seed
        Of the first environment; the others have the following ones.

    Raises
    ------
    TypeError
        If it is not a vector environment.
    ValueError
        If the environments do not begin again by themselves.
    """
    if not isinstance(envs, VectorEnv):
        raise TypeError(f"envs: expected a vector environment, as make_vec() returns, got {in_words(envs)}")
    if envs.metadata.get("autoreset_mode") is AutoresetMode.DISABLED:
        raise ValueError("envs: expected the autoreset mode NextStep or SameStep, got Disabled")
    count = envs.num_envs
    seen, _ = envs.reset(seed=seed)
    is_over, done, failed = (np.zeros(count, dtype=bool) for _ in range(3))
    total, steps = np.zeros(count), np.zeros(count)
    nothing = np.zeros(envs.action_space.shape or (count,))
    while not is_over.all():
        seen, reward, terminated, truncated, infos = envs.step(nothing if act is None else act(seen))
        total += np.where(is_over, 0.0, reward)
        steps += ~is_over
        new = (terminated | truncated) & ~is_over
        if new.any():
            success = np.asarray(infos["is_success"], dtype=bool)
            done |= new & success
            failed |= new & terminated & ~success
            is_over |= new
    shares = float(done.mean()), float(failed.mean())
    return Evaluation(count, *shares, float(total.mean()), float(steps.mean()))
