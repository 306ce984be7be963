"""The bodies near each of some rows, found by where they are, in order of body."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from amorsim.array_types import Array, Ints
from amorsim.kernels.collision.body_hash import BodyHash, run_of_bodies, window
from amorsim.kernels.compile import kernel

__all__ = ["Crowd", "Looking", "find_neighbours"]


class Crowd(NamedTuple):
    """All bodies of all replicas, T of them."""

    poses: Array
    """(T, 3)"""
    twists: Array
    """(T, 3) [m/s, m/s, rad/s], each in its body's frame."""
    reach: Array
    """(T,) radius [m] of each body's circle."""
    owner: Ints
    """(T,) the body that each is a part of, or itself."""


class Looking(NamedTuple):
    """The N rows that look for neighbours."""

    body: Ints
    """(N,) each row's own body."""
    replica: Ints
    """(N,)"""
    range_max: Array
    """(N,) how far [m] a row looks from its base point."""
    ahead: Array
    """(N,) for how long [s] others are taken to come nearer at their present speed."""


@kernel
def find_neighbours(table: BodyHash, crowd: Crowd, replica_first: Ints, rows: Looking, first: Ints, body: Ints) -> int:
    """The number of neighbours of all rows; they are written if there is room for them.

    A body is a row's neighbour if its circle is at most ``range_max + speed * ahead`` away from the row's base point,
    and if it is of another owner.

    Parameters
    ----------
    table
        The bodies at `crowd.poses`.
    crowd
        All bodies.
    replica_first
        Bodies of replica r are ``replica_first[r]:replica_first[r + 1]``, (R + 1,).
    rows
        The rows that look.
    first
        Gets where each row's neighbours begin, (N + 1,).
    body
        Gets the neighbours, each row's in order, int64 (P,).
    """
    count, bodies = rows.body.shape[0], crowd.reach.shape[0]
    replicas = replica_first.shape[0] - 1
    fastest, farthest = np.zeros(replicas), np.zeros(replicas)
    speed_at = np.empty(bodies)  # of the sorted ones
    for place in range(bodies):
        b = table.body[place]
        speed_at[place] = math.sqrt(crowd.twists[b, 0] * crowd.twists[b, 0] + crowd.twists[b, 1] * crowd.twists[b, 1])
    # The sorted ones of a replica stand where its bodies would.
    for r in range(replicas):
        for place in range(replica_first[r], replica_first[r + 1]):
            fastest[r] = max(fastest[r], speed_at[place])
            farthest[r] = max(farthest[r], table.disc[place, 2])
    room = body.shape[0]
    unsorted = np.empty(room, dtype=np.int64)
    # Of each body: how many rows it is near, then where the next of them is put.
    place_of = np.zeros(bodies + 1, dtype=np.int64)
    found = 0
    for n in range(count):
        first[n] = found
        own, r, near, ahead = rows.body[n], rows.replica[n], rows.range_max[n], rows.ahead[n]
        x, y, owner = crowd.poses[own, 0], crowd.poses[own, 1], crowd.owner[own]
        half = near + farthest[r] + fastest[r] * ahead
        row0, lines = window(y, half, table.side, table.rows)
        col0, cols = window(x, half, table.side, table.cols)
        for run in range(2 * lines if col0 + cols > table.cols else lines):
            start, stop = run_of_bodies(table, r, row0, lines, col0, cols, run)
            for place in range(start, stop):
                dx, dy = table.disc[place, 0] - x, table.disc[place, 1] - y
                limit = near + table.disc[place, 2] + speed_at[place] * ahead
                if dx * dx + dy * dy > limit * limit or table.owner[place] == owner:
                    continue
                if found < room:
                    unsorted[found] = table.body[place]
                    place_of[table.body[place] + 1] += 1
                found += 1
    first[count] = found
    if found > room:
        return found
    # Rows in order of the bodies that they are near, and from there, in that order, back to each row.
    for b in range(bodies):
        place_of[b + 1] += place_of[b]
    row_of = np.empty(found, dtype=np.int64)
    for n in range(count):
        for k in range(first[n], first[n + 1]):
            row_of[place_of[unsorted[k]]] = n
            place_of[unsorted[k]] += 1
    next_of = first[:count].copy()
    for b in range(bodies):
        # By now `place_of[b]` is where those of the next body begin.
        for k in range(place_of[b - 1] if b > 0 else 0, place_of[b]):
            body[next_of[row_of[k]]] = b
            next_of[row_of[k]] += 1
    return found
