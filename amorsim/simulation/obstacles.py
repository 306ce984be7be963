"""Obstacles: bodies that stand, or that move as their motions propose and as far as they are free to."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from amorsim.contracts import Context, Motion, RobotModel, State
from amorsim.core.poses import compose
from amorsim.core.rows import stack
from amorsim.scenario.spec import Obstacle
from amorsim.simulation.bodies import World
from amorsim.simulation.chain import Streams
from amorsim.simulation.moment import Moment
from amorsim.simulation.view import GroupView

__all__ = ["ObstacleGroup"]

Array = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]


class ObstacleGroup:
    """Obstacles whose motions are of one class and shape, as rows; a mover like a group of robots."""

    def __init__(
        self, obstacles: Sequence[Obstacle], bodies: Ints, replica: Ints, world: World, seed: int, dt: float
    ) -> None:
        self.obstacles = list(obstacles)
        self.bodies = bodies
        self.moment = Moment(replica, dt)
        self.view = GroupView(world, bodies, dt)
        self.streams = Streams(seed, [obstacle.name for obstacle in obstacles], self.moment.counter)
        self.draws = self.streams.draws("motion")
        self.state: State = {}
        motions = [obstacle.motion for obstacle in obstacles if obstacle.motion is not None]
        self.motion: Motion | None = stack(motions) if motions else None
        self.start()

    def start(self) -> None:
        """Put every obstacle where it starts."""
        rows = len(self.obstacles)
        self.pose = np.array([[o.pose.x, o.pose.y, o.pose.heading] for o in self.obstacles], dtype=np.float64)
        self.twist = np.zeros((rows, 3))
        self.proposed = np.zeros((rows, 3))
        if self.motion is not None:
            self.state = dict(self.motion.start(_context(rows, self.moment.dt, self.pose)))

    def actuate(self) -> None:
        """Ask the motions where the obstacles want to go."""
        if self.motion is None:
            return
        self.view.tick = self.moment.tick
        self.view.body_pose = self.pose
        self.view.mount = np.zeros_like(self.pose)
        self.view.twist = self.twist
        self.proposed = self.motion.propose(self.view, self.moment.dt, self.state, self.draws)

    def travel(self) -> Array:
        """Lengths [m] and turnings [rad] `(N, 2)` of the wanted displacements."""
        x, y, turn = self.proposed.T
        return np.stack((np.sqrt(x * x + y * y), np.abs(turn)), axis=1)

    def end_poses(self) -> Array:
        """Where they are if nothing stops them."""
        return compose(self.pose, self.proposed)

    def poses_at(self, which: Ints, fraction: Array) -> Array:
        """Where some of them are at fractions of the step: straight ahead, turning evenly."""
        return compose(self.pose[which], self.proposed[which] * fraction[:, None])

    def arrive(self, poses: Array, stop: Array) -> None:
        """Take the poses after contact."""
        self.twist = self.proposed * stop[:, None] / self.moment.dt
        self.pose = poses


def _context(rows: int, dt: float, pose: Array) -> Context:
    # An obstacle is no robot and is told nothing; a motion gets what it needs from its view.
    return Context(rows=rows, dt=dt, robot=_NOBODY, pose=pose)


_NOBODY: RobotModel = None  # type: ignore[assignment]
