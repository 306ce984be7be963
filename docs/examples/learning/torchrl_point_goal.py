"""PPO of TorchRL learns to reach goals in the office, a million steps in some three minutes.

python -m pip install -e ".[learn]" torchrl
python docs/examples/learning/torchrl_point_goal.py
"""

import argparse
import time

import gymnasium as gym
import torch
from tensordict.nn import TensorDictModule
from tensordict.nn.distributions import NormalParamExtractor
from torch import nn
from torchrl.collectors import Collector
from torchrl.envs import GymWrapper, RewardSum, TransformedEnv
from torchrl.modules import MLP, ProbabilisticActor, TanhNormal, ValueOperator
from torchrl.objectives import ClipPPOLoss
from torchrl.objectives.value import GAE

import amorsim.learning  # makes the tasks known to Gymnasium

asked = argparse.ArgumentParser()
asked.add_argument("--rounds", type=int, default=60, help="of 16,384 steps each")
rounds = asked.parse_args().rounds

torch.manual_seed(0)
env = TransformedEnv(GymWrapper(gym.make_vec("amorsim/PointGoal-v0", num_envs=64, threads=2)), RewardSum())
observed, actions = env.observation_spec["observation"].shape[-1], env.action_spec.shape[-1]
network = nn.Sequential(
    MLP(in_features=observed, out_features=2 * actions, num_cells=[64, 64], activation_class=nn.Tanh),
    NormalParamExtractor(),
)
actor = ProbabilisticActor(
    TensorDictModule(network, in_keys=["observation"], out_keys=["loc", "scale"]),
    in_keys=["loc", "scale"],
    spec=env.action_spec_unbatched,
    distribution_class=TanhNormal,
    distribution_kwargs={"low": -1.0, "high": 1.0},
    return_log_prob=True,
)
critic = ValueOperator(MLP(in_features=observed, out_features=1, num_cells=[64, 64], activation_class=nn.Tanh))
advantage = GAE(gamma=0.99, lmbda=0.95, value_network=critic)
loss = ClipPPOLoss(actor, critic, entropy_coeff=0.001)
optimizer = torch.optim.Adam(loss.parameters(), 1e-3)

begin = time.time()
for number, data in enumerate(Collector(env, actor, frames_per_batch=16384, total_frames=16384 * rounds), start=1):
    for _ in range(8):
        advantage(data)
        flat = data.reshape(-1)
        for part in flat[torch.randperm(len(flat))].split(2048):
            losses = loss(part)
            optimizer.zero_grad()
            (losses["loss_objective"] + losses["loss_critic"] + losses["loss_entropy"]).backward()
            nn.utils.clip_grad_norm_(loss.parameters(), 0.5)
            optimizer.step()
    if number % 10 == 0:
        returns = data["next", "episode_reward"][data["next", "done"]]
        print(f"{number * 16384:9,d} steps, {time.time() - begin:4.0f} s: return {returns.mean():6.2f}")


def drive(seen):
    """The action that the policy finds best."""
    with torch.no_grad():
        best, _ = network(torch.as_tensor(seen))
    return torch.tanh(best).numpy()


print(amorsim.learning.evaluate(gym.make_vec("amorsim/PointGoal-v0", num_envs=1000, threads=2), drive, seed=1_000_000))
