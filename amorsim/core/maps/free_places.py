"""Free places of a map, and those with most room."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator

import numpy as np

from amorsim.array_types import Array, Bools
from amorsim.core.errors import MapError
from amorsim.core.maps.map import Map
from amorsim.core.maps.roomiest_place import inside, joined, room_about, roomiest

__all__ = ["LARGER", "free_places", "freest_place", "roomy_places"]

LARGER = "if the map is larger in fact, say so by its resolution, size, unit or scale"
"""The advice for a drawing or picture that was read too small, for messages."""


def freest_place(world: Map) -> tuple[float, float]:
    """A free place (x, y) [m] of the world with most room around it; always the same one.

    Places that walls separate from the map's border are preferred if they are a fair part of the free area, so the
    place is in the building and not around it. Nothing unknown counts as free here. The search starts with cells of at
    most 1/256 of the map, and takes finer ones, up to 1/4096, only while hardly any is free.

    Raises
    ------
    MapError
        If nothing is free at the finest of these.
    """
    side = world.resolution
    for free, side in _looks(world):
        found = roomiest(free)
        if found is not None and (found[2] > 1 or _is_finest(world, side)):
            row, col, _ = found
            return _to_world(world, (col + 0.5) * side, (row + 0.5) * side)
    raise MapError(f"{_nothing_free(world, side)}; give the robot a pose, or {LARGER}")


def roomy_places(world: Map, count: int) -> list[tuple[float, float]]:
    """Up to `count` free places (x, y) [m] of the world, those with most room first, searched as in `freest_place`.

    Raises
    ------
    MapError
        If nothing is free at the finest look.
    """
    cells, side = _free_cells(world, inside)
    room = room_about(cells)
    rows, cols = np.nonzero(room)
    order = np.argsort(-room[rows, cols], kind="stable")[:count]
    places = zip(rows[order].tolist(), cols[order].tolist(), strict=True)
    return [_to_world(world, (col + 0.5) * side, (row + 0.5) * side) for row, col in places]


def free_places(world: Map, clearance: float = 0.0) -> tuple[Array, float]:
    """Middles (M, 2) [m] in the world of free squares, and their side [m], searched as in `freest_place`.

    Only squares that free squares connect to the roomiest place: none in a hollow pillar, or around the building; and
    only those whose middle is at least `clearance` [m] from all that is not free, or if there are none, the roomiest.

    Raises
    ------
    MapError
        If nothing is free at the finest look.
    """
    cells, side = _free_cells(world, joined)
    if clearance > 0.0:
        room = room_about(cells)
        cells = room >= min(clearance / side + 0.5, room.max())
    rows, cols = np.nonzero(cells)
    x, y = (cols + 0.5) * side, (rows + 0.5) * side
    origin_x, origin_y, yaw = world.origin
    c, s = math.cos(yaw), math.sin(yaw)
    return np.column_stack((origin_x + c * x - s * y, origin_y + s * x + c * y)), side


def _free_cells(world: Map, select: Callable[[Bools], Bools]) -> tuple[Bools, float]:
    side = world.resolution
    for free, side in _looks(world):
        cells = select(free)
        if cells.any() and (room_about(cells).max() > 1 or _is_finest(world, side)):
            return cells, side
    raise MapError(f"{_nothing_free(world, side)}; {LARGER}")


def _nothing_free(world: Map, side: float) -> str:
    width, height = world.size
    return f"the map, {width:.4g} m x {height:.4g} m, has no free place of {side:.3g} m x {side:.3g} m"


def _looks(world: Map) -> Iterator[tuple[Bools, float]]:
    """Coarse views of the squares known to be free, with their sides [m], each finer than the one before."""
    longest = max(world.size)
    for pieces in (256, 1024, 4096):
        # A little more than 1/pieces, so that rounding makes no piece more.
        side = max(world.resolution, longest / pieces * (1.0 + 1e-9))
        free = world.to_array(resolution=side) == 0
        if world.unknown is not None:
            free &= world.unknown_array(resolution=side) == 0
        # Squares that reach beyond the map may have their middle there.
        free[int((world.size[1] + 0.01 * side) / side) :] = False
        free[:, int((world.size[0] + 0.01 * side) / side) :] = False
        yield free, side
        if side == world.resolution:
            return


def _is_finest(world: Map, side: float) -> bool:
    return side == world.resolution or side < max(world.size) / 4000


def _to_world(world: Map, x: float, y: float) -> tuple[float, float]:
    origin_x, origin_y, yaw = world.origin
    if yaw == 0.0:
        return origin_x + x, origin_y + y
    c, s = math.cos(yaw), math.sin(yaw)
    return origin_x + c * x - s * y, origin_y + s * x + c * y
