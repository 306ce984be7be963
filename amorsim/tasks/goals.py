"""Goals that a robot can drive to: drawn among free places, by the length of the way there."""

from __future__ import annotations

import functools
import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from amorsim.array_types import Array, Bools
from amorsim.core.maps.free_places import free_places
from amorsim.core.maps.map import Map
from amorsim.kernels.search.field import new_wave, spread

__all__ = ["goal_within"]


class _Lattice(NamedTuple):
    """The squares of a world through which a way may lead and those for a goal, with a border of neither."""

    ways: Bools  # (rows, cols)
    goals: Bools  # (rows, cols)
    side: float  # of a square [m]


def goal_within(
    world: Map,
    start: Array,
    near: float,
    far: float,
    uniform: float,
    *,
    clearance: float,
    way_clearance: float,
) -> tuple[float, float]:
    """A place [m] whose way from `start` (x, y) is `near` to `far` [m] long; `uniform` from 0 to 1 chooses it.

    Goals are at least `clearance` [m] from walls, ways `way_clearance`; ways lead over eight neighbours of squares. If
    no goal is that far, it is the one whose way is nearest to that.
    """
    lattice = _lattice(world, clearance, way_clearance)
    reach = math.ceil(far / lattice.side) + 2
    row, col = (
        min(max(int(number), 0), most - 1)
        for number, most in zip(_square_at(world, lattice.side, start), lattice.ways.shape, strict=True)
    )
    if not lattice.ways[row, col]:
        rows, cols = np.nonzero(lattice.ways)
        nearest = int(np.argmin((rows - row) ** 2 + (cols - col) ** 2))
        row, col = int(rows[nearest]), int(cols[nearest])
    # What is farther away along an axis is farther by any way.
    top, left = max(row - reach, 0), max(col - reach, 0)
    ways = lattice.ways[top : row + reach + 1, left : col + reach + 1].copy()
    ways[[0, -1]] = ways[:, [0, -1]] = False
    goals = lattice.goals[top : row + reach + 1, left : col + reach + 1]
    width = ways.shape[1]
    wave = new_wave(ways.reshape(-1).astype(np.uint8), (row - top) * width + col - left)
    spread(wave, width, ways.size)
    lengths = np.where(goals.reshape(-1), wave.to_go, np.inf) * lattice.side
    outside = np.maximum(np.maximum(near - lengths, lengths - far), 0.0)
    best = np.flatnonzero(outside == outside.min())
    chosen = int(best[min(int(uniform * len(best)), len(best) - 1)])
    return _middle(world, lattice.side, top + chosen // width, left + chosen % width)


@functools.lru_cache(maxsize=2048)  # 0.1 MB each; environments may have worlds of their own
def _lattice(world: Map, clearance: float, way_clearance: float) -> _Lattice:
    ways, side = free_places(world, way_clearance)
    goals, _ = free_places(world, clearance)
    width, height = world.size
    shape = math.ceil(height / side) + 2, math.ceil(width / side) + 2
    found = []
    for places in (ways, goals):
        mask = np.zeros(shape, dtype=bool)
        mask[_square_at(world, side, places)] = True
        found.append(mask)
    return _Lattice(found[0] | found[1], found[1], side)


def _square_at(world: Map, side: float, places: Array) -> tuple[npt.NDArray[np.intp], npt.NDArray[np.intp]]:
    """Row and column of the squares in which places `(..., 2)` are."""
    x, y, yaw = world.origin
    across, up = places[..., 0] - x, places[..., 1] - y
    c, s = math.cos(yaw), math.sin(yaw)
    cols = np.floor((across * c + up * s) / side).astype(np.intp) + 1
    return np.floor((up * c - across * s) / side).astype(np.intp) + 1, cols


def _middle(world: Map, side: float, row: int, col: int) -> tuple[float, float]:
    x, y, yaw = world.origin
    across, up = (col - 0.5) * side, (row - 0.5) * side
    c, s = math.cos(yaw), math.sin(yaw)
    return x + across * c - up * s, y + across * s + up * c
