"""Probabilistic roadmaps: random free places, joined where a line between near ones is free.

L. E. Kavraki and others, "Probabilistic roadmaps for path planning in high-dimensional configuration spaces", IEEE
Transactions on Robotics and Automation 12, 1996. Lines are looked at only when a path may need them.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from amorsim.array_types import Array, Ints
from amorsim.kernels.compile import kernel
from amorsim.kernels.search.any_angle import is_open_line
from amorsim.kernels.search.trees import draw, is_free

__all__ = ["search_roadmap", "spread_places"]

Ints32 = NDArray[np.int32]


@kernel
def spread_places(free: NDArray[np.uint8], width: int, seed: int, first: int, last: int, out: Array) -> int:
    """Write the free ones (n, 2) of samples `first` to `last` - 1 [cells]; returns how many."""
    rows = free.shape[0] // width - 2
    count = 0
    for number in range(first, last):
        u, v, _ = draw(seed, number, 1)
        x, y = u * (width - 2), v * rows
        if is_free(free, width, x, y):
            out[count, 0], out[count, 1] = x, y
            count += 1
    return count


@kernel
def search_roadmap(
    free: NDArray[np.uint8],
    width: int,
    places: Array,
    radius: float,
    cost: Array,
    parent: Ints32,
    state: NDArray[np.uint8],
    links: Ints32,
    used: Ints,
    most: int,
) -> int:
    """Expand places by their distance from place 0 until place 1 is one: returns 1, or 2 if none is left, else 0.

    Parameters
    ----------
    places
        (n, 2) [cells].
    radius
        How far apart [cells] places are that a line joins.
    cost, parent
        (n,) [cells] from place 0, inf where it has not come; and the place before.
    state
        (n,) 1 for a place that was taken up.
    links
        (k, 2) the free lines that were looked at, as far as there is room.
    used
        (2,) entries of `links` in use, and places taken up.
    """
    n = places.shape[0]
    for _ in range(most):
        best = math.inf
        at = -1
        for i in range(n):
            if state[i] == 0 and cost[i] < best:
                best = cost[i]
                at = i
        if at < 0:
            return 2
        state[at] = 1
        used[1] += 1
        if at == 1:
            return 1
        x, y = places[at, 0], places[at, 1]
        for i in range(n):
            if state[i] != 0:
                continue
            dx, dy = places[i, 0] - x, places[i, 1] - y
            square = dx * dx + dy * dy
            if square > radius * radius:
                continue
            longer = best + math.sqrt(square)
            if longer < cost[i] and is_open_line(free, width, x, y, places[i, 0], places[i, 1]):
                cost[i] = longer
                parent[i] = at
                if used[0] < links.shape[0]:
                    links[used[0], 0], links[used[0], 1] = at, i
                    used[0] += 1
    return 0
