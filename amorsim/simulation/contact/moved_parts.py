"""Parts of robots: rigid bodies in addition to a robot's own, which its drive moves (`amorsim.contracts.Drive.parts`).

The joints move a part. The drive knows the joints at every fraction of a step, so a part has a path of its own, and
the search for contact treats it like any body. If any part of a robot touches something, the whole robot stops.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import NoReturn, Protocol

import attrs
import numpy as np

from amorsim.array_types import AnyArray, Array, Ints
from amorsim.contracts import Drive
from amorsim.core.errors import AmorsimError
from amorsim.core.poses import compose, logarithm, relative
from amorsim.core.rows import take
from amorsim.kernels.collision.paths import OTHER
from amorsim.scenario.parts import at_start
from amorsim.scenario.spec import Obstacle, Robot
from amorsim.simulation.truth import has_draws, true_robot
from amorsim.simulation.world.world import World

__all__ = ["Parts", "with_parts"]


_LOOK = 1e-4  # of a step, to either side: the difference of two such positions gives a velocity


class Robots(Protocol):
    """What parts need of their robots: the locomotion of a group."""

    bodies: Ints
    dt: float
    drive: Drive
    joints: Array
    true_pose: Array

    @property
    def label(self) -> str:
        """Their name in the schedule."""

    def blame(self, error: BaseException) -> NoReturn:
        """Raise an exception as the drive's."""

    def part_travel(self) -> Array:
        """Bounds of the parts' paths: length [m] and turning [rad] `(N, p, 2)`."""

    def parts_at(self, which: Ints, fraction: Array) -> tuple[Array, Array]:
        """Poses of robots at fractions `(Q, 1)` of the step, and of their parts in their frames `(Q, p, 3)`."""


class Parts:
    """The parts of all robots of a group, which move by themselves: N rows of p parts (a `Mover` of `resolve`).

    Their poses follow from the joints, but are stored as well: so they are, to the bit, those that contact found free.
    """

    def __init__(self, robots: Robots, world: World) -> None:
        entries = world.parts_of(robots.bodies)
        self._robots = robots
        self._each = entries.shape[1]
        self.bodies: Ints = entries.reshape(-1)
        self.start()

    def start(self) -> None:
        """Put the parts at the poses that the joints give, at rest."""
        robots = self._robots
        inside = np.ascontiguousarray(robots.drive.part_poses(robots.joints)).reshape(-1, 3)
        self.poses = compose(np.repeat(robots.true_pose, self._each, axis=0), inside)
        self.twists = np.zeros_like(self.poses)

    def of_row(self, row: int, pose: Array) -> Array:
        """Poses of the parts of one robot `(p, 3)` if it stood at `pose` `(3,)`, with its joints as they are."""
        robots = self._robots
        which = np.array([row], dtype=np.intp)
        inside = take(robots.drive, which).part_poses(robots.joints[which])[0]
        return compose(np.repeat(pose[None, :], self._each, axis=0), np.ascontiguousarray(inside))

    @property
    def true_twist(self) -> Array:
        """Velocities `(N * p, 3)` over the last step in the parts' frames."""
        return self.twists

    @property
    def per_robot(self) -> Array:
        """Poses `(N, p, 3)`."""
        return self.poses.reshape(-1, self._each, 3)

    def of(self, row: int) -> Array:
        """Poses of the parts of one robot `(p, 3)`."""
        return self.poses[row * self._each : (row + 1) * self._each]

    def put(self, row: int, poses: Array) -> None:
        """Put the parts of one robot at `poses` `(p, 3)`, at rest."""
        mine = slice(row * self._each, (row + 1) * self._each)
        self.poses, self.twists = self.poses.copy(), self.twists.copy()
        self.poses[mine], self.twists[mine] = poses, 0.0

    @property
    def label(self) -> str:
        """The robots' name in the schedule, and that these are their parts."""
        return f"{self._robots.label} / parts"

    def bind_path(self, motion: Array, travel: Array) -> tuple[int, Callable[[], None]]:
        """The form of the parts' paths, which no kernel knows; `poses_at` gives their ends as well."""
        motion[:] = 0.0
        return OTHER, lambda: np.copyto(travel, self._robots.part_travel().reshape(-1, 2))

    def blame(self, error: BaseException) -> NoReturn:
        """Raise an exception as the drive's."""
        self._robots.blame(error)

    def bad_motion(self, motion: Array) -> AmorsimError:
        """Not needed: these motions are 0."""
        raise AssertionError(motion)

    def poses_at(self, which: Ints, fraction: Array) -> Array:
        """Poses `(Q, 3)` of the parts with the numbers `which` `(Q,)`, at fractions `(Q,)` of the step."""
        row, part = np.divmod(which, self._each)
        poses, inside = self._robots.parts_at(row, fraction[:, None])
        return compose(poses, np.ascontiguousarray(inside[np.arange(len(row)), part]))

    def speed_at(self, body: int, point: tuple[float, float], fraction: float) -> float:
        """Speed [m/s] of the point of a part that is at `point` in the world at a fraction of the step."""
        which = np.full(3, np.searchsorted(self.bodies, body))
        early, late = max(0.0, fraction - _LOOK), min(1.0, fraction + _LOOK)
        now, before, after = self.poses_at(which, np.array([fraction, early, late]))[:, None]
        inside = relative(now, np.array([[*point, 0.0]]))
        (dx, dy, _) = (compose(after, inside) - compose(before, inside))[0].tolist()
        return math.hypot(dx, dy) / ((late - early) * self._robots.dt)

    def bind_arrival(self, poses: Array, stop: Array) -> Callable[[], None]:
        """A function that takes the poses `(N * p, 3)` after contact."""

        def arrive() -> None:
            self.twists = logarithm(relative(self.poses, poses)) / self._robots.dt
            self.poses = poses.copy()

        return arrive

    def arrays(self) -> dict[str, AnyArray]:
        """All arrays that change."""
        return {"poses": self.poses, "twists": self.twists}


def with_parts(world: World, bodies: Sequence[Robot | Obstacle], replicas: Sequence[int], seed: int) -> Array:
    """Poses `(T, 3)` of all bodies at the start in the frames of their owners, with the true parameters."""
    inside = np.zeros((len(world.everyone), 3))
    if not world.has_parts:
        return inside
    known: dict[tuple[int, int], Array] = {}
    for index, replica in enumerate(replicas):
        for number, body in enumerate(bodies):
            if not isinstance(body, Robot) or not body.drive.parts:
                continue
            key = id(body), replica if has_draws(body) else -1
            if key not in known:
                of_drive = {path: error for path, error in body.errors.items() if path.startswith("drive.")}
                known[key] = at_start(true_robot(attrs.evolve(body, errors=of_drive), seed, replica).drive)
            first = world.first[index] + number
            inside[world.parts_of(np.array([first]))[0]] = known[key]
    return inside
