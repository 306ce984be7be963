"""Paths at any angle: lines of sight between cells, and the search that uses them."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from amorsim.kernels.compile import kernel, part
from amorsim.kernels.search.frontier import DONE, Search, offer, take
from amorsim.kernels.search.octile import DIAGONAL, FOUND, GOING_ON, NONE_LEFT

__all__ = ["expand_any_angle", "is_clear_line", "is_open_line", "straight_distance"]


_TINY = 1e-9


@part
def straight_distance(width: int, cell: int, other: int) -> float:
    """The distance [cells] between the centres of two cells."""
    up = cell // width - other // width
    across = cell % width - other % width
    return math.sqrt(up * up + across * across)


@part
def is_clear_line(free: NDArray[np.uint8], width: int, cell: int, other: int) -> bool:
    """Whether the line between the centres of two free cells touches free cells only, in whole numbers.

    A line through a corner touches all four cells there.
    """
    up, across = other // width - cell // width, other % width - cell % width
    rows, cols = abs(up), abs(across)
    step_up = width if up > 0 else -width
    step_across = 1 if across > 0 else -1
    row = col = 0
    while row < rows or col < cols:
        # Which border comes next: the line meets border k of its columns at (2 k + 1) / (2 cols) of its length.
        next_col, next_row = (2 * col + 1) * rows, (2 * row + 1) * cols
        if next_col == next_row and not (free[cell + step_across] and free[cell + step_up]):
            return False
        if next_col <= next_row:
            cell += step_across
            col += 1
        if next_row <= next_col:
            cell += step_up
            row += 1
        if free[cell] == 0:
            return False
    return True


@kernel
def is_open_line(free: NDArray[np.uint8], width: int, x0: float, y0: float, x1: float, y1: float) -> bool:
    """Whether all cells within 1e-9 cells of a line are free; from (x0, y0) to (x1, y1) [cells] in the map's frame."""
    for row in range(math.floor(min(y0, y1) - _TINY), math.floor(max(y0, y1) + _TINY) + 1):
        first, last = x0, x1
        if y0 != y1:
            low = min(max((row - _TINY - y0) / (y1 - y0), 0.0), 1.0)
            high = min(max((row + 1 + _TINY - y0) / (y1 - y0), 0.0), 1.0)
            first, last = x0 + (x1 - x0) * low, x0 + (x1 - x0) * high
        for col in range(math.floor(min(first, last) - _TINY), math.floor(max(first, last) + _TINY) + 1):
            if free[(row + 1) * width + col + 1] == 0:
                return False
    return True


@part
def _reach(search: Search, width: int, goal: int, lazy: bool, cell: int, other: int, step: float) -> None:
    """Reach a free cell from its neighbour's parent if that sees it, or else from the neighbour."""
    if search.place[other] == DONE:
        return
    parent = search.parent[cell]
    if lazy or is_clear_line(search.free, width, parent, other):
        cost = search.cost[parent] + straight_distance(width, parent, other)
    else:
        parent = cell
        cost = search.cost[cell] + step
    if search.place[other] == 0 or cost < search.cost[other]:
        search.cost[other] = cost
        search.parent[other] = parent
        offer(search, other, cost + straight_distance(width, other, goal))


@part
def _amend(search: Search, width: int, cell: int) -> None:
    """Give a cell that does not see its parent the best of its expanded neighbours for one."""
    free = search.free
    least = math.inf
    for up in (-width, 0, width):
        for across in (-1, 0, 1):
            other = cell + up + across
            if other == cell or search.place[other] != DONE or not (free[cell + up] and free[cell + across]):
                continue
            cost = search.cost[other] + (DIAGONAL if up != 0 and across != 0 else 1.0)
            if cost < least:
                least = cost
                search.parent[cell] = other
    search.cost[cell] = least


@kernel
def expand_any_angle(search: Search, width: int, goal: int, lazy: bool, most: int) -> int:
    """Expand cells until the goal is one of them, none is left, or `most` are expanded; returns which.

    This is basic Theta*. If `lazy`, a line of sight is taken for granted until its cell is expanded.
    """
    free = search.free
    for _ in range(most):
        if search.used[0] == 0:
            return NONE_LEFT
        cell = take(search)
        if lazy and not is_clear_line(free, width, search.parent[cell], cell):
            _amend(search, width, cell)
        if cell == goal:
            return FOUND
        for across in (-1, 1):
            if free[cell + across]:
                _reach(search, width, goal, lazy, cell, cell + across, 1.0)
        for up in (-width, width):
            if free[cell + up]:
                _reach(search, width, goal, lazy, cell, cell + up, 1.0)
                for across in (-1, 1):
                    if free[cell + across] and free[cell + up + across]:
                        _reach(search, width, goal, lazy, cell, cell + up + across, DIAGONAL)
    return GOING_ON if search.used[0] > 0 else NONE_LEFT
