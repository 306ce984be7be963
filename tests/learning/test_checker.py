"""The checker of vector environments: Gymnasium's own pass, and each broken rule is found."""

from __future__ import annotations

from typing import Any

import pytest

gym = pytest.importorskip("gymnasium", reason="the extra 'learn' is not installed")

import numpy as np  # noqa: E402
from gymnasium.vector import AutoresetMode, SyncVectorEnv  # noqa: E402

from amorsim.core.parameters import ParameterError  # noqa: E402
from amorsim.testing import check_vector_env  # noqa: E402


class Cart(SyncVectorEnv):
    """Three poles, which fall within some steps."""

    def __init__(self, mode: AutoresetMode = AutoresetMode.NEXT_STEP) -> None:
        super().__init__([lambda: gym.make("CartPole-v1")] * 3, autoreset_mode=mode)


@pytest.mark.parametrize("mode", list(AutoresetMode))
def test_gymnasiums_own_keep_the_rules(mode: AutoresetMode) -> None:
    check_vector_env(Cart(mode), steps=60)


@pytest.mark.parametrize(("env", "steps", "name"), [(1.0, 200, "env"), (None, 0, "steps"), (None, 1e-320, "steps")])
def test_something_else_is_refused_with_what_is_expected(env: Any, steps: Any, name: str) -> None:
    with pytest.raises(ParameterError, match=f"^{name}: expected a"):
        check_vector_env(Cart() if env is None else env, steps=steps)


class Shared(Cart):
    def step(self, actions: Any) -> Any:
        seen, *rest = super().step(actions)
        self.last = getattr(self, "last", seen)
        self.last[:] = seen
        return self.last, *rest


class Coupled(Cart):
    def step(self, actions: Any) -> Any:
        return super().step(np.full_like(actions, actions[0]))


class Wide(Cart):
    def step(self, actions: Any) -> Any:
        seen, *rest = super().step(actions)
        return seen.astype(np.float64), *rest


class Unseeded(Cart):
    def reset(self, *, seed: Any = None, options: Any = None) -> Any:
        return super().reset(options=options)


class OtherSeeds(Cart):
    def reset(self, *, seed: Any = None, options: Any = None) -> Any:
        return super().reset(seed=None if seed is None else 7 if isinstance(seed, int) else seed, options=options)


class Unmasked(Cart):
    def step(self, actions: Any) -> Any:
        *rest, infos = super().step(actions)
        return *rest, {**infos, "speed": np.zeros(3)}


class Rewarded(Cart):
    def step(self, actions: Any) -> Any:
        seen, reward, *rest = super().step(actions)
        return seen, reward + 1.0, *rest


class NoFinals(Cart):
    def __init__(self) -> None:
        super().__init__(AutoresetMode.SAME_STEP)

    def step(self, actions: Any) -> Any:
        *rest, _ = super().step(actions)
        return *rest, {}


class MaskBlind(Cart):
    def __init__(self) -> None:
        super().__init__(AutoresetMode.DISABLED)

    def reset(self, *, seed: Any = None, options: Any = None) -> Any:
        return super().reset(seed=seed)


class Undeclared(Cart):
    def __init__(self) -> None:
        super().__init__()
        self.metadata = {}


@pytest.mark.parametrize(
    ("kind", "words"),
    [
        (Shared, "changed by a later one"),
        (Coupled, "other actions of the first environment"),
        (Wide, "not in observation_space"),
        (Unseeded, "the same seed and the same actions"),
        (OtherSeeds, "the list of seeds"),
        (Unmasked, "infos: speed has no mask"),
        (Rewarded, "begins an episode again has a reward"),
        (NoFinals, "have no final_obs"),
        (MaskBlind, "a reset with a mask changed"),
        (Undeclared, "expected an AutoresetMode"),
    ],
)
def test_a_broken_rule_is_found(kind: type[Cart], words: str) -> None:
    with pytest.raises(AssertionError, match=words):
        check_vector_env(kind(), steps=60)
