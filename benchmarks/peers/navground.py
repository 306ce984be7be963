"""navground (C++): agents as discs, walls as segments, a scan for each agent that asks for one."""

from __future__ import annotations

import importlib
from typing import Any

import numpy as np
import numpy.typing as npt

from benchmarks.peers.base import Peer
from benchmarks.task import BEAMS, DT, FOV, RADIUS, RANGE_MAX, RANGE_STD, Task

__all__ = ["Navground"]

Array = npt.NDArray[np.float64]


class Navground(Peer):
    """Agents with a behaviour of ours that gives the twist of the step, and whose state asks for the lidar."""

    name = "navground"
    distribution = "navground"
    computes = (
        "moves discs (unicycle), keeps them apart and out of walls, and scans 181 beams against segments and discs "
        "with white noise; no sonars, encoder, compass or gyro; commands replayed"
    )
    lag = 1

    @classmethod
    def prepare(cls) -> None:
        """Import it."""
        importlib.import_module("navground.sim")

    def __init__(self, task: Task) -> None:
        self._core: Any = importlib.import_module("navground.core")
        sim: Any = importlib.import_module("navground.sim")
        self._task = task
        self._world = sim.World()
        for x0, y0, x1, y1 in task.world.walls.tolist():
            self._world.add_wall(self._core.LineSegment((x0, y0), (x1, y1)))
        behaviour = _replaying(self._core)
        self._behaviours = []
        self._lidars = []
        self._agents = []
        for _ in range(task.rows):
            kinematics = self._core.kinematics.TwoWheelsDifferentialDriveKinematics(max_speed=3.0, wheel_axis=0.33)
            lidar = sim.state_estimations.LidarStateEstimation(
                range=RANGE_MAX,
                start_angle=-FOV / 2.0,
                field_of_view=FOV,
                resolution=BEAMS,
                error_std_dev=RANGE_STD,
            )
            moves = behaviour(kinematics, RADIUS)
            agent = sim.Agent(
                radius=RADIUS, behavior=moves, kinematics=kinematics, state_estimations=[lidar], control_period=0.0
            )
            self._world.add_agent(agent)
            self._behaviours.append(moves)
            self._lidars.append(lidar)
            self._agents.append(agent)
        self.reset()

    def reset(self) -> None:
        """Put the agents back."""
        for agent, (x, y, heading) in zip(self._agents, self._task.starts.tolist(), strict=True):
            agent.pose = self._core.Pose2((x, y), heading)

    def step(self, index: int) -> None:
        """Hand out the twists, and update the world."""
        core = self._core
        for behaviour, (v, w) in zip(self._behaviours, self._task.twists[index].tolist(), strict=True):
            behaviour.command = core.Twist2((v, 0.0), w, core.Frame.relative)
        self._world.update(DT)

    def ranges(self) -> Array:
        """What the agents' states hold."""
        pairs = zip(self._lidars, self._behaviours, strict=True)
        return np.array([lidar.read_ranges(behaviour.sensed) for lidar, behaviour in pairs])

    def poses(self) -> Array:
        """Of the agents."""
        return np.array([(*agent.pose.position, agent.pose.orientation) for agent in self._agents], dtype=np.float64)


def _replaying(core: Any) -> Any:
    """The class of behaviours that pass on given commands and have a state for the lidar's scan."""

    class Replaying(core.Behavior, name="AmorsimBenchmark"):  # type: ignore[misc, call-arg]
        def __init__(self, kinematics: Any = None, radius: float = 0.0) -> None:
            super().__init__(kinematics, radius)
            # navground senses for nobody whose behaviour has no such state.
            self.sensed = core.SensingState()
            self.command = core.Twist2((0.0, 0.0), 0.0, core.Frame.relative)

        def get_environment_state(self) -> Any:
            return self.sensed

        def compute_cmd_internal(self, time_step: float) -> Any:
            return self.command

    return Replaying
