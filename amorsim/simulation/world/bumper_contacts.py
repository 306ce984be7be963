"""Which zones of a robot's bumper touch something."""

from __future__ import annotations

import functools
from collections.abc import Sequence

import numpy as np

from amorsim.array_types import Array, Bools, Ints
from amorsim.core.shapes import Shape, pack
from amorsim.kernels.collision import clearance as contact_kernels
from amorsim.kernels.collision import footprints as body_kernels
from amorsim.kernels.collision.footprints import Bodies
from amorsim.simulation.world.world import World

__all__ = ["find_touched"]


def find_touched(world: World, own: Ints, zones: Sequence[Shape], which: Ints) -> Bools:
    """Whether zones on bodies `own` `(N,)` overlap a wall or another body `(N, s)`.

    `which` `(N, s)` are each row's indices into `zones`; see `amorsim.contracts.View.touches`.
    """
    touched = np.zeros(which.shape, dtype=np.bool_)
    if not touched.size:
        return touched
    packed, reach = _packed(tuple(zones), world.shapes)
    poses = np.ascontiguousarray(world.poses[own])
    # A disc around all zones first: robots in the open need one test only.
    replica = world.replica_index[own]
    near = np.flatnonzero(_meets_wall(world, packed, np.zeros(len(own), dtype=np.int64), poses, replica))
    if len(near):
        row, zone = np.repeat(near, which.shape[1]), which[near].ravel()
        touched[near] = _meets_wall(world, packed, zone + 1, poses[row], replica[row]).reshape(len(near), -1)
    if world.has_company:
        row, other = _close(world, own, reach)
        if len(row):
            pair = np.repeat(np.arange(len(row)), which.shape[1])
            meets = _meets_body(
                packed,
                which[row].ravel() + 1,
                poses[row[pair]],
                other[pair] % world.count,
                world.poses[other[pair]],
                1 + len(zones),
            ).reshape(len(row), -1)
            np.logical_or.at(touched, row, meets)
    return touched


@functools.lru_cache(maxsize=64)
def _packed(zones: tuple[Shape, ...], shapes: tuple[Shape, ...]) -> tuple[Bodies, float]:
    """A disc around all zones, the zones and the shapes of bodies, in this order; and the radius of the disc [m]."""
    reach = max(zone.reach for zone in zones)
    return pack((Shape.circle(reach), *zones, *shapes)), reach


def _meets_wall(world: World, packed: Bodies, zone: Ints, poses: Array, replica: Ints) -> Bools:
    gaps, where, cap = np.empty(len(zone)), np.empty((len(zone), 2)), np.zeros(len(zone))
    poses = np.ascontiguousarray(poses)
    for map_, rows in world.terrain.between(replica, 0, len(zone)):
        walls = map_.grid, *map_.origin, packed
        contact_kernels.map_gaps(*walls, zone[rows], poses[rows], cap[rows], gaps[rows], where[rows])
    return gaps < 0.0


def _meets_body(packed: Bodies, zone: Ints, poses: Array, other: Ints, its: Array, first: int) -> Bools:
    gaps = np.empty(len(zone))
    body_kernels.body_gaps(
        packed, zone, np.ascontiguousarray(poses), other + first, np.ascontiguousarray(its), np.zeros(len(zone)), gaps
    )
    return gaps < 0.0


def _close(world: World, own: Ints, reach: float) -> tuple[Ints, Ints]:
    """Pairs of a row and another body whose circles meet, with the rows' circles grown to `reach` [m]."""
    margin = np.zeros(len(world.poses))
    margin[own] = np.maximum(0.0, reach - world.bodies.reach[own])
    a, b = world.pairs_within(world.poses, margin)
    row_of = np.full(len(world.poses), -1, dtype=np.int64)
    row_of[own] = np.arange(len(own))
    row, other = np.concatenate((row_of[a], row_of[b])), np.concatenate((b, a))
    mine = row >= 0
    return row[mine], other[mine]
