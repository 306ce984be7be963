"""Learn to drive to goals in an office, by PPO, and write the policy as ONNX, which `use = "policy"` drives by.

    python -m pip install -e ".[learn]" torch stable-baselines3 onnx
    python docs/examples/learning/learn_point_goal.py --minutes 10

It prints how training goes, then what the policy reaches in 1,000 episodes that it has not seen, without exploring.
"""

from __future__ import annotations

import argparse
import time
import warnings

import numpy as np
import torch
from gymnasium.spaces import Box
from stable_baselines3 import PPO
from stable_baselines3.common.callbacks import BaseCallback
from stable_baselines3.common.torch_layers import BaseFeaturesExtractor

from amorsim.learning import evaluate, make_vec
from amorsim.learning.stable_baselines import StableBaselinesVecEnv

TASK = "amorsim/PointGoal-v0"
LONGEST, FADES = 8.0, 0.7  # [m] range of the laser, and the distance in which nearness fades to 37 %
HELD_OUT = 1_000_000  # the first seed of the episodes of the test


class Clock(BaseCallback):
    """Ends training when the time is up, lets the step of learning shrink, and prints how it goes."""

    def __init__(self, minutes: float) -> None:
        super().__init__()
        self.begin, self.seconds, self.shown = time.monotonic(), 60.0 * minutes, 0.0

    def left(self) -> float:
        return max(0.0, 1.0 - (time.monotonic() - self.begin) / self.seconds)

    def _on_rollout_end(self) -> None:
        spent = time.monotonic() - self.begin
        if spent - self.shown >= 10.0:
            self.shown = spent
            successes = np.mean(self.model.ep_success_buffer)
            returns = np.mean([episode["r"] for episode in self.model.ep_info_buffer])
            print(
                f"{spent:6.0f} s {self.num_timesteps:9d} steps: {successes:6.1%} reached, return {returns:6.2f}",
                flush=True,
            )

    def _on_step(self) -> bool:
        return self.left() > 0.0


class Nearness(BaseFeaturesExtractor):
    """Ranges as nearness, 1 at a wall and 0 far from it: a decimetre matters near a wall, and not across a room."""

    def __init__(self, space: Box) -> None:
        super().__init__(space, space.shape[0])

    def forward(self, observation: torch.Tensor) -> torch.Tensor:
        goal, ranges = observation[:, :5], observation[:, 5:]
        return torch.cat((0.25 * goal[:, :1], goal[:, 1:], torch.exp(-LONGEST * ranges / FADES)), dim=1)


class Actor(torch.nn.Module):
    """The mean of a policy's actions, within their bounds."""

    def __init__(self, policy: torch.nn.Module) -> None:
        super().__init__()
        self.policy = policy

    def forward(self, observation: torch.Tensor) -> torch.Tensor:
        features = self.policy.pi_features_extractor(observation)
        return torch.clamp(self.policy.action_net(self.policy.mlp_extractor.forward_actor(features)), -1.0, 1.0)


def train(minutes: float, seed: int, envs: int) -> PPO:
    clock = Clock(minutes)
    model = PPO(
        "MlpPolicy",
        StableBaselinesVecEnv(make_vec(TASK, envs, autoreset_mode="SameStep", threads=2)),
        n_steps=64,
        batch_size=4096,
        n_epochs=6,
        learning_rate=lambda _: max(1e-4, 1e-3 * clock.left()),
        policy_kwargs={"net_arch": [64, 64], "log_std_init": -0.5, "features_extractor_class": Nearness},
        stats_window_size=1000,
        seed=seed,
        device="cpu",
    )
    return model.learn(10**9, callback=clock)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--minutes", type=float, default=10.0)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--envs", type=int, default=256)
    parser.add_argument("--episodes", type=int, default=1000)
    parser.add_argument("--out", default="point-goal.onnx")
    given = parser.parse_args()
    torch.set_num_threads(1)  # the simulation has the other core
    model = train(given.minutes, given.seed, given.envs)
    many = make_vec(TASK, given.episodes, threads=2)
    print(evaluate(many, lambda seen: model.predict(seen, deterministic=True)[0], seed=HELD_OUT))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)  # the newer exporter needs onnxscript
        example = torch.zeros(1, model.observation_space.shape[0])
        names = {"input_names": ["observation"], "output_names": ["action"]}
        torch.onnx.export(Actor(model.policy).eval(), example, given.out, dynamo=False, **names)
    print(f"wrote {given.out}")


if __name__ == "__main__":
    main()
