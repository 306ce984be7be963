"""The end of contacts: which contacts continue from step to step."""

from __future__ import annotations

import numpy as np

from amorsim.array_types import Array
from amorsim.simulation.contact.resolve import WALL
from amorsim.simulation.world.world import World

__all__ = ["PARTED", "still_near"]


# Bodies farther apart than this have parted. A body that slides along a wall leaves it by fractions of a millimetre
# between two touches, and walls are only known to a cell, at least 1 mm.
PARTED = 1e-3  # [m]


def still_near(world: World, pairs: frozenset[tuple[int, int]], before: Array) -> frozenset[tuple[int, int]]:
    """The pairs of bodies (`WALL` for a wall) that have not parted.

    At the poses `before` `(T, 3)` they had not parted; all bodies have since moved to their poses in the world.
    """
    poses = world.poses
    if not pairs:
        return pairs
    gone = (poses != before).any(axis=1)
    moved = [pair for pair in pairs if gone[pair[0]] or (pair[1] != WALL and gone[pair[1]])]
    if not moved:
        return pairs
    near = set(pairs.difference(moved))
    # Contact uses the same gaps; their bits do not depend on the number of rows.
    walls = [pair for pair in moved if pair[1] == WALL]
    if walls:
        a = np.array([pair[0] for pair in walls], dtype=np.int64)
        gaps, _ = world.wall_gaps(a, poses[a], np.full(len(a), 2.0 * PARTED))
        near.update(pair for pair, gap in zip(walls, gaps.tolist(), strict=True) if gap <= PARTED)
    bodies = [pair for pair in moved if pair[1] != WALL]
    if bodies:
        a, b = np.array(bodies, dtype=np.int64).T.copy()
        gaps = world.body_gaps(a, poses[a], b, poses[b], np.full(len(a), 2.0 * PARTED))
        near.update(pair for pair, gap in zip(bodies, gaps.tolist(), strict=True) if gap <= PARTED)
    return frozenset(near)
