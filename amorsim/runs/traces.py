"""What a run keeps in memory of where the first replica's robots went, for its picture and its summary."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from amorsim.core.poses import compose
from amorsim.render.picture import RobotPath
from amorsim.simulation.simulation import Simulation

__all__ = ["Traces"]

Array = npt.NDArray[np.float64]

LARGEST = 2_000_000  # points kept, over all robots
FEWEST = 1000  # of each robot, however many there are


class Traces:
    """The paths of the first replica's robots; of very long ones every second, fourth ... point is kept.

    Attributes
    ----------
    distance
        That each robot has driven [m] `(M,)`, of every step.
    """

    def __init__(self, simulation: Simulation) -> None:
        self._simulation = simulation
        self._count = len(simulation.names)
        self._most = max(FEWEST, LARGEST // (2 * self._count))
        self._every = 1
        self._seen = 0
        self._kept: list[Array] = []  # (M, 4) each: true x and y, estimated x and y [m]
        self.distance = np.zeros(self._count)
        self._last = self._now()
        self._kept.append(self._last)

    def _now(self) -> Array:
        count = self._count
        return np.concatenate(
            (self._simulation.true_pose[:count, :2], self._simulation.estimated_pose[:count, :2]), axis=1
        )

    def keep(self) -> None:
        """Take the present step."""
        now = self._now()
        # Of the velocity, not of the places: somebody may have put the robot elsewhere.
        twist = self._simulation._gather(lambda group: group.true_twist)[: self._count]
        self.distance += np.hypot(twist[:, 0], twist[:, 1]) * self._simulation.dt
        self._last = now
        self._seen += 1
        if self._seen % self._every == 0:
            self._kept.append(now)
        if len(self._kept) > self._most:
            self._kept = self._kept[::2]
            self._every *= 2

    def errors(self) -> Array:
        """How far true and estimated positions are apart at the end [m] `(M,)`."""
        return np.hypot(self._last[:, 0] - self._last[:, 2], self._last[:, 1] - self._last[:, 3])

    def collisions(self, name: str) -> Array:
        """Where a robot of the first replica met something [m] `(K, 2)`."""
        first = self._simulation.replicas[0]
        points = [
            event.point
            for event in self._simulation.events
            if event.kind == "collision" and event.name == name and event.replica == first and event.point
        ]
        return np.array(points, dtype=np.float64).reshape(-1, 2)

    def paths(self) -> list[RobotPath]:
        """The paths as pictures want them, in order of the robots' names."""
        points = np.array([*self._kept, self._last])
        shapes = {robot.name: robot.shape for robot in self._simulation.scenario.robots}
        found = []
        for i, name in enumerate(self._simulation.names):
            outline = shapes[name].outline
            corners = np.column_stack((outline, np.zeros(len(outline))))
            pose = np.repeat(self._simulation.true_pose[i : i + 1], len(corners), axis=0)
            found.append(
                RobotPath(
                    name=name,
                    true=points[:, i, :2],
                    estimated=points[:, i, 2:],
                    outline=compose(pose, corners)[:, :2],
                    collisions=self.collisions(name),
                )
            )
        return found
