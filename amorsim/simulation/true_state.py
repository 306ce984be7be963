"""The true state of robots, as tasks for learners are given it."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import numpy.typing as npt

from amorsim.contracts import TrueState
from amorsim.core.errors import AmorsimError
from amorsim.core.unknown_names import no_such
from amorsim.simulation.fleet import Fleet
from amorsim.simulation.gathering import gathered, touching_robots

__all__ = ["true_state"]

Array = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]

_ALL = slice(None)


def true_state(fleet: Fleet, rows: Ints | slice = _ALL) -> TrueState:
    """The true state of some robots, by their rows in order of replica, then of name."""
    world, robots = fleet.world, len(fleet.names)
    number = np.arange(len(fleet.replicas) * robots)[rows]
    replica = number // robots
    if world.has_parts:
        part_pose = world.poses[world.parts_of(world.first[replica] + number % robots)]
    else:
        part_pose = np.empty((len(number), 0, 3))
    markings = fleet.scenario.floor.markings
    return TrueState(
        pose=gathered(fleet, lambda group: group.true_pose)[number],
        twist=gathered(fleet, lambda group: group.true_twist)[number],
        is_touching=touching_robots(fleet)[number],
        map_of=lambda row: world.terrain.at(int(replica[row])),
        pose_of=_poses_in(fleet, replica),
        part_pose=part_pose,
        lines=tuple(mark.patch.points for mark in markings if mark.points) if markings else (),
    )


def _poses_in(fleet: Fleet, replica: Ints) -> Callable[[str], Array]:
    world = fleet.world
    names = world.names[: world.named]

    def pose_of(name: str) -> Array:
        if name not in names:
            raise AmorsimError(no_such("robot or obstacle", name, names))
        found: Array = world.poses[world.first[replica] + names.index(name)]
        return found

    return pose_of
