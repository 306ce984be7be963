"""Paths of least cost where each cell has a price."""

from __future__ import annotations

from amorsim.array_types import Array
from amorsim.kernels.compile import kernel, part
from amorsim.kernels.search.frontier import DONE, Search, offer, take
from amorsim.kernels.search.octile import DIAGONAL, FOUND, GOING_ON, NONE_LEFT

__all__ = ["expand_priced"]


@part
def _reach(search: Search, price: Array, cell: int, other: int, step: float) -> None:
    """Reach a free cell from a neighbour, at the mean of both prices, if that is new or cheaper."""
    if search.place[other] == DONE:
        return
    cost = search.cost[cell] + 0.5 * step * (price[cell] + price[other])
    if search.place[other] == 0 or cost < search.cost[other]:
        search.cost[other] = cost
        search.parent[other] = cell
        offer(search, other, cost)


@kernel
def expand_priced(search: Search, price: Array, width: int, goal: int, most: int) -> int:
    """Expand cells by Dijkstra's algorithm until the goal is one, none is left, or `most` are expanded; returns which.

    A step costs its length [cells] times the mean price of its two cells, above 0, and cuts no corner.
    """
    free = search.free
    for _ in range(most):
        if search.used[0] == 0:
            return NONE_LEFT
        cell = take(search)
        if cell == goal:
            return FOUND
        for across in (-1, 1):
            if free[cell + across]:
                _reach(search, price, cell, cell + across, 1.0)
        for up in (-width, width):
            if free[cell + up]:
                _reach(search, price, cell, cell + up, 1.0)
                for across in (-1, 1):
                    if free[cell + across] and free[cell + up + across]:
                        _reach(search, price, cell, cell + up + across, DIAGONAL)
    return GOING_ON if search.used[0] > 0 else NONE_LEFT
