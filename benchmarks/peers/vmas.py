"""VMAS (PyTorch): one robot in each of N separate worlds, all stepped as one batch, on the processor."""

from __future__ import annotations

import importlib
import warnings
from typing import Any

import numpy as np
import numpy.typing as npt

from benchmarks.peers.base import Peer
from benchmarks.task import BEAMS, DT, FOV, RADIUS, RANGE_MAX, Task

__all__ = ["Vmas"]

Array = npt.NDArray[np.float64]


class Vmas(Peer):
    """Spheres whose velocities are set before each step; walls are VMAS's lines."""

    name = "VMAS"
    distribution = "vmas"
    computes = (
        "moves spheres (velocity set, no drag) in separate worlds, pushes them out of walls, and scans 181 beams "
        "against lines in float32, without noise; no sonars, encoder, compass or gyro; commands replayed"
    )
    separate_worlds = True
    in_bitmaps = False  # every beam is tried against every line, which 1,300 lines make no contest

    @classmethod
    def prepare(cls) -> None:
        """Import it and PyTorch."""
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            importlib.import_module("vmas")

    def __init__(self, task: Task) -> None:
        self._torch: Any = importlib.import_module("torch")
        self._torch.set_num_threads(1)
        vmas: Any = importlib.import_module("vmas")
        self._task = task
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            self._env = vmas.make_env(
                scenario=_scenario(task, self._torch),
                num_envs=task.rows,
                device="cpu",
                continuous_actions=True,
                seed=0,
            )
        self._agent = self._env.agents[0]
        self._scan: Any = None
        self._still = self._torch.zeros(task.rows, 2)
        self.reset()

    def reset(self) -> None:
        """Reset all worlds."""
        self._env.reset()
        starts = self._torch.tensor(self._task.starts, dtype=self._torch.float32)
        self._agent.set_pos(starts[:, :2], batch_index=None)
        self._agent.set_rot(starts[:, 2:], batch_index=None)

    def step(self, index: int) -> None:
        """Set the velocities of the step's twists, and step all worlds."""
        torch = self._torch
        twists = torch.tensor(self._task.twists[index], dtype=torch.float32)
        heading = self._agent.state.rot
        self._agent.set_vel(twists[:, :1] * torch.cat([heading.cos(), heading.sin()], dim=1), batch_index=None)
        self._agent.set_ang_vel(twists[:, 1:], batch_index=None)
        self._scan = self._env.step([self._still])[0][0]

    def ranges(self) -> Array:
        """The last observations."""
        return np.array(self._scan.numpy(), dtype=np.float64)

    def poses(self) -> Array:
        """Of the agent in each world."""
        state = self._agent.state
        return np.array(self._torch.cat([state.pos, state.rot], dim=1).numpy(), dtype=np.float64)


def _scenario(task: Task, torch: Any) -> Any:
    core: Any = importlib.import_module("vmas.simulator.core")
    sensors: Any = importlib.import_module("vmas.simulator.sensors")
    base: Any = importlib.import_module("vmas.simulator.scenario")

    class Replay(base.BaseScenario):  # type: ignore[misc]
        def make_world(self, batch_dim: int, device: Any, **kwargs: Any) -> Any:
            world = core.World(batch_dim, device, dt=DT, drag=0.0)
            lidar = sensors.Lidar(
                world, angle_start=-FOV / 2.0, angle_end=FOV / 2.0, n_rays=BEAMS, max_range=RANGE_MAX, render=False
            )
            agent = core.Agent(name="robot", shape=core.Sphere(RADIUS), sensors=[lidar], collide=True)
            world.add_agent(agent)
            for number, (x0, y0, x1, y1) in enumerate(task.world.walls.tolist()):
                length = float(np.hypot(x1 - x0, y1 - y0))
                world.add_landmark(core.Landmark(name=f"wall{number}", shape=core.Line(length=length), collide=True))
            return world

        def reset_world_at(self, env_index: int | None = None) -> None:
            for wall, (x0, y0, x1, y1) in zip(self.world.landmarks, task.world.walls.tolist(), strict=True):
                middle = torch.tensor([(x0 + x1) / 2.0, (y0 + y1) / 2.0], dtype=torch.float32)
                turn = torch.tensor([float(np.arctan2(y1 - y0, x1 - x0))], dtype=torch.float32)
                wall.set_pos(middle, batch_index=env_index)
                wall.set_rot(turn, batch_index=env_index)

        def observation(self, agent: Any) -> Any:
            return agent.sensors[0].measure()

        def reward(self, agent: Any) -> Any:
            return torch.zeros(self.world.batch_dim)

    return Replay()
