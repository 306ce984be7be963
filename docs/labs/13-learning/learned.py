"""Lab 13: cross a field of cylinders by a policy that learns to. Fill in `observe`, then learn: python learned.py"""

import argparse
import functools
import math
import time
from pathlib import Path

import numpy as np

import amorsim as am

# Answers to the handout's questions, by their numbers: numbers, or words in quotes.
ANSWERS = {1: None, 2: None, 3: None}

HERE = Path(__file__).parent
GOAL = (2.25, 8.5)  # [m] in the world
SPEED, TURN_RATE = 0.4, 1.0  # [m/s] and [rad/s] of the actions 1, as in train.toml
LONGEST, FARTHEST = 8.0, 22.5  # [m] range of the laser, and the distance of the goal that is observed at most
SIZE = 5 + 181


def observe(readings, estimate, last):
    """What the policy sees: SIZE numbers, in the order and the units of where it learned; `last` is its last action."""
    return np.zeros(SIZE)  # step 2 of the handout goes here


class Drive:
    """Drives by the policy, ten times a second; until there is one, to the goal and straight on."""

    def __init__(self):
        self.last = np.zeros(2)

    def command(self, readings, estimate, clock):
        x, y, heading = estimate.pose
        if math.hypot(GOAL[0] - x, GOAL[1] - y) < 0.2:
            return am.Twist(0.0, 0.0)
        if not (HERE / "policy.onnx").exists():
            off = math.remainder(math.atan2(GOAL[1] - y, GOAL[0] - x) - heading, 2.0 * math.pi)
            return am.Twist(SPEED if abs(off) < 0.5 else 0.0, off)
        self.last = policy()(observe(readings, estimate, self.last))
        return am.Twist(SPEED * self.last[0], TURN_RATE * self.last[1])


@functools.cache
def policy():
    """What was learned: a function from observations to actions, from -1 to 1."""
    import onnxruntime

    options = onnxruntime.SessionOptions()
    options.intra_op_num_threads = 1
    session = onnxruntime.InferenceSession(str(HERE / "policy.onnx"), options, providers=["CPUExecutionProvider"])

    def act(seen):
        (actions,) = session.run(None, {"observation": np.asarray(seen, np.float32)[None]})
        return np.clip(actions[0].astype(float), -1.0, 1.0)

    return act


def learn(minutes, seed, envs, **rewards):
    """Learn by PPO in many environments at once, and write policy.onnx; `rewards` are of the task in train.toml."""
    import torch
    from stable_baselines3 import PPO
    from stable_baselines3.common.callbacks import BaseCallback
    from stable_baselines3.common.torch_layers import BaseFeaturesExtractor

    from amorsim.learning import make_vec
    from amorsim.learning.stable_baselines import StableBaselinesVecEnv

    class Clock(BaseCallback):
        """Ends learning when the time is up, and prints how it goes."""

        begin, shown = time.monotonic(), 0.0

        def left(self):
            return 1.0 - (time.monotonic() - self.begin) / (60.0 * minutes)

        def _on_step(self):
            return self.left() > 0.0

        def _on_rollout_end(self):
            spent = time.monotonic() - self.begin
            if spent - self.shown >= 10.0:
                self.shown, reached = spent, np.mean(self.model.ep_success_buffer)
                print(f"{spent:4.0f} s, {self.num_timesteps:8d} steps: {reached:.1%} reached the goal", flush=True)

    class Nearness(BaseFeaturesExtractor):
        """Ranges as nearness, 1 at a wall and 0 far from it: a decimetre matters near a wall, and not across a room."""

        def __init__(self, space):
            super().__init__(space, space.shape[0])

        def forward(self, seen):
            goal, ranges = seen[:, :5], seen[:, 5:]
            return torch.cat((0.25 * goal[:, :1], goal[:, 1:], torch.exp(-LONGEST * ranges / 0.7)), dim=1)

    class Actor(torch.nn.Module):
        """The mean of the policy's actions: what it does once it no longer explores."""

        def __init__(self, learner):
            super().__init__()
            self.learner = learner

        def forward(self, seen):
            hidden = self.learner.mlp_extractor.forward_actor(self.learner.pi_features_extractor(seen))
            return torch.clamp(self.learner.action_net(hidden), -1.0, 1.0)

    torch.set_num_threads(1)  # the simulation has the other core
    clock = Clock()
    worlds = make_vec(HERE / "train.toml", envs, autoreset_mode="SameStep", threads=2, **rewards)
    kind = {"net_arch": [64, 64], "log_std_init": -0.5, "features_extractor_class": Nearness}
    rate = {"learning_rate": lambda _: max(1e-4, 4e-4 * clock.left()), "policy_kwargs": kind}
    sizes = {"n_steps": 64, "batch_size": 4096, "n_epochs": 6, "stats_window_size": 1000}
    model = PPO("MlpPolicy", StableBaselinesVecEnv(worlds), seed=seed, device="cpu", **rate, **sizes)
    model.learn(10**9, callback=clock)
    names = {"input_names": ["observation"], "output_names": ["action"]}
    file = HERE / "policy.onnx"
    torch.onnx.export(Actor(model.policy).eval(), torch.zeros(1, SIZE), str(file), dynamo=False, **names)
    print(f"wrote {file.name}")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description="Learn to cross fields of cylinders, and write policy.onnx.")
    parser.add_argument("--minutes", type=float, default=4.0)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--envs", type=int, default=256)
    parser.add_argument("--collision", type=float, default=-10.0, help="reward for touching something")
    asked = parser.parse_args()
    learn(asked.minutes, asked.seed, asked.envs, collision_reward=asked.collision)
