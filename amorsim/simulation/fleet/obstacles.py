"""Obstacles: bodies that stand still, or move as their motions propose until they touch something."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, NoReturn

import numpy as np

from amorsim.array_types import AnyArray, Array, Ints
from amorsim.contracts import Context, Motion, ObstacleFrame, State
from amorsim.core.error_text import RAISED
from amorsim.core.errors import AmorsimError
from amorsim.core.poses import compose
from amorsim.core.rows import stack
from amorsim.kernels.collision.paths import LINE
from amorsim.kernels.text import digest
from amorsim.scenario.spec import Obstacle
from amorsim.simulation.error_context import ErrorContext, array_problem
from amorsim.simulation.row_clock import RowClock
from amorsim.simulation.sensing.noise_chain import Streams
from amorsim.simulation.world.sensor_view import GroupView
from amorsim.simulation.world.world import World

__all__ = ["ObstacleGroup"]


class ObstacleGroup:
    """Obstacles whose motions are of one class and shape, as rows. They are moved like a group of robots."""

    def __init__(
        self, obstacles: Sequence[Obstacle], bodies: Ints, replica: Ints, world: World, seed: int, dt: float
    ) -> None:
        self.obstacles = list(obstacles)
        self.names = [obstacle.name for obstacle in obstacles]
        self.specified = self.obstacles
        self._given_start = np.array([[o.pose.x, o.pose.y, o.pose.heading] for o in obstacles], dtype=np.float64)
        self.drawn_start = np.full((len(obstacles), 3), np.nan)  # of a later episode, where starts are random
        self.bodies = bodies
        self.row_clock = RowClock(replica, dt)
        self.whose = ErrorContext("obstacle", self.names, self.row_clock)
        self.view = GroupView(world, bodies, dt)
        self.streams = Streams(seed, self.names, self.row_clock.counter, world.workers)
        self.draws = self.streams.draws("motion")
        self.state: State = {}
        motions = [obstacle.motion for obstacle in obstacles if obstacle.motion is not None]
        self.motion: Motion | None = stack(motions) if motions else None
        self.start()

    @property
    def label(self) -> str:
        """The obstacles, as the schedule names them."""
        names = sorted(set(self.names))
        others = f" and {len(names) - 1} more" if len(names) > 1 else ""
        return f"{names[0]}{others}" + (f" x {len(self.names)}" if len(self.names) > 1 else "")

    def start(self) -> None:
        """Put every obstacle at its start."""
        rows = len(self.obstacles)
        self.true_pose = np.where(np.isnan(self.drawn_start), self._given_start, self.drawn_start)
        self.true_twist = np.zeros((rows, 3))
        self.free = np.ones((rows, 1))
        self.proposed = np.zeros((rows, 3))  # displacements
        self.fingerprint = np.zeros((rows, 2), dtype=np.uint64)
        if self.motion is not None:
            no_robot: Any = None  # an obstacle has no robot model
            pose = self.true_pose.copy()
            context = Context(rows=rows, dt=self.row_clock.dt, pose=pose, robot=no_robot, names=self.names)
            try:
                self.state = dict(self.motion.start(context))
            except RAISED as error:
                self.whose.blame_start("motion", self.motion, error)

    def actuate(self) -> None:
        """Get the displacements that the motions propose."""
        if self.motion is None:
            return
        self.view.tick = self.row_clock.tick.copy()
        self.view.body_pose = self.true_pose.copy()  # a motion may write into what it gets
        self.view.use(np.zeros_like(self.true_pose))
        self.view.twist = self.true_twist.copy()
        self.view.free = self.free.copy()
        try:
            proposed = self.motion.propose(self.view, self.row_clock.dt, self.state, self.draws)
        except RAISED as error:
            self.whose.blame("motion", self.motion, error)
        if problem := array_problem(proposed, "displacements", self.true_pose.shape):
            raise self.whose.wrong("motion", self.motion, problem)
        self.proposed = proposed

    def travel(self) -> Array:
        """Lengths [m] and turnings [rad] `(N, 2)` of the wanted displacements."""
        x, y, turn = self.proposed.T
        return np.stack((np.sqrt(x * x + y * y), np.abs(turn)), axis=1)

    def bind_path(self, motion: Array, travel: Array) -> tuple[int, Callable[[], None]]:
        """The form of the paths, and a function for the wanted displacements: straight lines, turning evenly."""
        return LINE, lambda: np.copyto(motion, self.proposed)

    def blame(self, error: BaseException) -> NoReturn:
        """Raise the motion's exception as `ErrorContext.blame` does."""
        self.whose.blame("motion", self.motion, error)

    def bad_motion(self, motion: Array) -> AmorsimError:
        """The error for displacements that are not all finite."""
        return self.whose.not_finite("motion", self.motion, "the displacement", motion)

    def poses_at(self, which: Ints, fraction: Array) -> Array:
        """Poses of some of them at fractions of the step: on a straight line, turning evenly."""
        return compose(self.true_pose[which], self.proposed[which] * fraction[:, None])

    def bind_arrival(self, poses: Array, stop: Array) -> Callable[[], None]:
        """A function that takes the poses after contact."""

        def arrive() -> None:
            # An obstacle that did not want to move was not blocked, even if a body ran into it.
            wanted = (self.proposed != 0.0).any(axis=1)
            self.free = np.where(wanted, stop, 1.0)[:, None]
            self.true_twist = self.proposed * stop[:, None] / self.row_clock.dt
            self.true_pose = poses.copy()

        return arrive

    def record(self) -> None:
        """Mix the step's exact results into the fingerprint of each row."""
        digest.absorb([self.true_pose], self.fingerprint)

    def frame(self) -> ObstacleFrame:
        """The step for recorders."""
        return ObstacleFrame(
            names=self.names,
            replica=self.row_clock.replica,
            tick=self.row_clock.tick.flatten(),
            time=self.row_clock.time.flatten(),
            true_pose=self.true_pose.copy(),
            true_twist=self.true_twist.copy(),
            moves=self.motion is not None,
        )

    def arrays(self) -> dict[str, dict[str, AnyArray]]:
        """The engine's own arrays that change."""
        return {
            "body": {name: getattr(self, name) for name in ("true_pose", "true_twist", "free", "fingerprint")},
        }

    def states(self) -> Mapping[str, State]:
        """The state of the motion; the dict itself, not a copy."""
        return {"motion": self.state}
