"""Bodies found by where they are: a uniform hash of the plane, made anew when they have moved.

The plane is cut into square cells as large as the largest body. A replica has `rows` times `cols` buckets, powers of
two, and the cell in row i and column j belongs to bucket (i mod rows, j mod cols): bodies far apart may share one,
which costs a look and changes nothing. The buckets of a row lie side by side, so those of a window of cells are a few
runs of bodies, and what is in a window is found in time that does not grow with the number of bodies elsewhere. Few
bodies have one bucket, which is to look at them all.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from amorsim.kernels.collision.footprints import rounding_slack
from amorsim.kernels.compile import kernel, part

__all__ = ["BodyHash", "hash_bodies", "pairs_within", "run_of_bodies", "window"]

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

# Beyond so many cells from the world's origin all are one.
FARTHEST = 2.0**50


class BodyHash(NamedTuple):
    """The bodies of all replicas, sorted by bucket; made by `hash_bodies`."""

    side: float
    """Of a cell [m]."""
    rows: int
    cols: int
    first: Ints
    """Bodies of bucket k, counted over the rows of all replicas, are ``first[k]:first[k + 1]``, of the sorted ones."""
    body: Ints
    """Which body a sorted one is, (T,); in order within a bucket."""
    owner: Ints
    """Whose a sorted one is, (T,): its own, or that of the body that it is a part of."""
    disc: Floats
    """Of the sorted ones, the circle that holds the body: x, y, radius [m], (T, 3)."""


@part
def _cell(place: float, side: float) -> int:
    """Row or column of the cell that holds `place` [m]; never decreases as `place` grows."""
    if place != place:
        return 0
    return math.floor(min(max(place / side, -FARTHEST), FARTHEST))


@part
def window(place: float, half: float, side: float, lines: int) -> tuple[int, int]:
    """First of `lines` rows or columns of buckets, and how many from there on, that hold all within `half` [m]."""
    half = half * (1.0 + 1e-8) + rounding_slack(abs(place) + half)
    # Whoever is out of this world, or no number, looks at all.
    if not abs(place) + half < FARTHEST * side:
        return 0, lines
    low = math.floor((place - half) / side)
    cells = math.floor((place + half) / side) - low + 1
    return (low & (lines - 1), cells) if cells < lines else (0, lines)


@part
def run_of_bodies(
    table: BodyHash, replica: int, row0: int, rows: int, col0: int, cols: int, run: int
) -> tuple[int, int]:
    """Where a run of bodies in a window of a replica's buckets begins and ends among the sorted ones.

    There are `rows` runs, and as many again where the columns pass the last one and go on from the first.
    """
    wraps = run >= rows
    row = (row0 + (run - rows if wraps else run)) & (table.rows - 1)
    base = (replica * table.rows + row) * table.cols
    left = 0 if wraps else col0
    right = max(col0 + cols - table.cols, 0) if wraps else min(col0 + cols, table.cols)
    return table.first[base + left], table.first[base + right]


@kernel
def hash_bodies(poses: Floats, reach: Floats, owner: Ints, replica_first: Ints, table: BodyHash) -> None:
    """Write `first`, `body`, `owner` and `disc` of `table` for bodies at `poses` (T, 3) that reach so far [m] (T,).

    `owner` (T,) is the body that each is a part of, or itself. Bodies of replica r are
    ``replica_first[r]:replica_first[r + 1]``, int64 (R + 1,).
    """
    first = table.first
    bucket = np.empty(reach.shape[0], dtype=np.int64)
    first[:] = 0
    for r in range(replica_first.shape[0] - 1):
        for i in range(replica_first[r], replica_first[r + 1]):
            row = _cell(poses[i, 1], table.side) & (table.rows - 1)
            col = _cell(poses[i, 0], table.side) & (table.cols - 1)
            bucket[i] = (r * table.rows + row) * table.cols + col
            first[bucket[i]] += 1
    total = 0
    for k in range(first.shape[0]):
        total += first[k]
        first[k] = total
    for i in range(reach.shape[0] - 1, -1, -1):
        first[bucket[i]] -= 1
        place = first[bucket[i]]
        table.body[place] = i
        table.owner[place] = owner[i]
        table.disc[place, 0] = poses[i, 0]
        table.disc[place, 1] = poses[i, 1]
        table.disc[place, 2] = reach[i]


@kernel
def pairs_within(table: BodyHash, replica: Ints, which: Ints, poses: Floats, radius: Floats, out: Ints) -> int:
    """How many pairs of bodies of one replica have circles that meet, in no particular order.

    Of two the wider one looks, so one that moves far makes nobody else look far; of two that are equal, the first.

    Parameters
    ----------
    table
        The bodies at `poses` (T, 3).
    replica
        Which each is of, (T,).
    which
        Those who look, (Q,).
    radius
        Of each body's circle around its pose [m], (T,).
    out
        Gets ``a * T + b`` of the pairs of bodies a < b, as far as there is room for them, int64 (P,).
    """
    count = poses.shape[0]
    found = 0
    for i in which:
        x = poses[i, 0]
        y = poses[i, 1]
        row0, rows = window(y, 2.0 * radius[i], table.side, table.rows)
        col0, cols = window(x, 2.0 * radius[i], table.side, table.cols)
        for run in range(2 * rows if col0 + cols > table.cols else rows):
            start, stop = run_of_bodies(table, replica[i], row0, rows, col0, cols, run)
            for place in range(start, stop):
                j = table.body[place]
                if radius[j] > radius[i] or (radius[j] == radius[i] and j <= i):
                    continue
                dx = x - table.disc[place, 0]
                dy = y - table.disc[place, 1]
                reach = radius[i] + radius[j]
                if dx * dx + dy * dy <= reach * reach:
                    if found < out.shape[0]:
                        out[found] = min(i, j) * count + max(i, j)
                    found += 1
    return found
