"""Room for footprints on a map: whether they are free, and the place with most room."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from amorsim.array_types import Array
from amorsim.core.errors import MapError
from amorsim.core.maps.free_places import LARGER, freest_place, roomy_places
from amorsim.core.maps.map import Map
from amorsim.core.poses import compose
from amorsim.core.shapes import SMALLEST, Shape, pack
from amorsim.kernels.collision.clearance import map_gaps

__all__ = [
    "freest_start",
    "least_gaps",
    "out_of_reach",
    "outside",
    "overlap_with_others",
    "overlap_with_walls",
    "wall_gaps",
]


_PLACES = 2000  # tried if the roomiest one is too small
_HEADINGS = 16
_IN_A_WALL = "is in a wall"


def wall_gaps(world: Map, shapes: Sequence[Shape], poses: Array, cap: float = 0.0) -> tuple[Array, Array]:
    """Signed gaps [m] `(N,)` of footprints at `poses` `(N, 3)` to the walls, at most `cap`; nearest points `(N, 2)`.

    A gap is below zero exactly if a footprint's inside overlaps an occupied cell's: the engine uses the same test.
    """
    count = len(shapes)
    gaps, where = np.empty(count), np.empty((count, 2))
    every, caps = np.arange(count, dtype=np.int64), np.full(count, cap)
    map_gaps(world.grid, *world.origin, pack(shapes), every, np.ascontiguousarray(poses), caps, gaps, where)
    return gaps, where


def out_of_reach(world: Map, x: float, y: float) -> str:
    """Why a robot cannot be at a place in the world, in words; empty if the place is free."""
    if not world.occupied([[x, y]])[0]:
        return ""
    return outside(world, x, y) or _IN_A_WALL


def overlap_with_walls(world: Map, x: float, y: float, near: Sequence[float], what: str = "the footprint") -> str:
    """The message for a footprint, or `what`, that overlaps an occupied cell at `near`."""
    beyond = outside(world, x, y)
    if beyond:
        of_part = "" if what == "the footprint" else f", where {what} is,"
        return f"({x:.3f}, {y:.3f}) m{of_part} {beyond}; expected a free place"
    half = 0.5 * world.resolution
    about = [(near[0] + dx, near[1] + dy) for dx in (-half, half) for dy in (-half, half)]
    walls = [place for place in about if out_of_reach(world, *place) == _IN_A_WALL]
    of_what = "a wall" if walls else "the edge of the map"
    return (
        f"at ({x:.3f}, {y:.3f}) m {what} overlaps {of_what} near ({near[0]:.3f}, {near[1]:.3f}) m; "
        "expected a free place"
    )


def overlap_with_others(names: Sequence[str]) -> str:
    """The message for a body that overlaps others: names the first, and how many more."""
    more = f" and {len(names) - 1} more" if len(names) > 1 else ""
    return f"overlaps {names[0]!r}{more}; expected room between them"


def outside(world: Map, x: float, y: float) -> str:
    """The message for a place in the world outside the map; empty if it is within."""
    origin_x, origin_y, yaw = world.origin
    c, s = math.cos(yaw), math.sin(yaw)
    along, up = c * (x - origin_x) + s * (y - origin_y), c * (y - origin_y) - s * (x - origin_x)
    width, height = world.size
    if 0.0 <= along <= width and 0.0 <= up <= height:
        return ""
    turned = f", turned by {math.degrees(yaw):g} degrees" if yaw else ""
    return f"is outside the map, which is {width:g} m x {height:g} m from ({origin_x:g}, {origin_y:g}) m on{turned}"


def freest_start(
    world: Map, shape: Shape, others: Sequence[tuple[Shape, Sequence[float]]] = ()
) -> tuple[float, float, float]:
    """A free pose (x [m], y [m], heading [rad]) for a footprint with much room around it; always the same one.

    That is the map's roomiest place, heading along x, if the footprint fits there. Otherwise it is the one of many
    roomy places and headings with the widest gap to the walls. `others` need room too: shapes at poses in its frame.

    Raises
    ------
    MapError
        If it fits at none of the places tried.
    """
    x, y = freest_place(world)
    together = [(shape, (0.0, 0.0, 0.0)), *others]
    if least_gaps(world, together, np.array([[x, y, 0.0]]))[0] >= 0.0:
        return x, y, 0.0
    places = np.array(roomy_places(world, _PLACES))
    headings = np.arange(_HEADINGS) * (2.0 * math.pi / _HEADINGS)
    headings[headings > math.pi] -= 2.0 * math.pi
    poses = np.column_stack((np.repeat(places, _HEADINGS, axis=0), np.tile(headings, len(places))))
    gaps = least_gaps(world, together, poses, max(world.size))
    best = int(np.argmax(gaps))
    if gaps[best] < 0.0:
        # Of an overlap, how deep it is means little: it is that in a single cell.
        dot = Shape.circle(SMALLEST)
        room = wall_gaps(world, [dot], np.array([[x, y, 0.0]]), max(world.size))[0][0] + SMALLEST
        width, height = world.size
        raise MapError(
            f"the map has no place where a footprint that reaches {_reach(together):.3g} m from its base point fits: "
            f"the one with most room, ({x:.3f}, {y:.3f}) m, is {room:.3g} m from the nearest wall, and the map is "
            f"{width:.4g} m x {height:.4g} m. Take a smaller robot, or {LARGER}"
        )
    return float(poses[best, 0]), float(poses[best, 1]), float(poses[best, 2])


def least_gaps(world: Map, together: Sequence[tuple[Shape, Sequence[float]]], poses: Array, cap: float = 0.0) -> Array:
    """The least gap [m] `(N,)` of several shapes, at poses relative to each of `poses` `(N, 3)`, to the walls."""
    found: Array = np.full(len(poses), math.inf)
    for shape, inside in together:
        at = compose(poses, np.repeat([inside], len(poses), axis=0))
        found = np.minimum(found, wall_gaps(world, [shape] * len(poses), at, cap)[0])
    return found


def _reach(together: Sequence[tuple[Shape, Sequence[float]]]) -> float:
    return max(math.hypot(x, y) + shape.reach for shape, (x, y, _) in together)
