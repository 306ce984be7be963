"""Which contacts go on from step to step."""

from __future__ import annotations

from collections.abc import Collection

import numpy as np
import numpy.typing as npt

from amorsim.simulation.bodies import World
from amorsim.simulation.contact import WALL

__all__ = ["PARTED", "still_near"]

Array = npt.NDArray[np.float64]

# Those farther apart than this have parted. Who slides along a wall leaves it by parts of a millimetre between two
# touches, and no wall is known better than to a cell, which is a millimetre and up.
PARTED = 1e-3  # [m]


def still_near(world: World, pairs: Collection[tuple[int, int]], poses: Array) -> frozenset[tuple[int, int]]:
    """Those of the pairs of bodies (`WALL` for a wall) that have not parted, with all bodies at `poses` `(T, 3)`."""
    near: set[tuple[int, int]] = set()
    # By the gaps that contact itself goes by: these have the same bits for any number of rows.
    walls = [pair for pair in pairs if pair[1] == WALL]
    if walls:
        a = np.array([pair[0] for pair in walls], dtype=np.int64)
        gaps, _ = world.wall_gaps(a, poses[a], np.full(len(a), 2.0 * PARTED))
        near.update(pair for pair, gap in zip(walls, gaps.tolist(), strict=True) if gap <= PARTED)
    bodies = [pair for pair in pairs if pair[1] != WALL]
    if bodies:
        a, b = np.array(bodies, dtype=np.int64).T.copy()
        gaps = world.body_gaps(a, poses[a], b, poses[b], np.full(len(a), 2.0 * PARTED))
        near.update(pair for pair, gap in zip(bodies, gaps.tolist(), strict=True) if gap <= PARTED)
    return frozenset(near)
