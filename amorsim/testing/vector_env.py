"""A check of Gymnasium's rules for vector environments, of amorsim's or of anyone's."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, Any

import numpy as np

from amorsim.array_types import Bools
from amorsim.core.arguments import check_kind, whole

if TYPE_CHECKING:
    from gymnasium.vector import VectorEnv

__all__ = ["check_vector_env"]

STEPS = 200  # that are made to see how episodes end
SEED = 12

Step = tuple[Any, Any, Any, Any, dict[str, Any]]


def check_vector_env(env: VectorEnv[Any, Any, Any], *, steps: int = STEPS) -> None:
    """Check that a vector environment keeps Gymnasium's rules; it needs the extra ``learn``.

    Spaces are batches of the single ones; observations, rewards and ends have their shapes, types and bounds; a seed,
    and a list of the same seeds, repeat an episode; what was returned is not changed later; an environment does not
    depend on the actions of another; episodes begin again as ``metadata["autoreset_mode"]`` has it; infos have masks.

    Parameters
    ----------
    env
        With two environments or more; it is reset.
    steps
        That are made to see episodes end. Rules about ends are checked only if some end.

    Raises
    ------
    AssertionError
        With a line for each rule that is broken.
    ParameterError
        For something else than a vector environment.
    """
    from gymnasium.vector import VectorEnv

    check_kind(env, VectorEnv, "env", "a VectorEnv, as gymnasium.make_vec('amorsim/PointGoal-v0', 8)")
    steps = whole(steps, "steps", "a number of steps >= 1", 1)
    problems = list(dict.fromkeys(_problems(env, steps)))
    if problems:
        raise AssertionError(f"{type(env).__name__}:\n" + "\n".join(f"- {problem}" for problem in problems))


def _problems(env: VectorEnv[Any, Any, Any], steps: int) -> Iterator[str]:
    yield from _of_spaces(env)
    mode = env.metadata.get("autoreset_mode")
    if getattr(mode, "value", mode) not in ("NextStep", "SameStep", "Disabled"):
        yield f"metadata['autoreset_mode']: expected an AutoresetMode, got {mode!r}"
        return
    env.action_space.seed(SEED)
    actions = [env.action_space.sample() for _ in range(steps)]
    first = list(_episodes(env, actions, SEED))
    yield from _of_steps(env, first)
    yield from _of_ends(env, first, str(getattr(mode, "value", mode)))
    again = list(_episodes(env, actions, SEED))
    if _differs(first, again):
        yield "the same seed and the same actions gave other results"
    listed = list(_episodes(env, actions[:5], [SEED + i for i in range(env.num_envs)]))
    if _differs(first[:6], listed):
        yield f"seed={SEED} gave other results than the list of seeds {SEED}, {SEED + 1} and so on"
    yield from _of_rows(env, actions, first)


def _of_spaces(env: VectorEnv[Any, Any, Any]) -> Iterator[str]:
    from gymnasium.vector.utils import batch_space

    for name in ("observation", "action"):
        single, batched = getattr(env, f"single_{name}_space"), getattr(env, f"{name}_space")
        if batch_space(single, env.num_envs) != batched:
            yield f"{name}_space is not a batch of {env.num_envs} of single_{name}_space"


class _Moment:
    """The result of one call, and a copy of it made then."""

    def __init__(self, returned: Step, ended_before: Bools) -> None:
        self.returned = returned
        self.then = _copied(returned[:4])
        self.ended_before = ended_before
        self.ends = np.asarray(returned[2], dtype=bool) | np.asarray(returned[3], dtype=bool)


def _episodes(env: VectorEnv[Any, Any, Any], actions: list[Any], seed: Any) -> Iterator[_Moment]:
    """A reset and steps; of the reset, reward and ends are 0. Where ended episodes wait, new ones are begun."""
    mode = env.metadata["autoreset_mode"]
    nothing = np.zeros(env.num_envs, dtype=bool)
    seen, infos = env.reset(seed=seed)
    yield _Moment((seen, np.zeros(env.num_envs), nothing, nothing, infos), nothing)
    ended = nothing
    for action in actions:
        if getattr(mode, "value", mode) == "Disabled" and ended.any():
            env.reset(options={"reset_mask": ended})
        moment = _Moment(env.step(action), ended)
        ended = moment.ends
        yield moment


def _of_steps(env: VectorEnv[Any, Any, Any], moments: list[_Moment]) -> Iterator[str]:
    for moment in moments:
        seen, reward, terminated, truncated, infos = moment.returned
        if seen not in env.observation_space:
            yield "observations are not in observation_space (shape, dtype or bounds)"
        if not isinstance(reward, np.ndarray) or reward.shape != (env.num_envs,) or reward.dtype.kind != "f":
            yield f"reward: expected an array of floats ({env.num_envs},), got {_form(reward)}"
        for name, one in (("terminated", terminated), ("truncated", truncated)):
            if not isinstance(one, np.ndarray) or one.shape != (env.num_envs,) or one.dtype != np.bool_:
                yield f"{name}: expected an array of bool ({env.num_envs},), got {_form(one)}"
        yield from _of_infos(env, infos)
        if _differs(moment.then, moment.returned[:4]):
            yield "what a step returned was changed by a later one"


def _of_infos(env: VectorEnv[Any, Any, Any], infos: dict[str, Any], above: str = "") -> Iterator[str]:
    for key, value in infos.items():
        if key.startswith("_"):
            continue
        mask = infos.get(f"_{key}")
        if not isinstance(mask, np.ndarray) or mask.shape != (env.num_envs,) or mask.dtype != np.bool_:
            yield f"infos: {above}{key} has no mask _{key} of bool ({env.num_envs},)"
        if isinstance(value, dict):
            yield from _of_infos(env, value, f"{above}{key}.")
        elif not isinstance(value, np.ndarray) or len(value) != env.num_envs:
            yield f"infos: {above}{key}: expected an array with {env.num_envs} rows, got {_form(value)}"


def _of_ends(env: VectorEnv[Any, Any, Any], moments: list[_Moment], mode: str) -> Iterator[str]:
    for moment in moments[1:]:
        _, reward, _, _, infos = moment.returned
        before = moment.ended_before
        if mode == "NextStep" and (np.asarray(reward)[before].any() or moment.ends[before].any()):
            yield "NextStep: the step that begins an episode again has a reward, or ends it"
        if mode == "SameStep" and moment.ends.any():
            finals, mask = infos.get("final_obs"), infos.get("_final_obs")
            if finals is None or mask is None or "final_info" not in infos:
                yield "SameStep: infos of a step that ends episodes have no final_obs, _final_obs and final_info"
            elif (np.asarray(mask) != moment.ends).any():
                yield "SameStep: _final_obs does not mark the episodes that ended"
            elif any(finals[row] not in env.single_observation_space for row in np.flatnonzero(mask).tolist()):
                yield "SameStep: a final_obs is not in single_observation_space"
    if mode == "Disabled":
        yield from _of_masks(env)


def _of_masks(env: VectorEnv[Any, Any, Any]) -> Iterator[str]:
    """Check that a reset of one environment changes no other."""
    env.reset(seed=SEED)
    before = _copied(env.step(env.action_space.sample())[0])
    mask = np.zeros(env.num_envs, dtype=bool)
    mask[0] = True
    seen, _ = env.reset(options={"reset_mask": mask})
    if _differs(_rows(before, slice(1, None)), _rows(seen, slice(1, None))):
        yield "Disabled: a reset with a mask changed the observations of environments that are not in it"


def _of_rows(env: VectorEnv[Any, Any, Any], actions: list[Any], moments: list[_Moment]) -> Iterator[str]:
    """Check that other actions of the first environment change no other one, as long as no episode ends."""
    other = []
    for action in actions:
        changed = _copied(action)
        for part, single in zip(_leaves(changed), _leaves(env.action_space.sample()), strict=True):
            part[0] = single[0]
        other.append(changed)
    for moment, again in zip(moments, _episodes(env, other, SEED), strict=True):
        rest = slice(1, None)
        if any(_differs(_rows(one, rest), _rows(two, rest)) for one, two in zip(moment.then, again.then, strict=True)):
            yield "other actions of the first environment changed the results of others"
            return


# ------------------------------------------------------------------------------------------------------ nested arrays


def _map(change: Callable[[Any], Any], value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _map(change, one) for key, one in value.items()}
    if isinstance(value, (tuple, list)):
        return tuple(_map(change, one) for one in value)
    return change(value)


def _copied(value: Any) -> Any:
    return _map(lambda one: one.copy() if isinstance(one, np.ndarray) else one, value)


def _rows(value: Any, rows: slice) -> Any:
    return _map(lambda one: np.asarray(one)[rows], value)


def _leaves(value: Any) -> list[Any]:
    found: list[Any] = []
    _map(found.append, value)
    return found


def _differs(one: Any, other: Any) -> bool:
    """Whether nested arrays, or lists of moments, differ in a bit."""
    if isinstance(one, list):
        return any(_differs(a.then, b.then) for a, b in zip(one, other, strict=True))
    mine, others = _leaves(one), _leaves(other)
    return len(mine) != len(others) or not all(
        np.array_equal(a, b, equal_nan=np.asarray(a).dtype.kind == "f") for a, b in zip(mine, others, strict=True)
    )


def _form(value: Any) -> str:
    return f"{value.dtype} {value.shape}" if isinstance(value, np.ndarray) else type(value).__name__
