"""A cone's nearest return, told by the walls about it.

Where the map has line features, they bound every ray from below (`amorsim.kernels.lines`): the few rays that could be
the nearest by these bounds are cast, from where all are free, and mostly that is one, square to a wall or at its end.
Walls that are boxes of occupied cells need no ray at all (`amorsim.kernels.cone_boxes`).
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from amorsim.kernels.compile import part
from amorsim.kernels.cone_boxes import bearing_of, enter_box, rays_between
from amorsim.kernels.cone_cells import SAFETY
from amorsim.kernels.grid import ONE, Grid, word_at
from amorsim.kernels.lines import FACE, INSIDE, PASSED, Lines, side_of
from amorsim.kernels.rays import direction, march, rounding

__all__ = ["AT_ONCE", "MOST", "hear_walls"]

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

MOST = 64  # walls that a cone may hear
AT_ONCE = 32  # walls that are looked at together
_TOUCH = 1e-3  # [cells]
_STEPS = 12  # cells that a ray walks before it jumps


@part
def _look_along(
    ends: Floats,
    start: int,
    stop: int,
    x: float,
    y: float,
    left_x: float,
    left_y: float,
    right_x: float,
    right_y: float,
    maybe: NDArray[np.uint8],
) -> None:
    """Write whether walls start..stop-1 may be in a cone: not wholly beyond one of its edges.

    `ends` is of `lines.walls_about`; (left_x, left_y) and (right_x, right_y) are square to the edges, outward.
    """
    for i in range(start, stop):
        x0 = ends[0, i] - x
        y0 = ends[1, i] - y
        x1 = ends[2, i] - x
        y1 = ends[3, i] - y
        left = min(left_x * x0 + left_y * y0, left_x * x1 + left_y * y1)
        right = min(right_x * x0 + right_y * y0, right_x * x1 + right_y * y1)
        maybe[i - start] = max(left, right) <= ends[4, i]


@part
def _crosses(a: float, b: float, near: float, start: float, stop: float, margin: float, dx: float, dy: float) -> bool:
    """Whether a ray goes through a wall's rectangle from one long side to the other, so that it must meet the wall."""
    # How far along the wall it gets for each metre across; the wall itself ends short of its rectangle.
    slope = (a * dy - b * dx) / (a * dx + b * dy)
    first = near * slope
    last = (near + 2.0 * margin) * slope
    return bool(min(first, last) > start + 3.0 * margin and max(first, last) < stop - 3.0 * margin)


@part
def _touches(walls: Floats, m: int, resolution: float, x: float, y: float) -> bool:
    """Whether a point is so near a box that roundings of places count for the bearings of its corners."""
    col = x / resolution
    row = y / resolution
    return bool(max(walls[6, m] - col, col - walls[8, m], walls[7, m] - row, row - walls[9, m]) < _TOUCH)


@part
def _walk(grid: Grid, x: float, y: float, col: int, row: int, dx: float, dy: float, range_max: float) -> float:
    """Distance along a ray from a free cell that it comes to, a few cells before what it meets: cell by cell at first.

    By definition (`amorsim.kernels.rays`); for so few cells that takes less than to make ready for jumps.
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
def hear_walls(
    grid: Grid,
    lines: Lines,
    x: float,
    y: float,
    col: int,
    row: int,
    cos_h: float,
    sin_h: float,
    half_angle: float,
    edge: Floats,
    cos_b: Floats,
    sin_b: Floats,
    range_max: float,
    found: Integers,
    ends: Floats,
    away: Floats,
    count: int,
    aside: float,
    casts: int,
    maybe: NDArray[np.uint8],
    walls: Floats,
    spans: Integers,
) -> tuple[bool, float]:
    """The least over all rays, from a free cell, by the walls about it; or False where they cannot tell.

    The first `count` of `found`, `ends` and `away` are of `lines.walls_about`, told from `aside` [m] of here.
    More than so many `casts` are not made: then they cannot tell, either.
    `walls` (most, 3) and `spans` (most, 3) are room for what of them may be heard: the line that bounds rays, and how
    near it comes; first and last ray, and the one to which it is nearest.
    """
    rays = cos_b.shape[1]
    step = 2.0 * half_angle / (rays - 1)
    # Nothing farther than this is heard: out of range, or behind a wall that fills the way.
    most = range_max * (1.0 + SAFETY)
    held = 0
    # The first distance that is out of range.
    least = np.nextafter(range_max, np.inf)
    square = (bearing_of(cos_h, -sin_h) + half_angle) / step
    # Square to the edges, outward.
    left_x = -sin_h * edge[0] - cos_h * edge[1]
    left_y = cos_h * edge[0] - sin_h * edge[1]
    right_x = sin_h * edge[0] - cos_h * edge[1]
    right_y = -cos_h * edge[0] - sin_h * edge[1]
    for chunk in range(0, count, AT_ONCE):
        if away[chunk] - aside > most:
            break
        following = min(count, chunk + AT_ONCE)
        _look_along(ends, chunk, following, x, y, left_x, left_y, right_x, right_y, maybe)
        for i in range(chunk, following):
            if not maybe[i - chunk]:
                continue
            if away[i] - aside > most:
                break
            m = found[i]
            if lines.walls[6, m] < lines.walls[8, m]:
                if _touches(lines.walls, m, grid.resolution, x, y):
                    return False, 0.0
                least = enter_box(
                    lines.walls[6, m],
                    lines.walls[7, m],
                    lines.walls[8, m],
                    lines.walls[9, m],
                    col,
                    row,
                    grid.resolution,
                    x,
                    y,
                    cos_h,
                    sin_h,
                    half_angle,
                    step,
                    square,
                    cos_b,
                    sin_b,
                    least,
                )
                most = min(most, least * (1.0 + SAFETY))
                continue
            what, a, b, x0, y0, x1, y1, near, start, stop = side_of(lines.walls, m, x, y, cos_h, sin_h, most)
            if what == PASSED:
                continue
            if what == INSIDE:
                return False, 0.0
            beside = max(start, -stop, 0.0)
            if near > 0.0 and near * near + beside * beside > most * most:
                continue
            first, last = rays_between(x0, y0, x1, y1, half_angle, step, rays)
            if first > last:
                continue
            # The nearness of the line is a sine over the rays, and less than half of its turn is here.
            best = first
            if a * sin_b[0, first] < b * cos_b[0, first]:
                best = last
                if a * sin_b[0, last] > b * cos_b[0, last]:
                    best = min(max(int(np.rint((bearing_of(a, b) + half_angle) / step)), first), last)
            dx = cos_b[0, best]
            dy = sin_b[0, best]
            nearness = a * dx + b * dy
            if nearness * most < 1.0:
                continue
            if held == walls.shape[0]:
                return False, 0.0
            walls[held, 0] = a
            walls[held, 1] = b
            walls[held, 2] = nearness
            spans[held, 0] = first
            spans[held, 1] = last
            spans[held, 2] = best
            held += 1
            margin = lines.walls[5, m]
            if what == FACE and _crosses(a, b, near, start, stop, margin, dx, dy):
                most = min(most, (1.0 + 2.0 * margin / near) / nearness * (1.0 + SAFETY))
    for _ in range(held):
        nearest = 0
        for i in range(1, held):
            if walls[i, 2] > walls[nearest, 2]:
                nearest = i
        a = walls[nearest, 0]
        b = walls[nearest, 1]
        nearness = walls[nearest, 2]
        if nearness * least * (1.0 + SAFETY) < 1.0:
            break
        free = (1.0 - SAFETY) / nearness
        # From the nearest ray outward to either side, as far as the bound stays below what was found.
        for way in (-1, 1):
            k = spans[nearest, 2] + (way + 1) // 2
            while spans[nearest, 0] <= k <= spans[nearest, 1]:
                if (a * cos_b[0, k] + b * sin_b[0, k]) * least * (1.0 + SAFETY) < 1.0:
                    break
                if casts == 0:
                    return False, 0.0
                casts -= 1
                dx, dy = direction(cos_h, sin_h, cos_b[0, k], sin_b[0, k])
                least = min(least, _cast_from(grid, x, y, col, row, dx, dy, free, range_max))
                k += way
        walls[nearest, 2] = -np.inf
    return True, least + 0.0 if least <= range_max else np.inf
