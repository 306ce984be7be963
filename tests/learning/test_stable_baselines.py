"""Environments for Stable-Baselines3, which the nightly tests install."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

pytest.importorskip("stable_baselines3", reason="only the nightly tests install it")

import numpy as np
from stable_baselines3 import PPO
from stable_baselines3.common.env_checker import check_env

import amorsim as am
from amorsim.learning import make, make_vec
from amorsim.learning.stable_baselines import StableBaselinesVecEnv

ROOT = Path(__file__).resolve().parents[2]
pytestmark = pytest.mark.nightly
NAME = "amorsim/PointGoal-v0"


def test_one_environment_passes_its_checker() -> None:
    check_env(make(NAME))


def test_what_it_returns_is_what_the_environments_return() -> None:
    given = {"autoreset_mode": "SameStep", "horizon": 2.0}
    wrapped, plain = StableBaselinesVecEnv(make_vec(NAME, 5, **given)), make_vec(NAME, 5, **given)
    wrapped.seed(9)
    np.testing.assert_array_equal(wrapped.reset(), plain.reset(seed=9)[0])
    returns, ended = np.zeros(5), 0
    actions = np.random.default_rng(1).uniform(-1.0, 1.0, (60, 5, 2)).astype(np.float32)
    for each in actions:
        seen, reward, over, infos = wrapped.step(each)
        expected, gained, terminated, truncated, told = plain.step(each)
        np.testing.assert_array_equal(seen, expected)
        np.testing.assert_array_equal(reward, gained.astype(np.float32))
        np.testing.assert_array_equal(over, terminated | truncated)
        returns += gained
        for row, info in enumerate(infos):
            assert bool(info) == over[row]
            if over[row]:
                np.testing.assert_array_equal(info["terminal_observation"], told["final_obs"][row])
                assert info["TimeLimit.truncated"] == truncated[row]
                assert info["episode"]["r"] == pytest.approx(returns[row])
                returns[row], ended = 0.0, ended + 1
    assert ended >= 15


def test_other_modes_are_refused() -> None:
    with pytest.raises(am.AmorsimError, match="SameStep"):
        StableBaselinesVecEnv(make_vec(NAME, 2))


def test_ppo_learns_something() -> None:
    """Within 60,000 steps the return rises by more than the least that chance could do."""
    envs = StableBaselinesVecEnv(make_vec(NAME, 64, autoreset_mode="SameStep", distance=(1.0, 1.5)))
    model = PPO("MlpPolicy", envs, n_steps=64, batch_size=2048, n_epochs=6, learning_rate=1e-3, seed=1, device="cpu")
    model.learn(8_192)
    before = np.mean([episode["r"] for episode in model.ep_info_buffer])
    model.learn(60_000, reset_num_timesteps=False)
    assert np.mean([episode["r"] for episode in model.ep_info_buffer]) > before + 2.0


def test_the_example_trains_and_writes_a_policy(tmp_path: Path) -> None:
    pytest.importorskip("onnx", reason="only the nightly tests install it")
    example = ROOT / "docs" / "examples" / "learning" / "learn_point_goal.py"
    given = ["--minutes", "0.1", "--episodes", "20", "--envs", "16", "--out", str(tmp_path / "policy.onnx")]
    ended = subprocess.run([sys.executable, example, *given], capture_output=True, text=True, cwd=ROOT, check=False)
    assert ended.returncode == 0, ended.stderr
    assert "20 episodes:" in ended.stdout
    assert 10_000 < (tmp_path / "policy.onnx").stat().st_size < 300_000
