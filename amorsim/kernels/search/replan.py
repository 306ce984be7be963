"""D* Lite: a shortest path that is kept while cells change and the start moves.

After S. Koenig and M. Likhachev, "D* Lite", AAAI 2002: the keys of its optimised version, the updates of its plain one.
What a cell's cost should be is always computed from all its neighbours. The search runs from the goal.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from amorsim.array_types import Array, Ints, Ints32
from amorsim.kernels.compile import kernel, part
from amorsim.kernels.search.octile import DIAGONAL, FOUND, GOING_ON, NONE_LEFT, octile_distance

__all__ = ["Replan", "follow", "new_replan", "repair", "update_around"]

# Keys closer than this are one but for rounding; a cell that is settled needlessly does no harm, one left out does.
_SAME = 1e-6


class Replan(NamedTuple):
    """The state of a search on n cells, which lie as in `amorsim.kernels.search.frontier`."""

    free: NDArray[np.uint8]  # (n,) 1 where a path may lead
    cost: Array  # (n,) [cells] to the goal, as last settled
    ahead: Array  # (n,) [cells] to the goal, by the costs of the neighbours
    place: Ints32  # (n,) 0 for a cell not in the heap, else 1 + its index
    heap: Ints32  # (n,) the cells whose `cost` is not what it should be
    first: Array  # (n,) of each entry of the heap: its cost, with the estimate to the start
    second: Array  # (n,) of each entry of the heap: its cost
    used: Ints  # (2,) entries of the heap in use, cells expanded in the last `repair`
    moved: Array  # (1,) [cells] that the start has moved, at most


def new_replan(free: NDArray[np.uint8], width: int, start: int, goal: int) -> Replan:
    """A search that has not begun."""
    n = len(free)
    search = Replan(
        free=free.copy(),
        cost=np.full(n, np.inf),
        ahead=np.full(n, np.inf),
        place=np.zeros(n, np.int32),
        heap=np.empty(n, np.int32),
        first=np.empty(n),
        second=np.empty(n),
        used=np.zeros(2, np.int64),
        moved=np.zeros(1),
    )
    search.ahead[goal] = 0.0
    search.heap[0] = goal
    search.place[goal] = 1
    search.first[0] = octile_distance(width, start, goal)
    search.second[0] = 0.0
    search.used[0] = 1
    return search


@part
def _is_less(first: float, second: float, other_first: float, other_second: float) -> bool:
    """Whether a key of two numbers [cells] comes before another."""
    return first < other_first or (first == other_first and second < other_second)


@part
def _put(search: Replan, at: int, cell: int, first: float, second: float) -> None:
    """Write an entry of the heap: a cell and its key [cells]."""
    search.heap[at] = cell
    search.first[at] = first
    search.second[at] = second
    search.place[cell] = at + 1


@part
def _settle(search: Replan, at: int, cell: int, first: float, second: float) -> None:
    """Move an entry to its position in the heap, from an index whose entry is dropped."""
    size = search.used[0]
    while at > 0:
        above = (at - 1) >> 1
        if not _is_less(first, second, search.first[above], search.second[above]):
            break
        _put(search, at, search.heap[above], search.first[above], search.second[above])
        at = above
    while True:
        below = 2 * at + 1
        if below >= size:
            break
        if below + 1 < size and _is_less(
            search.first[below + 1], search.second[below + 1], search.first[below], search.second[below]
        ):
            below += 1
        if not _is_less(search.first[below], search.second[below], first, second):
            break
        _put(search, at, search.heap[below], search.first[below], search.second[below])
        at = below
    _put(search, at, cell, first, second)


@part
def _remove(search: Replan, cell: int) -> None:
    """Take a cell out of the heap."""
    at = search.place[cell] - 1
    search.place[cell] = 0
    last = search.used[0] - 1
    search.used[0] = last
    if at < last:
        _settle(search, at, search.heap[last], search.first[last], search.second[last])


@part
def _best_ahead(search: Replan, width: int, cell: int) -> float:
    """The cost of a cell by those of its neighbours; inf in one that is not free."""
    free, cost = search.free, search.cost
    best = math.inf
    if free[cell] == 0:
        return best
    for up in (-width, 0, width):
        if free[cell + up] == 0:
            continue
        for across in (-1, 0, 1):
            other = cell + up + across
            if other != cell and free[cell + across] and free[other]:
                step = DIAGONAL if up != 0 and across != 0 else 1.0
                best = min(best, cost[other] + step)
    return best


@part
def _update(search: Replan, width: int, start: int, goal: int, cell: int) -> None:
    """Bring a cell's cost by its neighbours [cells] up to date, and its place in the heap."""
    if cell != goal:
        search.ahead[cell] = _best_ahead(search, width, cell)
    if search.cost[cell] == search.ahead[cell]:
        if search.place[cell] != 0:
            _remove(search, cell)
        return
    second = min(search.cost[cell], search.ahead[cell])
    first = second + octile_distance(width, start, cell) + search.moved[0]
    at = search.place[cell] - 1
    if at < 0:
        at = search.used[0]
        search.used[0] = at + 1
    _settle(search, at, cell, first, second)


@kernel
def update_around(search: Replan, width: int, start: int, goal: int, cell: int) -> None:
    """Note that a cell has changed: its own steps, and diagonal ones between its neighbours."""
    rows = len(search.free) // width
    for up in (-1, 0, 1):
        for across in (-1, 0, 1):
            row, col = cell // width + up, cell % width + across
            if 0 < row < rows - 1 and 0 < col < width - 1:
                _update(search, width, start, goal, row * width + col)


@kernel
def repair(search: Replan, width: int, start: int, goal: int, order: Ints32) -> int:
    """Expand cells until the costs along the path from the start are right, or `order` is full; returns which.

    Writes the cells expanded into `order`, and their number into ``used[1]``.
    """
    search.used[1] = 0
    while True:
        least = min(search.cost[start], search.ahead[start])
        is_whole = search.cost[start] == search.ahead[start]
        if search.used[0] == 0 or (is_whole and search.first[0] > least + search.moved[0] + _SAME):
            return FOUND if search.cost[start] < math.inf else NONE_LEFT
        if search.used[1] == len(order):
            return GOING_ON
        cell = search.heap[0]
        order[search.used[1]] = cell
        search.used[1] += 1
        second = min(search.cost[cell], search.ahead[cell])
        first = second + octile_distance(width, start, cell) + search.moved[0]
        if _is_less(search.first[0], search.second[0], first, second):  # its key is from before the start moved
            _settle(search, 0, cell, first, second)
            continue
        _remove(search, cell)
        if search.cost[cell] > search.ahead[cell]:
            search.cost[cell] = search.ahead[cell]
        else:
            search.cost[cell] = math.inf
            _update(search, width, start, goal, cell)
        for up in (-width, 0, width):
            for across in (-1, 0, 1):
                other = cell + up + across
                if other != cell and search.free[other]:
                    _update(search, width, start, goal, other)


@kernel
def follow(search: Replan, width: int, start: int, goal: int, out: Ints32) -> int:
    """Write the cells of the path from the start of a search that was repaired; returns how many."""
    free = search.free
    out[0] = start
    count = 1
    cell = start
    while cell != goal and count < len(out):
        least = math.inf
        after = cell
        for up in (-width, 0, width):
            for across in (-1, 0, 1):
                other = cell + up + across
                if other == cell or not (free[other] and free[cell + up] and free[cell + across]):
                    continue
                cost = search.cost[other] + (DIAGONAL if up != 0 and across != 0 else 1.0)
                if cost < least:
                    least = cost
                    after = other
        cell = after
        out[count] = cell
        count += 1
    return count
