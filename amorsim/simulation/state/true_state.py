"""The true state of robots, as tasks for learners are given it."""

from __future__ import annotations

import numpy as np

from amorsim.array_types import Array, Ints
from amorsim.contracts import TrueState
from amorsim.core.errors import AmorsimError
from amorsim.core.unknown_names import no_such
from amorsim.simulation.fleet.fleet import Fleet
from amorsim.simulation.fleet.group import Group
from amorsim.simulation.state.gathering import gathered, touching_robots
from amorsim.simulation.world.world import World

__all__ = ["true_state"]


def true_state(fleet: Fleet, rows: Ints | None = None) -> TrueState:
    """The true state of all robots, or of some of them by their rows, in order of replica, then of name."""
    world, robots = fleet.world, len(fleet.names)
    pose, twist, touching = gathered(fleet, _pose_of), gathered(fleet, _twist_of), touching_robots(fleet)
    if rows is not None:
        pose, twist, touching = pose[rows], twist[rows], touching[rows]
    rows = np.arange(len(fleet.replicas) * robots) if rows is None else rows
    if world.has_parts:
        part_pose = world.poses[world.parts_of(world.first[rows // robots] + rows % robots)]
    else:
        part_pose = np.empty((len(rows), 0, 3))
    markings = fleet.scenario.floor.markings
    return TrueState(
        pose=pose,
        twist=twist,
        is_touching=touching,
        map_of=lambda row: world.terrain.at(int(rows[row]) // robots),
        pose_of=lambda name: _poses_of(world, name, rows // robots),
        part_pose=part_pose,
        lines=tuple(mark.patch.points for mark in markings if mark.points) if markings else (),
    )


def _pose_of(group: Group) -> Array:
    return group.true_pose


def _twist_of(group: Group) -> Array:
    return group.true_twist


def _poses_of(world: World, name: str, replica: Ints) -> Array:
    """The poses `(N, 3)` of a robot or an obstacle in the replicas of these indices."""
    names = world.names[: world.named]
    if name not in names:
        raise AmorsimError(no_such("robot or obstacle", name, names))
    found: Array = world.poses[world.first[replica] + names.index(name)]
    return found
