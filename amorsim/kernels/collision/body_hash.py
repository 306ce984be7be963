"""A spatial hash: finds bodies by their place.

The plane is cut into square cells as large as the largest body. A replica has `rows` times `cols` buckets, powers of
two, and the cell in row i and column j belongs to bucket (i mod rows, j mod cols). Bodies far apart may share a bucket;
that costs a comparison and changes no result. The buckets of a row lie side by side, so a window of cells is a few runs
of bodies, and the time to search it does not grow with the number of bodies elsewhere. A few bodies share one bucket:
then all are compared.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from amorsim.array_types import Array, Bools, Ints
from amorsim.kernels.collision.footprints import rounding_slack
from amorsim.kernels.compile import kernel, part

__all__ = ["BodyHash", "hash_bodies", "pairs_within", "run_of_bodies", "window"]


# All cells farther than this from the world's origin are one [cells].
FARTHEST = 2.0**50


class BodyHash(NamedTuple):
    """The bodies of all replicas, sorted by bucket; made by `hash_bodies`."""

    side: float
    """Side of a cell [m]; at least the diameter of the largest body."""
    rows: int
    cols: int
    first: Ints
    """Bucket k, counted over the rows of all replicas, holds entries ``first[k]:first[k + 1]``."""
    body: Ints
    """The body of each entry, (T,); in order within a bucket."""
    owner: Ints
    """The body that it is a part of, or itself, (T,)."""
    disc: Array
    """The circle that holds it: x, y, radius [m], (T, 3)."""


@part
def _cell(place: float, side: float) -> int:
    """Row or column of the cell that holds `place` [m]; it never decreases as `place` grows."""
    if place != place:
        return 0
    return math.floor(min(max(place / side, -FARTHEST), FARTHEST))


@part
def window(place: float, half: float, side: float, lines: int) -> tuple[int, int]:
    """First row (or column) of buckets that hold all within `half` [m] of `place`, and their number, of `lines`."""
    half = half * (1.0 + 1e-8) + rounding_slack(abs(place) + half)
    # A place that is nan, or beyond `FARTHEST`, gets all buckets.
    if not abs(place) + half < FARTHEST * side:
        return 0, lines
    low = math.floor((place - half) / side)
    cells = math.floor((place + half) / side) - low + 1
    return (low & (lines - 1), cells) if cells < lines else (0, lines)


@part
def run_of_bodies(
    table: BodyHash, replica: int, row0: int, rows: int, col0: int, cols: int, run: int
) -> tuple[int, int]:
    """First entry and end of a run of bodies in a window of a replica's buckets.

    There are `rows` runs, and as many again where the columns wrap round from the last one to the first.
    """
    wraps = run >= rows
    row = (row0 + (run - rows if wraps else run)) & (table.rows - 1)
    base = (replica * table.rows + row) * table.cols
    left = 0 if wraps else col0
    right = max(col0 + cols - table.cols, 0) if wraps else min(col0 + cols, table.cols)
    return table.first[base + left], table.first[base + right]


@kernel
def hash_bodies(poses: Array, reach: Array, owner: Ints, replica_first: Ints, table: BodyHash) -> None:
    """Write `first`, `body`, `owner` and `disc` of `table` for bodies at `poses` (T, 3) with this `reach` [m] (T,).

    `owner` (T,) is the body that each is a part of, or itself. Bodies of replica r are
    ``replica_first[r]:replica_first[r + 1]``, int64 (R + 1,).
    """
    first = table.first
    bucket = np.empty(reach.shape[0], dtype=np.int64)
    for k in range(first.shape[0]):
        first[k] = 0
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
def pairs_within(table: BodyHash, replica: Ints, looks: Bools, poses: Array, radius: Array, out: Ints) -> int:
    """Number of pairs of bodies of one replica whose circles meet, at least one of them in `looks`; in no fixed order.

    If both look, the wider one finds the other, or the first of two that are equally wide. So a body that moves far
    does not make the others look far.

    Parameters
    ----------
    table
        The bodies at `poses` (T, 3).
    replica
        Which each is of, (T,).
    looks
        Which bodies look, (T,).
    radius
        Of each body's circle around its pose [m], (T,).
    out
        Gets ``a * T + b`` of the pairs of bodies a < b, as far as there is room for them, int64 (P,).
    """
    count = poses.shape[0]
    widest = 0.0  # of those that do not look
    for i in range(count):
        if not looks[i] and radius[i] > widest:
            widest = radius[i]
    found = 0
    for i in range(count):
        if not looks[i]:
            continue
        x = poses[i, 0]
        y = poses[i, 1]
        half = radius[i] + max(radius[i], widest)
        row0, rows = window(y, half, table.side, table.rows)
        col0, cols = window(x, half, table.side, table.cols)
        for run in range(2 * rows if col0 + cols > table.cols else rows):
            start, stop = run_of_bodies(table, replica[i], row0, rows, col0, cols, run)
            for place in range(start, stop):
                j = table.body[place]
                if j == i or (looks[j] and (radius[j] > radius[i] or (radius[j] == radius[i] and j < i))):
                    continue
                dx = x - table.disc[place, 0]
                dy = y - table.disc[place, 1]
                reach = radius[i] + radius[j]
                if dx * dx + dy * dy <= reach * reach:
                    if found < out.shape[0]:
                        out[found] = min(i, j) * count + max(i, j)
                    found += 1
    return found
