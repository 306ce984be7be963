"""The gap between a body and the occupied cells of a grid.

Interiors of a convex part and of a cell are disjoint if a side of either has all of the other on its outer
side, in double precision as evaluated here, in the map's frame. Every operation of that test is monotone in
the cell's sides, rounding included, so a box that holds several cells is never found farther away than one of
them: whole pages, words and runs of cells can be ruled out without changing a bit of the result.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from amorsim.array_types import Array, Ints
from amorsim.kernels.collision.footprints import Bodies, most_vertices, place_body, rounding_slack
from amorsim.kernels.collision.part_and_box import Box, part_bounds, part_distance, part_separation
from amorsim.kernels.compile import kernel
from amorsim.kernels.grid.grid import Grid, box_is_free

__all__ = ["has_room", "map_gap", "map_gaps"]


FIRST_LOOK = 64.0
"""Radius [cells] of the first search around a body; each later one goes four times as far."""


@kernel
def _try_word(
    word: Any,
    row: int,
    col: int,
    resolution: float,
    edges: Array,
    first: int,
    last: int,
    bounds: Box,
    overlap: float,
    nearest: Array,
) -> None:
    """Lower `nearest` (distance, x, y) to that of the occupied cells of a word that begins at (row, col).

    Stops at the first cell that is nearer than `overlap` [m].
    """
    low = 0
    while (word >> np.uint64(8 * low)) & np.uint64(255) == np.uint64(0):
        low += 1
    high = 7
    while (word >> np.uint64(8 * high)) & np.uint64(255) == np.uint64(0):
        high -= 1
    fold = word | (word >> np.uint64(32))
    fold |= fold >> np.uint64(16)
    fold |= fold >> np.uint64(8)
    columns = np.int64(fold & np.uint64(255))
    left = 0
    while (columns >> left) & 1 == 0:
        left += 1
    right = 7
    while (columns >> right) & 1 == 0:
        right -= 1
    tight = (
        (col + left) * resolution,
        (row + low) * resolution,
        (col + right + 1) * resolution,
        (row + high + 1) * resolution,
    )
    if part_separation(edges, first, last, bounds, tight, nearest[0]) >= nearest[0]:
        return
    for i in range(low, high + 1):
        bits = np.int64((word >> np.uint64(8 * i)) & np.uint64(255))
        start = left
        while (bits >> start) != 0:
            while (bits >> start) & 1 == 0:
                start += 1
            stop = start + 1
            while (bits >> stop) & 1 == 1:
                stop += 1
            run = (
                (col + start) * resolution,
                (row + i) * resolution,
                (col + stop) * resolution,
                (row + i + 1) * resolution,
            )
            start = stop
            apart = part_separation(edges, first, last, bounds, run, nearest[0])
            if apart >= nearest[0]:
                continue
            if apart >= 0.0:
                distance, x, y = part_distance(edges, first, last, run)
                apart = max(apart, distance)
                if apart >= nearest[0]:
                    continue
            else:
                x = 0.5 * (max(run[0], bounds[0]) + min(run[2], bounds[2]))
                y = 0.5 * (max(run[1], bounds[1]) + min(run[3], bounds[3]))
            nearest[0] = apart
            nearest[1] = x
            nearest[2] = y
            if apart < overlap:
                return


@kernel
def _try_cells(
    grid: Grid,
    cells: tuple[int, int, int, int],
    edges: Array,
    first: int,
    last: int,
    overlap: float,
    nearest: Array,
) -> None:
    """Lower `nearest` as `_try_word` does, for one part and all words of a box of cells inside the map."""
    row0, col0, row1, col1 = cells
    bounds = part_bounds(edges, first, last)
    word_side = 8.0 * grid.resolution
    for page_row in range(row0 >> 6, (row1 >> 6) + 1):
        for page_col in range(col0 >> 6, (col1 >> 6) + 1):
            table = grid.supers[(page_row >> 6) * grid.super_cols + (page_col >> 6)]
            if table < 0:
                continue
            page = grid.tables[table, (page_row & 63) * 64 + (page_col & 63)]
            if page < 0:
                continue
            word_row0 = max(row0 >> 3, page_row * 8)
            word_row1 = min(row1 >> 3, page_row * 8 + 7)
            word_col0 = max(col0 >> 3, page_col * 8)
            word_col1 = min(col1 >> 3, page_col * 8 + 7)
            # Multiples of eight times the resolution are the cells' own sides to the bit: eight is a power of
            # two.
            box = (
                word_col0 * word_side,
                word_row0 * word_side,
                (word_col1 + 1) * word_side,
                (word_row1 + 1) * word_side,
            )
            if part_separation(edges, first, last, bounds, box, nearest[0]) >= nearest[0]:
                continue
            for word_row in range(word_row0, word_row1 + 1):
                for word_col in range(word_col0, word_col1 + 1):
                    word = grid.pages[page, (word_row & 7) * 8 + (word_col & 7)]
                    if word == np.uint64(0):
                        continue
                    _try_word(
                        word,
                        word_row * 8,
                        word_col * 8,
                        grid.resolution,
                        edges,
                        first,
                        last,
                        bounds,
                        overlap,
                        nearest,
                    )
                    if nearest[0] < overlap:
                        return


@kernel
def _try_outside(grid: Grid, edges: Array, rows: int, nearest: Array) -> None:
    """Lower `nearest` to the distance of vertices 0 to `rows` - 1 to outside the map, negative there."""
    width = grid.cols * grid.resolution
    height = grid.rows * grid.resolution
    for i in range(rows):
        x = edges[i, 0]
        y = edges[i, 1]
        inside = min(min(x, width - x), min(y, height - y))
        if inside < nearest[0]:
            nearest[0] = inside
            # The side that is nearest, or that the vertex is farthest beyond.
            nearest[1] = min(max(x, 0.0), width)
            nearest[2] = min(max(y, 0.0), height)
            if inside == x:
                nearest[1] = 0.0
            elif inside == width - x:
                nearest[1] = width
            elif inside == y:
                nearest[2] = 0.0
            else:
                nearest[2] = height


@kernel
def _cell(place: float, resolution: float, beyond: int, limit: int) -> int:
    """The row or column `beyond` (0 to `limit` - 1) that of a `place` [m], kept within the map."""
    return int(min(max(np.floor(place / resolution) + beyond, 0.0), limit - 1.0))


@kernel
def _in_map(origin_x: float, origin_y: float, yaw: float, reach: float, pose: Array) -> tuple[float, float, float]:
    """Where a body at `pose` (3,) is in the map's frame (x, y), and the slack [m] for the rounding of its gaps."""
    cos = math.cos(yaw)
    sin = math.sin(yaw)
    dx = pose[0] - origin_x
    dy = pose[1] - origin_y
    # Twice, as a body that moves by the gap asks again; and the pose itself is rounded far from the world's
    # origin.
    slack = rounding_slack(2.0 * (abs(dx) + abs(dy) + reach) + 0.5 * (abs(pose[0]) + abs(pose[1])))
    return cos * dx + sin * dy, cos * dy - sin * dx, slack


@kernel
def _circle_is_free(grid: Grid, x: float, y: float, radius: float) -> bool:
    """Whether the square around a circle in the map's frame is inside the map and free of walls."""
    row0 = np.floor((y - radius) / grid.resolution) - 1.0
    col0 = np.floor((x - radius) / grid.resolution) - 1.0
    row1 = np.floor((y + radius) / grid.resolution) + 1.0
    col1 = np.floor((x + radius) / grid.resolution) + 1.0
    inside = row0 >= 0.0 and col0 >= 0.0 and row1 < grid.rows and col1 < grid.cols
    return inside and box_is_free(grid, int(row0), int(col0), int(row1), int(col1))


@kernel
def has_room(grid: Grid, origin_x: float, origin_y: float, yaw: float, reach: float, pose: Array, room: float) -> bool:
    """Whether the square around the circle of a body at `pose` (3,) is free of walls for another `room` [m].

    If so, its gap to the walls is `room` or more; if not, it may still be.
    """
    x, y, slack = _in_map(origin_x, origin_y, yaw, reach, pose)
    return _circle_is_free(grid, x, y, reach + (room + slack))


@kernel
def map_gap(
    grid: Grid,
    origin_x: float,
    origin_y: float,
    yaw: float,
    bodies: Bodies,
    body: int,
    pose: Array,
    cap: float,
    edges: Array,
    nearest: Array,
) -> None:
    """Write the signed gap [m] of `body` at `pose` (3,), and where, to `nearest` (3,), as in `map_gaps`.

    `edges` is scratch, (rows, 5) with `most_vertices` rows at least.
    """
    nearest[0] = math.nan
    nearest[1] = math.nan
    nearest[2] = math.nan
    reach = bodies.reach[body]
    if not abs(pose[0]) + abs(pose[1]) + abs(pose[2]) < math.inf:
        return
    cos = math.cos(yaw)
    sin = math.sin(yaw)
    x, y, slack = _in_map(origin_x, origin_y, yaw, reach, pose)
    heading = pose[2] - yaw
    resolution = grid.resolution

    # Most bodies are in the open: their circle settles it without placing a vertex.
    if _circle_is_free(grid, x, y, reach + (cap + slack)):
        nearest[0] = cap
        return

    place_body(bodies, body, x, y, math.cos(heading), math.sin(heading), edges)
    # Distances are those of the parts before rounding until the end, so that no comparison is itself rounded.
    radius = bodies.radius[body]
    nearest[0] = radius + (cap + slack)
    base = bodies.vertex_first[bodies.part_first[body]]
    rows = bodies.vertex_first[bodies.part_first[body + 1]] - base
    _try_outside(grid, edges, rows, nearest)
    low_x, low_y, high_x, high_y = part_bounds(edges, 0, rows)
    look = radius + FIRST_LOOK * resolution
    while nearest[0] >= radius:
        # A cell more on each side than the numbers say, as they are rounded.
        around = min(look, nearest[0])
        cells = (
            _cell(low_y - around, resolution, -1, grid.rows),
            _cell(low_x - around, resolution, -1, grid.cols),
            _cell(high_y + around, resolution, 1, grid.rows),
            _cell(high_x + around, resolution, 1, grid.cols),
        )
        if not box_is_free(grid, cells[0], cells[1], cells[2], cells[3]):
            for part in range(bodies.part_first[body], bodies.part_first[body + 1]):
                first = bodies.vertex_first[part] - base
                last = bodies.vertex_first[part + 1] - base
                _try_cells(grid, cells, edges, first, last, radius, nearest)
                if nearest[0] < radius:
                    break
        if nearest[0] <= look:
            break
        look *= 4.0

    near_x = nearest[1]
    near_y = nearest[2]
    if math.isnan(near_x):
        nearest[0] = cap
        return
    nearest[1] = origin_x + (cos * near_x - sin * near_y)
    nearest[2] = origin_y + (sin * near_x + cos * near_y)
    gap = nearest[0] - radius
    nearest[0] = gap if gap < 0.0 else max(0.0, min(cap, gap - slack))


@kernel
def map_gaps(
    grid: Grid,
    origin_x: float,
    origin_y: float,
    yaw: float,
    bodies: Bodies,
    body: Ints,
    poses: Array,
    cap: Array,
    out: Array,
    where: Array,
) -> None:
    """Write the signed gap [m] between each body and the nearest occupied cell, no more than `cap`.

    A gap of 0 or more: no interior of a cell, nor the outside of the map, overlaps the body's, and the gap is
    the Euclidean distance less what rounding may have added to it (about 4e-15 of the coordinates), so the
    body may move so far without overlap. A negative gap: interiors overlap; its size is no measure of how
    much. Touching gives 0, and a pose that is not finite gives nan.

    Parameters
    ----------
    grid
        The cells.
    origin_x, origin_y, yaw
        Pose of the lower left corner of cell (0, 0) in the world [m, m, rad].
    bodies
        The footprints.
    body
        The body of each query, int64 (Q,).
    poses
        Its pose: x [m], y [m], heading [rad] in the world, (Q, 3).
    cap
        Larger gaps are not distinguished [m], 0 or more, may be inf, (Q,).
    out
        The gaps [m], (Q,).
    where
        A point in the world [m] of the nearest cell, or of one that overlaps; nan where there is none within
        the cap, (Q, 2).
    """
    edges = np.empty((most_vertices(bodies, body), 5))
    nearest = np.empty(3)
    for q in range(out.shape[0]):
        map_gap(grid, origin_x, origin_y, yaw, bodies, body[q], poses[q], cap[q], edges, nearest)
        out[q] = nearest[0]
        where[q, 0] = nearest[1]
        where[q, 1] = nearest[2]
