"""A cone's nearest return, from the walls around it.

The map's line features bound every ray from below (`amorsim.kernels.grid.segments`): only rays that could be nearest
by these bounds are cast, from the distance up to which all are free. Mostly that is one ray, perpendicular to a wall or
at its end. Walls that are boxes of occupied cells need no ray at all (`amorsim.kernels.raycast.cone_boxes`).
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from amorsim.array_types import Array, Ints
from amorsim.kernels.compile import part
from amorsim.kernels.grid.grid import ONE, Grid, word_at
from amorsim.kernels.grid.segments import INSIDE, PASSED, SegmentIndex, side_of
from amorsim.kernels.raycast.cone_boxes import NEXT, bearing_of, enter_box
from amorsim.kernels.raycast.cone_cells import SAFETY
from amorsim.kernels.raycast.rays import direction, march, rounding

__all__ = ["AT_ONCE", "ROOM", "Cone", "Eye", "WallRoom", "hear_walls"]


AT_ONCE = 32  # walls that are tested together
# The offsets of the results in one array, first for sides, then for ends: squared distances, and the nearest places
# relative to the cone's point.
_SQUARE, _X, _Y = (i * 2 * AT_ONCE for i in range(3))
ROOM = 6 * AT_ONCE
_NOWHERE, _FARTHEST = 0x7FF0000000000000, 0x7FFFFFFFFFFFFFFF  # the bits of inf, and the greatest of all
_TINY = 1e-300
_TOUCH = 1e-3  # [cells]
_NO_RAY = 1 << 62
_STEPS = 12  # cells that a ray walks before it jumps


class Cone(NamedTuple):
    """A cone of rays, evenly spread from -half_angle to half_angle."""

    half_angle: float
    edge: Array  # cosine and sine of half_angle
    cos_b: Array  # (1, k) cosines and sines of the rays' bearings
    sin_b: Array


class Eye(NamedTuple):
    """The point of a cone in the map's frame, its cell, and the direction of its axis."""

    x: float
    y: float
    col: int
    row: int
    cos_h: float
    sin_h: float


class WallRoom(NamedTuple):
    """The walls about a place, as `walls_about` writes them for M walls, and arrays to work in."""

    found: Ints  # (M,)
    about: Array  # (6, M + AT_ONCE)
    away: Array  # (M,)
    candidates: Ints  # (M,)
    rings: Ints  # (RINGS + 2,)
    f: Array  # (ROOM,)
    bits: Ints  # the same memory


@part
def _bound(
    about: Array,
    first: int,
    count: int,
    x: float,
    y: float,
    right_x: float,
    right_y: float,
    left_x: float,
    left_y: float,
    f: Array,
) -> None:
    """Write how near `count` walls from number `first` on come within a cone, their sides and their ends by themselves.

    `about` is of `lines.walls_about`; (right_x, right_y) and (left_x, left_y) are the edges of the cone. Into `f` go
    squares of distances, and the places that are so near, as they are laid out above. All are bounds: what a wall
    occupies is in its rectangle. Cases are chosen, not branched to, and it is always the same number of walls, so that
    the loop goes several wide and has no rest; the last of them may say nothing.
    """
    for j in range(np.uint64(AT_ONCE)):
        i = j + np.uint64(first)
        counts = np.int64(j) < count
        tx = about[2, i]
        ty = about[3, i]
        to_x = about[0, i] - x
        to_y = about[1, i] - y
        across = ty * to_x - tx * to_y
        along = tx * to_x + ty * to_y
        is_left = across < 0.0
        margin = about[5, i]
        near = abs(across) - margin
        far = abs(across) + margin
        start = along - margin
        stop = along + about[4, i] + margin
        # The edges along the wall and across it, toward it; which of them is on the right as seen that way.
        right_t = tx * right_x + ty * right_y
        left_t = tx * left_x + ty * left_y
        right_n = ty * right_x - tx * right_y
        left_n = ty * left_x - tx * left_y
        a_t = right_t if is_left else left_t
        b_t = left_t if is_left else right_t
        a_n = -right_n if is_left else left_n
        b_n = -left_n if is_left else right_n
        nx = -ty if is_left else ty
        ny = tx if is_left else -tx
        # An edge along the wall, or square to it, sets no bound, or leaves nothing; it must not give nan.
        a_t += _TINY
        b_t += _TINY
        a_n += _TINY
        b_n += _TINY
        # Of the side, from `start` to `stop` along the wall, what is left of one edge and right of the other.
        a = near * (a_t / a_n)
        b = near * (b_t / b_n)
        low = max(start, max(-np.inf if a_n > 0.0 else a, b if b_n > 0.0 else -np.inf))
        high = min(stop, min(a if a_n > 0.0 else np.inf, np.inf if b_n > 0.0 else b))
        low -= SAFETY * (abs(low) + far)
        high += SAFETY * (abs(high) + far)
        place = low if low > 0.0 else (high if high < 0.0 else 0.0)
        seen = (near > 0.0) & (low <= high) & counts
        f[j + np.uint64(_SQUARE)] = near * near + place * place if seen else np.inf
        f[j + np.uint64(_X)] = tx * place + nx * near
        f[j + np.uint64(_Y)] = ty * place + ny * near
        # The same of the end that faces here.
        at = start if start > 0.0 else (stop if stop < 0.0 else 0.0)
        a = at * (a_n / a_t)
        b = at * (b_n / b_t)
        low = max(near, max(a if a_t > 0.0 else -np.inf, -np.inf if b_t > 0.0 else b))
        high = min(far, min(np.inf if a_t > 0.0 else a, b if b_t > 0.0 else np.inf))
        low -= SAFETY * (abs(low) + abs(at))
        high += SAFETY * (abs(high) + abs(at))
        place = low if low > 0.0 else (high if high < 0.0 else 0.0)
        seen = (at != 0.0) & (low <= high) & counts
        inside = (near <= 0.0) & (at == 0.0) & counts
        f[j + np.uint64(_SQUARE + AT_ONCE)] = 0.0 if inside else (at * at + place * place if seen else np.inf)
        f[j + np.uint64(_X + AT_ONCE)] = tx * at + nx * place
        f[j + np.uint64(_Y + AT_ONCE)] = ty * at + ny * place


@part
def _next(bits: Ints, before: Any) -> Any:
    """The key of the nearest side or end in `f` after that of key `before`.

    The bits of numbers that are not negative are in the order of the numbers. The last of a square's make room for
    which it is, so no two keys are the same.
    """
    least: Any = np.int64(_FARTHEST)
    for j in range(2 * AT_ONCE):
        key = (bits[j + _SQUARE] & ~np.int64(2 * AT_ONCE - 1)) | j
        least = min(least, key if key > before else np.int64(_FARTHEST))
    return least


@part
def _touches(walls: Array, m: int, resolution: float, x: float, y: float) -> bool:
    """Whether a point is so near a box that roundings of places count for the bearings of its corners."""
    col = x / resolution
    row = y / resolution
    return bool(max(walls[6, m] - col, col - walls[8, m], walls[7, m] - row, row - walls[9, m]) < _TOUCH)


@part
def _walk(grid: Grid, x: float, y: float, col: int, row: int, dx: float, dy: float, range_max: float) -> float:
    """Distance along a ray from a free cell that it comes to, a few cells before what it meets: cell by cell at first.

    By definition (`amorsim.kernels.raycast.rays`); for so few cells that takes less than to make ready for jumps.
    """
    resolution = grid.resolution
    # From a cell to the line ahead, and to the next cell.
    ahead_x = 1 if dx > 0.0 else 0
    ahead_y = 1 if dy > 0.0 else 0
    step_x = 1 if dx > 0.0 else -1
    step_y = 1 if dy > 0.0 else -1
    tx = ((col + ahead_x) * resolution - x) / dx if dx != 0.0 else np.inf
    ty = ((row + ahead_y) * resolution - y) / dy if dy != 0.0 else np.inf
    block_col = col >> 3
    block_row = row >> 3
    word: Any = word_at(grid, block_row, block_col)
    for _ in range(_STEPS):
        if tx <= ty and dx != 0.0:
            distance = tx
            col += step_x
            tx = ((col + ahead_x) * resolution - x) / dx
        else:
            distance = ty
            row += step_y
            ty = ((row + ahead_y) * resolution - y) / dy if dy != 0.0 else np.inf
        if col >> 3 != block_col or row >> 3 != block_row:
            block_col = col >> 3
            block_row = row >> 3
            word = word_at(grid, block_row, block_col)
        if (word >> np.uint64((row & 7) * 8 + (col & 7))) & ONE:
            return distance + 0.0 if distance <= range_max else np.inf
    return march(grid, x, y, col, row, dx, dy, range_max)


@part
def _cast_from(
    grid: Grid, x: float, y: float, col: int, row: int, dx: float, dy: float, free: float, range_max: float
) -> float:
    """Distance along a ray that is free so far [m] at least, from (x, y) in the free cell (row, col)."""
    inverse = 1.0 / grid.resolution
    place_x = (x + free * dx) * inverse
    place_y = (y + free * dy) * inverse
    start_col = math.floor(place_x)
    start_row = math.floor(place_y)
    part_x = place_x - start_col
    part_y = place_y - start_row
    doubt = 2.0 * rounding(grid, 1.0, 1.0)
    if doubt < part_x < 1.0 - doubt and doubt < part_y < 1.0 - doubt:
        return _walk(grid, x, y, int(start_col), int(start_row), dx, dy, range_max)
    return march(grid, x, y, col, row, dx, dy, range_max)


@part
def _rays_between(
    x0: float, y0: float, x1: float, y1: float, half_angle: float, step: float, rays: int
) -> tuple[int, int]:
    """First and last ray of a cone from one direction anticlockwise to another; the last before the first if none."""
    low = bearing_of(x0, y0)
    high = bearing_of(x1, y1)
    if high < low:
        if high >= -half_angle - step:
            low -= 2.0 * math.pi
        else:
            high += 2.0 * math.pi
    first = max(math.ceil((low + half_angle) / step - NEXT), 0.0)
    last = min(math.floor((high + half_angle) / step + NEXT), rays - 1.0)
    return int(first), int(last)


@part
def _cast_about(
    grid: Grid, walls: Array, m: int, eye: Eye, cone: Cone, range_max: float, least: float, nearest: int, casts: bool
) -> tuple[float, int]:
    """The less of `least` and the distance along the rays that wall `m` bounds nearer, and the number of its ray.

    That of `least` is `nearest`. The distance is less than 0 where rays are needed and none `casts`, or where the point
    may be within what the wall occupies.
    """
    x, y, col, row, cos_h, sin_h = eye
    half_angle, _, cos_b, sin_b = cone
    what, a, b, x0, y0, x1, y1, _, _, _ = side_of(walls, m, x, y, cos_h, sin_h, least * (1.0 + SAFETY))
    if what == PASSED:
        return least, nearest
    if what == INSIDE:
        return -1.0, nearest
    rays = cos_b.shape[1]
    step = 2.0 * half_angle / (rays - 1)
    first, last = _rays_between(x0, y0, x1, y1, half_angle, step, rays)
    if first > last:
        return least, nearest
    # The nearness of the line is a sine over the rays, and less than half of its turn is here.
    best = first
    if a * sin_b[0, first] < b * cos_b[0, first]:
        best = last
        if a * sin_b[0, last] > b * cos_b[0, last]:
            best = min(max(int(np.rint((bearing_of(a, b) + half_angle) / step)), first), last)
    nearness = a * cos_b[0, best] + b * sin_b[0, best]
    if nearness * least * (1.0 + SAFETY) < 1.0:
        return least, nearest
    free = (1.0 - SAFETY) / nearness
    # From the nearest ray outward to either side, as far as the bound stays below what was found.
    for way in (-1, 1):
        k = best + (way + 1) // 2
        while first <= k <= last:
            if (a * cos_b[0, k] + b * sin_b[0, k]) * least * (1.0 + SAFETY) < 1.0:
                break
            if not casts:
                return -1.0, nearest
            dx, dy = direction(cos_h, sin_h, cos_b[0, k], sin_b[0, k])
            distance = _cast_from(grid, x, y, col, row, dx, dy, free, range_max)
            if distance < least or (distance == least and k < nearest):
                least, nearest = distance, k
            k += way
    return least, nearest


@part
def hear_walls(
    grid: Grid,
    lines: SegmentIndex,
    eye: Eye,
    cone: Cone,
    range_max: float,
    room: WallRoom,
    count: int,
    aside: float,
    casts: bool,
) -> tuple[bool, float, int]:
    """The least distance of all rays from a free cell, and the first ray with it; False if walls alone do not decide.

    The room holds `count` walls, found at a place `aside` [m] from here. False also if rays are needed and `casts` is
    not set. Where nothing is in range the ray is number 0.
    """
    x, y, col, row, cos_h, sin_h = eye
    half_angle, edge, cos_b, sin_b = cone
    found, about, away, f, bits = room.found, room.about, room.away, room.f, room.bits
    walls = lines.walls
    step = 2.0 * half_angle / (cos_b.shape[1] - 1)
    # The first distance that is out of range.
    least = np.nextafter(range_max, np.inf)
    right_x = cos_h * edge[0] + sin_h * edge[1]
    right_y = sin_h * edge[0] - cos_h * edge[1]
    left_x = cos_h * edge[0] - sin_h * edge[1]
    left_y = sin_h * edge[0] + cos_h * edge[1]
    nearest = _NO_RAY
    cast = -1
    for chunk in range(0, count, AT_ONCE):
        if away[chunk] - aside > least:
            break
        _bound(about, chunk, count - chunk, x, y, right_x, right_y, left_x, left_y, f)
        key: Any = np.int64(-1)
        while True:
            key = _next(bits, key)
            which = int(key & (2 * AT_ONCE - 1))
            # Nothing is left, or nothing that could be nearer.
            if key >= _NOWHERE or f[_SQUARE + which] > least * least * (1.0 + SAFETY):
                break
            m = found[chunk + (which & (AT_ONCE - 1))]
            if walls[6, m] < walls[8, m]:
                if _touches(walls, m, grid.resolution, x, y):
                    return False, 0.0, 0
                ahead = cos_h * f[_X + which] + sin_h * f[_Y + which]
                aleft = cos_h * f[_Y + which] - sin_h * f[_X + which]
                number = (bearing_of(ahead, aleft) + half_angle) / step
                least, nearest = enter_box(
                    walls, m, col, row, grid.resolution, x, y, cos_h, sin_h, cos_b, sin_b, number, least, nearest
                )
                continue
            if m == cast:
                continue
            cast = m
            distance, nearest = _cast_about(grid, walls, m, eye, cone, range_max, least, nearest, casts)
            if distance < 0.0:
                return False, 0.0, 0
            least = distance
    if least <= range_max:
        return True, least + 0.0, nearest
    return True, np.inf, 0
