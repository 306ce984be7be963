"""Reachability: places that walls separate."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from amorsim.array_types import Array, Bools
from amorsim.core.maps.map import Map
from amorsim.core.maps.roomiest_place import joined_to

__all__ = ["shut_off"]

Place = tuple[float, float]

MOST = 4096  # the most squares along a side of the map
FINE = 1024  # squares along a side at most, unless `room` needs smaller ones
SQUARES = 10.0  # squares within `room`, unless that makes too many


def shut_off(world: Map, room: float, start: Place, places: Sequence[Place]) -> Bools:
    """Which of some free places `(M,)`, x, y [m], a body that keeps `room` [m] to walls cannot reach from `start`.

    True only if it is certain: any path leads through squares that share sides, and all squares wholly within `room`
    of the body are free. False for all places if there would be too many squares.
    """
    none: Bools = np.zeros(len(places), dtype=np.bool_)
    # No corner of a square is farther from a place in it than its diagonal; cells themselves need no room.
    most = room / math.sqrt(2.0) * (1.0 - 1e-9)
    side = max(world.resolution, min(most, max(room / SQUARES, max(world.size) / FINE)))
    if not len(places) or max(world.size) > MOST * side:
        return none
    free = _with_room(world.to_array(resolution=side) == 0, room / side)
    squares = [_square(world, side, place) for place in (start, *places)]
    row, col = np.floor(squares[0]).astype(int)
    if not (0 <= row < free.shape[0] and 0 <= col < free.shape[1] and free[row, col]):
        return none
    reached = joined_to(free, int(row), int(col))
    return np.array([not _near(free, reached, square) for square in squares[1:]], dtype=np.bool_)


def _with_room(free: Bools, room: float) -> Bools:
    """The free squares in which a body may be that needs `room`, in sides of a square, around it."""
    rows, _ = free.shape
    left = free.copy()
    for up in range(int(room) + 1):
        # A square this far away is wholly within `room` of every point of this one.
        across = math.floor(math.sqrt(max(0.0, room**2 - (up + 1) ** 2)) - 1.0)
        if across < 0:
            break
        blocked = np.pad(
            np.cumsum(~np.pad(free, ((0, 0), (across, across)), constant_values=False), axis=1), ((0, 0), (1, 0))
        )
        clear = blocked[:, 2 * across + 1 :] == blocked[:, : -2 * across - 1]
        left[up:] &= clear[: rows - up]
        left[: rows - up] &= clear[up:]
        left[: min(up, rows)] = False
        left[max(0, rows - up) :] = False
    return left


def _square(world: Map, side: float, place: Place) -> Array:
    """Row and column of a place, in squares from the map's corner."""
    origin_x, origin_y, yaw = world.origin
    c, s = math.cos(yaw), math.sin(yaw)
    dx, dy = place[0] - origin_x, place[1] - origin_y
    return np.array([(c * dy - s * dx) / side, (c * dx + s * dy) / side])


def _near(free: Bools, reached: Bools, square: Array) -> bool:
    """Whether any of the free squares nearest to a place, which may be close to a wall, is reached."""
    rows, cols = free.shape
    row, col = np.floor(square).astype(int).tolist()
    for ring in range(max(rows, cols)):
        about = np.s_[max(0, row - ring) : row + ring + 1, max(0, col - ring) : col + ring + 1]
        if free[about].any():
            return bool(reached[about].any())
    return False
