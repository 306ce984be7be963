"""The bodies near each row."""

from __future__ import annotations

import numpy as np

from amorsim.array_types import Array, Ints
from amorsim.contracts import Neighbours
from amorsim.kernels.behaviours.neighbours import Crowd, Looking, find_neighbours
from amorsim.kernels.collision.body_hash import hash_bodies
from amorsim.simulation.world.world import World, empty_hash

__all__ = ["neighbours_of"]


_CELLS = 4
"""Cells of the hash along the longest range: more cells cost look-ups, fewer cost tests of bodies beyond it."""


def neighbours_of(world: World, bodies: Ints, range_max: Array, ahead: Array) -> Neighbours:
    """The neighbours of rows whose bodies are `bodies` `(N,)`; see `amorsim.contracts.View.neighbours`.

    `range_max` and `ahead` are `(N,)`. The hash for contact has cells of a body's size, too many for a range of several
    metres, so this one is made for its range.
    """
    crowd = Crowd(world.poses.copy(), world.twists.copy(), world.bodies.reach, world.owner)
    farthest = float(range_max.max() + world.bodies.reach.max())
    table = empty_hash(world.count, world.replicas, farthest / _CELLS)
    hash_bodies(crowd.poses, crowd.reach, crowd.owner, world.first, table)
    rows = Looking(bodies, world.replica_index[bodies], range_max, ahead)
    first = np.empty(len(bodies) + 1, dtype=np.int64)
    body = np.empty(min(64, world.count) * len(bodies), dtype=np.int64)
    found = find_neighbours(table, crowd, world.first, rows, first, body)
    if found > len(body):
        body = np.empty(found, dtype=np.int64)
        find_neighbours(table, crowd, world.first, rows, first, body)
    return Neighbours(
        own=bodies,
        first=first,
        body=body[:found],
        poses=crowd.poses,
        twists=crowd.twists,
        reach=crowd.reach,
        is_robot=np.tile(world.is_robot, world.replicas),
        owner=crowd.owner,
    )
