"""What nearby robots send: a table for each receiver, the nearest sender first."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from amorsim.array_types import Array, Bools, Ints
from amorsim.kernels.compile import kernel

__all__ = ["Senders", "hear_nearest"]


class Senders(NamedTuple):
    """The bodies near each of N receivers, as `amorsim.contracts.Neighbours` without who may send."""

    own: Ints
    """(N,) the receiver's own body."""
    first: Ints
    """(N + 1,) receiver n's neighbours are ``body[first[n]:first[n + 1]]``."""
    body: Ints
    """(K,) the neighbour's body, in order for each receiver."""
    poses: Array
    """(T, 3) of all bodies, true, in the world."""
    twists: Array
    """(T, 3) [m/s, m/s, rad/s], each in its body's frame."""
    reach: Array
    """(T,) [m] radius of the circle around the base point that holds the footprint."""
    sends: Bools
    """(T,) whether the body sends: robots do, their parts and obstacles do not."""


@kernel
def hear_nearest(near: Senders, mounts: Array, range_max: Array, out: Array) -> None:
    """The table of each receiver, into `out` (N, S, 6): range, x, y [m], vx, vy [m/s] and radius [m] of S senders.

    Parameters
    ----------
    near
        The bodies around each receiver, all senders within `range_max` among them.
    mounts
        (N, 3) true poses of the receivers in the world; places and velocities are in their frames.
    range_max
        (N, 1) [m] between base points.
    out
        An empty slot reads inf for range and place, and 0 for the rest. Of senders at the same distance, the lower
        body comes first.
    """
    slots = out.shape[1]
    chosen = np.empty(slots, dtype=np.int64)
    squares = np.empty(slots)
    cosines = np.full(near.reach.shape[0], math.nan)  # of the senders' headings, once they are needed
    sines = np.empty(near.reach.shape[0])
    for n in range(out.shape[0]):
        x, y = near.poses[near.own[n], 0], near.poses[near.own[n], 1]
        most = range_max[n, 0] * range_max[n, 0]
        count = 0
        for k in range(near.first[n], near.first[n + 1]):
            body = near.body[k]
            dx, dy = near.poses[body, 0] - x, near.poses[body, 1] - y
            square = dx * dx + dy * dy
            if not near.sends[body] or not square <= most:
                continue
            if count == slots and not square < squares[slots - 1]:
                continue
            place = min(count, slots - 1)
            while place > 0 and square < squares[place - 1]:
                squares[place] = squares[place - 1]
                chosen[place] = chosen[place - 1]
                place -= 1
            squares[place] = square
            chosen[place] = body
            count = min(count + 1, slots)
        own_c, own_s = math.cos(mounts[n, 2]), math.sin(mounts[n, 2])
        for place in range(count):
            body = chosen[place]
            if math.isnan(cosines[body]):
                cosines[body] = math.cos(near.poses[body, 2])
                sines[body] = math.sin(near.poses[body, 2])
            c, s = cosines[body], sines[body]
            forward, left = near.twists[body, 0], near.twists[body, 1]
            vx, vy = c * forward - s * left, s * forward + c * left
            dx, dy = near.poses[body, 0] - mounts[n, 0], near.poses[body, 1] - mounts[n, 1]
            out[n, place, 0] = math.sqrt(dx * dx + dy * dy)
            out[n, place, 1] = own_c * dx + own_s * dy
            out[n, place, 2] = own_c * dy - own_s * dx
            out[n, place, 3] = own_c * vx + own_s * vy
            out[n, place, 4] = own_c * vy - own_s * vx
            out[n, place, 5] = near.reach[body]
        for place in range(count, slots):
            for value in range(6):
                out[n, place, value] = math.inf if value < 3 else 0.0
