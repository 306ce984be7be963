"""Shortest paths over the eight neighbours of cells: steps of 1 and of the square root of 2, cutting no corner."""

from __future__ import annotations

import math

from amorsim.kernels.compile import inlined, kernel, part
from amorsim.kernels.search.frontier import DONE, Search, offer, take

__all__ = ["DIAGONAL", "FOUND", "GOING_ON", "NONE_LEFT", "expand_octile", "octile_distance", "reach"]

DIAGONAL = math.sqrt(2.0)

GOING_ON, FOUND, NONE_LEFT = 0, 1, 2


@part
def octile_distance(width: int, cell: int, other: int) -> float:
    """The length [cells] of the shortest path between two cells if nothing is in the way."""
    up = abs(cell // width - other // width)
    across = abs(cell % width - other % width)
    near = min(up, across)
    return max(up, across) - near + DIAGONAL * near


@inlined
def reach(search: Search, width: int, goal: int, weight: float, cell: int, other: int, step: float) -> None:
    """Reach a free cell from a neighbour, if that is new or shorter."""
    place = search.place[other]
    if place == DONE:
        return
    cost = search.cost[cell] + step
    if place == 0 or cost < search.cost[other]:
        search.cost[other] = cost
        search.parent[other] = cell
        key = cost if weight == 0.0 else cost + weight * octile_distance(width, other, goal)
        offer(search, other, key)


@kernel
def expand_octile(search: Search, width: int, goal: int, weight: float, most: int) -> int:
    """Expand cells until the goal is one of them, none is left, or `most` are expanded; returns which.

    A diagonal step needs both cells next to it free. The estimate of what is left is `weight` times the octile
    distance: with 0 this is Dijkstra's algorithm, with 1 it is A*, and both find a shortest path.
    """
    free = search.free
    for _ in range(most):
        if search.used[0] == 0:
            return NONE_LEFT
        cell = take(search)
        if cell == goal:
            return FOUND
        east, west = free[cell + 1] != 0, free[cell - 1] != 0
        north, south = free[cell + width] != 0, free[cell - width] != 0
        if east:
            reach(search, width, goal, weight, cell, cell + 1, 1.0)
        if west:
            reach(search, width, goal, weight, cell, cell - 1, 1.0)
        if north:
            reach(search, width, goal, weight, cell, cell + width, 1.0)
            if east and free[cell + width + 1]:
                reach(search, width, goal, weight, cell, cell + width + 1, DIAGONAL)
            if west and free[cell + width - 1]:
                reach(search, width, goal, weight, cell, cell + width - 1, DIAGONAL)
        if south:
            reach(search, width, goal, weight, cell, cell - width, 1.0)
            if east and free[cell - width + 1]:
                reach(search, width, goal, weight, cell, cell - width + 1, DIAGONAL)
            if west and free[cell - width - 1]:
                reach(search, width, goal, weight, cell, cell - width - 1, DIAGONAL)
    return GOING_ON if search.used[0] > 0 else NONE_LEFT
