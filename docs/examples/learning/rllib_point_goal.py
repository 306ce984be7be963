"""PPO of RLlib learns to reach goals in the office, a million steps in some six minutes.

python -m pip install -e ".[learn]" "ray[rllib]" torch
python docs/examples/learning/rllib_point_goal.py
"""

import argparse
import time

import gymnasium as gym
import torch
from ray.rllib.algorithms.ppo import PPOConfig

from amorsim.learning import evaluate

asked = argparse.ArgumentParser()
asked.add_argument("--rounds", type=int, default=60, help="of 16,384 steps each")
rounds = asked.parse_args().rounds

config = (
    PPOConfig()
    # Its workers import the package before the colon. One simulation then makes all environments of a worker.
    .environment("amorsim.learning:amorsim/PointGoal-v0")
    .env_runners(num_env_runners=0, num_envs_per_env_runner=64, gym_env_vectorize_mode="vector_entry_point")
    .training(train_batch_size_per_learner=16384, minibatch_size=2048, num_epochs=8, lr=1e-3, gamma=0.99)
    .debugging(seed=0)
)
learner = config.build_algo()
begin = time.time()
for number in range(1, rounds + 1):
    found = learner.train()["env_runners"]
    if number % 10 == 0:
        steps, mean = found["num_env_steps_sampled_lifetime"], found["episode_return_mean"]
        print(f"{steps:9,.0f} steps, {time.time() - begin:4.0f} s: return {mean:6.2f}", flush=True)

policy = learner.get_module()


def drive(seen):
    """The action that the policy finds best."""
    with torch.no_grad():
        best = policy.forward_inference({"obs": torch.as_tensor(seen)})["action_dist_inputs"][:, :2]
    return best.clamp(-1.0, 1.0).numpy()


print(evaluate(gym.make_vec("amorsim/PointGoal-v0", num_envs=1000, threads=2), drive, seed=1_000_000))
