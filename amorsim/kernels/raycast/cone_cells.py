"""A cone's nearest return, from cells rather than rays.

The least distance over all rays is the least over all pairs of a ray and an occupied cell it enters, so the cells can
be tested instead of the rays. A few rays bound the distance of the nearest wall; then only occupied cells nearer than
that count. There are few: a wall hit at a right angle leaves a sliver of them, and an oblique wall is nearest at an
edge of the cone, whose ray is among the few. The test of a ray and a cell, and the distance, use the same quotients as
walking along the ray, so the result has the same bits.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from amorsim.array_types import Array
from amorsim.kernels.compile import part
from amorsim.kernels.grid.grid import NONE, ONE, Grid
from amorsim.kernels.raycast.rays import cast_ray, cell_of, direction

__all__ = ["SAFETY", "WIDEST", "ask_cells"]


WIDEST = 1.5  # [rad] half a cone's angle; wider ones are cast ray by ray
SAFETY = 1e-9  # relative, on every bound that leaves something out
_COARSE = 100  # one ray in this many is cast


@part
def _entry(cell: int, own: int, resolution: float, start: float, component: float) -> float:
    """The distance at which a ray from cell `own` of an axis enters `cell`: -inf if it is there, inf if never."""
    if cell == own:
        return -np.inf
    if (component > 0.0) != (cell > own) or component == 0.0:
        return np.inf
    line = cell if cell > own else cell + 1
    return (line * resolution - start) / component


@part
def _exit(cell: int, resolution: float, start: float, component: float) -> float:
    """The distance at which a ray leaves `cell` of an axis for the last time."""
    if component == 0.0:
        return np.inf
    line = cell + 1 if component > 0.0 else cell
    return (line * resolution - start) / component


@part
def _least_into(
    row: int,
    col: int,
    own_row: int,
    own_col: int,
    resolution: float,
    x: float,
    y: float,
    cos_h: float,
    sin_h: float,
    half_angle: float,
    cos_b: Array,
    sin_b: Array,
    least: float,
) -> float:
    """The less of `least` and the distance at which any ray of the cone enters a cell."""
    rays = cos_b.shape[1]
    away_x = (col + 0.5) * resolution - x
    away_y = (row + 0.5) * resolution - y
    distance = math.sqrt(away_x * away_x + away_y * away_y)
    corner = 0.7072 * resolution  # from the middle of a cell, and a little
    first, last = 0, rays - 1
    if distance > 1.001 * corner:
        spread = math.asin(corner / distance)
        bearing = math.atan2(cos_h * away_y - sin_h * away_x, cos_h * away_x + sin_h * away_y)
        step = 2.0 * half_angle / (rays - 1)
        first = max(first, math.ceil((bearing - spread + half_angle) / step - 1e-3))
        last = min(last, math.floor((bearing + spread + half_angle) / step + 1e-3))
    for k in range(first, last + 1):
        dx, dy = direction(cos_h, sin_h, cos_b[0, k], sin_b[0, k])
        into_x = _entry(col, own_col, resolution, x, dx)
        into_y = _entry(row, own_row, resolution, y, dy)
        # It gets into the cell if neither axis leaves it before the other is in; where both happen at once, x is first.
        into = max(into_x, into_y)
        if into < least and into_x <= _exit(row, resolution, y, dy) and into_y < _exit(col, resolution, x, dx):
            least = into
    return least


@part
def _is_near(x0: float, y0: float, side: float, cos_h: float, sin_h: float, edge: Array, least: float) -> bool:
    """Whether a square, its lower left corner at (x0, y0) from the cone's point, may hold something nearer in the cone.

    `edge` holds cosine and sine of half the cone's angle.
    """
    near_x = max(x0, 0.0, -(x0 + side))
    near_y = max(y0, 0.0, -(y0 + side))
    # Where the cone's point all but touches something, roundings of places count too.
    within = least + SAFETY * side
    if near_x * near_x + near_y * near_y > within * within * (1.0 + SAFETY):
        return False
    middle_x = x0 + 0.5 * side
    middle_y = y0 + 0.5 * side
    ahead = cos_h * middle_x + sin_h * middle_y
    left = cos_h * middle_y - sin_h * middle_x
    outside = abs(left) * edge[0] - ahead * edge[1]
    return bool(outside <= 0.7072 * side + SAFETY * (abs(ahead) + abs(left)))


@part
def _nearest(
    grid: Grid,
    x: float,
    y: float,
    cos_h: float,
    sin_h: float,
    half_angle: float,
    edge: Array,
    cos_b: Array,
    sin_b: Array,
    least: float,
) -> float:
    """The less of `least` and the distance to anything else in the cone, page by page, word by word, cell by cell."""
    resolution = grid.resolution
    own_row = cell_of(y, resolution)
    own_col = cell_of(x, resolution)
    # The box of the cone's sector: its point, the ends of its edges, and where its arc is farthest along an axis.
    low_x, high_x, low_y, high_y = 0.0, 0.0, 0.0, 0.0
    for side in (-1.0, 1.0):
        end_x = least * (cos_h * edge[0] - side * sin_h * edge[1])
        end_y = least * (sin_h * edge[0] + side * cos_h * edge[1])
        low_x, high_x = min(low_x, end_x), max(high_x, end_x)
        low_y, high_y = min(low_y, end_y), max(high_y, end_y)
    if cos_h >= edge[0]:
        high_x = least
    if -cos_h >= edge[0]:
        low_x = -least
    if sin_h >= edge[0]:
        high_y = least
    if -sin_h >= edge[0]:
        low_y = -least
    page = 64.0 * resolution
    word = 8.0 * resolution
    first_col = math.floor((x + low_x) / page - 1e-6)
    last_col = math.floor((x + high_x) / page + 1e-6)
    first_row = math.floor((y + low_y) / page - 1e-6)
    last_row = math.floor((y + high_y) / page + 1e-6)
    for page_row in range(first_row, last_row + 1):
        page_col = first_col - 1
        skip: Any = 1
        while page_col + skip <= last_col:
            page_col += skip
            skip = 1
            held: Any = 0  # wholly occupied, as outside the map
            if page_row >= 0 and page_col >= 0 and page_row * 64 < grid.rows and page_col * 64 < grid.cols:
                # What is free says how far it is free to the right, in its own units.
                table: Any = grid.supers[(page_row >> 6) * grid.super_cols + (page_col >> 6)]
                if table < 0:
                    skip = max(1, ((page_col >> 6) + np.int64(table & 127)) * 64 - page_col)
                    continue
                held = grid.tables[table, (page_row & 63) * 64 + (page_col & 63)]
                if held < 0:
                    skip = max(1, np.int64(held & 127))
                    continue
            if not _is_near(page_col * page - x, page_row * page - y, page, cos_h, sin_h, edge, least):
                continue
            for block_row in range(8 * page_row, 8 * page_row + 8):
                for block_col in range(8 * page_col, 8 * page_col + 8):
                    bits = grid.pages[held, (block_row & 7) * 8 + (block_col & 7)]
                    if bits == NONE or not _is_near(
                        block_col * word - x, block_row * word - y, word, cos_h, sin_h, edge, least
                    ):
                        continue
                    for bit in range(64):
                        if not (bits >> np.uint64(bit)) & ONE:
                            continue
                        row = 8 * block_row + (bit >> 3)
                        col = 8 * block_col + (bit & 7)
                        if _is_near(col * resolution - x, row * resolution - y, resolution, cos_h, sin_h, edge, least):
                            least = _least_into(
                                row,
                                col,
                                own_row,
                                own_col,
                                resolution,
                                x,
                                y,
                                cos_h,
                                sin_h,
                                half_angle,
                                cos_b,
                                sin_b,
                                least,
                            )
    return least


@part
def ask_cells(
    grid: Grid,
    x: float,
    y: float,
    cos_h: float,
    sin_h: float,
    half_angle: float,
    edge: Array,
    cos_b: Array,
    sin_b: Array,
    range_max: float,
) -> float:
    """The least over all rays by a few of them, and then by cells; by all rays where cones are wide."""
    rays = cos_b.shape[1]
    stride = _COARSE if half_angle < WIDEST and rays > 2 else 1
    least = np.inf
    limit = range_max
    for k in range(0, rays - 1 + stride, stride):
        beam = min(k, rays - 1)
        dx, dy = direction(cos_h, sin_h, cos_b[0, beam], sin_b[0, beam])
        found = cast_ray(grid, x, y, dx, dy, limit)
        if not found >= least:  # less, or nan
            least = found
            limit = found
    if stride > 1 and least > 0.0:
        # With no wall on any of the few rays the range is the bound, and what is just there still counts.
        bound = least if least <= limit else np.nextafter(limit, np.inf)
        nearest = _nearest(grid, x, y, cos_h, sin_h, half_angle, edge, cos_b, sin_b, bound)
        if nearest <= limit:
            least = nearest
    return least
