"""The frontier of a search on cells: a binary heap of the cells that were reached and not yet expanded.

Cells lie in flat arrays, row after row from the lowest up, with a border of blocked cells around the map, so that a
cell's neighbours need no test of bounds. `width` is the number of cells in a row, the border included: cell c
has the neighbours c - 1, c + 1, c - width, c + width, and those between. Costs are in cells, from centre to centre.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from amorsim.array_types import Array, Ints, Ints32
from amorsim.kernels.compile import part

__all__ = ["DONE", "Search", "new_search", "offer", "take"]

DONE = -1


class Search(NamedTuple):
    """The state of a search on n cells."""

    free: NDArray[np.uint8]  # (n,) 1 where a path may lead
    cost: Array  # (n,) [cells] from the start, of the cells that were reached
    parent: Ints32  # (n,) the cell that each reached cell is reached from
    place: Ints32  # (n,) 0 for a cell not reached, DONE for one expanded, else 1 + its index in the heap
    heap: Ints32  # (n,) the cells of the frontier
    key: Array  # (n,) of each entry of the heap: cost, and the estimate of what is left
    order: Ints32  # (n,) the cells expanded, in order
    used: Ints  # (2,) how many entries of `heap` and of `order` are in use


def new_search(free: NDArray[np.uint8], start: int) -> Search:
    """A search that has reached its start."""
    n = len(free)
    search = Search(
        free=free,
        cost=np.empty(n),
        parent=np.empty(n, np.int32),
        place=np.zeros(n, np.int32),
        heap=np.empty(n, np.int32),
        key=np.empty(n),
        order=np.empty(n, np.int32),
        used=np.array([1, 0]),
    )
    search.cost[start] = 0.0
    search.parent[start] = start
    search.place[start] = 1
    search.heap[0] = start
    search.key[0] = 0.0
    return search


@part
def _is_before(search: Search, key: float, cell: int, other: int) -> bool:
    """Whether a cell with this key is expanded before entry `other`; of equal keys, the one with more behind it."""
    theirs = search.key[other]
    return bool(key < theirs or (key == theirs and search.cost[cell] > search.cost[search.heap[other]]))


@part
def offer(search: Search, cell: int, key: float) -> None:
    """Put a cell into the frontier, or move it forward; its cost is written already."""
    heap, keys, place = search.heap, search.key, search.place
    at = place[cell] - 1
    if at < 0:
        at = search.used[0]
        search.used[0] = at + 1
    while at > 0:
        above = (at - 1) >> 1
        if not _is_before(search, key, cell, above):
            break
        heap[at] = heap[above]
        keys[at] = keys[above]
        place[heap[at]] = at + 1
        at = above
    heap[at] = cell
    keys[at] = key
    place[cell] = at + 1


@part
def take(search: Search) -> int:
    """The first cell of a frontier that is not empty; it is removed and counted as expanded."""
    heap, keys, place = search.heap, search.key, search.place
    first = heap[0]
    place[first] = DONE
    search.order[search.used[1]] = first
    search.used[1] += 1
    size = search.used[0] - 1
    search.used[0] = size
    if size > 0:
        cell, key = heap[size], keys[size]
        at = 0
        while True:
            below = 2 * at + 1
            if below >= size:
                break
            if below + 1 < size and _is_before(search, keys[below + 1], heap[below + 1], below):
                below += 1
            if not _is_before(search, keys[below], heap[below], size):
                break
            heap[at] = heap[below]
            keys[at] = keys[below]
            place[heap[at]] = at + 1
            at = below
        heap[at] = cell
        keys[at] = key
        place[cell] = at + 1
    return int(first)
