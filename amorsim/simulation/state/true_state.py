"""The true state of robots, as tasks for learners are given it."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import numpy.typing as npt

from amorsim.contracts import TrueState
from amorsim.core.errors import AmorsimError
from amorsim.core.unknown_names import no_such
from amorsim.simulation.fleet.fleet import Fleet
from amorsim.simulation.fleet.group import Group
from amorsim.simulation.state.gathering import gathered, touching_robots

__all__ = ["true_state"]

Array = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]


def true_state(fleet: Fleet, rows: Ints | None = None) -> TrueState:
    """The true state of all robots, or of some of them by their rows, in order of replica, then of name."""
    world, robots, replica = fleet.world, len(fleet.names), np.arange(len(fleet.replicas)).repeat(len(fleet.names))
    number = np.arange(len(replica)) if rows is None else rows
    replica = replica if rows is None else replica[rows]
    if world.has_parts:
        part_pose = world.poses[world.parts_of(world.first[replica] + number % robots)]
    else:
        part_pose = np.empty((len(number), 0, 3))
    pose, twist = gathered(fleet, _pose_of), gathered(fleet, _twist_of)
    touching = touching_robots(fleet)
    markings = fleet.scenario.floor.markings
    return TrueState(
        pose=pose if rows is None else pose[rows],
        twist=twist if rows is None else twist[rows],
        is_touching=touching if rows is None else touching[rows],
        map_of=lambda row: world.terrain.at(int(replica[row])),
        pose_of=_poses_in(fleet, replica),
        part_pose=part_pose,
        lines=tuple(mark.patch.points for mark in markings if mark.points) if markings else (),
    )


def _pose_of(group: Group) -> Array:
    return group.true_pose


def _twist_of(group: Group) -> Array:
    return group.true_twist


def _poses_in(fleet: Fleet, replica: Ints) -> Callable[[str], Array]:
    world = fleet.world

    def pose_of(name: str) -> Array:
        names = world.names[: world.named]
        if name not in names:
            raise AmorsimError(no_such("robot or obstacle", name, names))
        found: Array = world.poses[world.first[replica] + names.index(name)]
        return found

    return pose_of
