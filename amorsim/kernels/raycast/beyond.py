"""Beams whose ends matter only if they are far away: most of them need not be cast.

A wall that is a box of occupied cells (`amorsim.kernels.grid.solids`) is certain to end a beam that enters it. So a few
quotients for each box near by tell most beams that end too soon; only the others are cast.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from amorsim.array_types import Array, Ints, Ints32
from amorsim.kernels.compile import kernel, part
from amorsim.kernels.grid.grid import Grid, is_occupied
from amorsim.kernels.grid.segments import RINGS, SAFETY, SegmentIndex, walls_about
from amorsim.kernels.raycast.rays import cell_of, direction, march, to_frame

__all__ = ["cast_beyond"]


_REACH = 10.0  # [m] of the search for boxes; those farther away end few beams that nearer ones do not
_NEARBY = 1.0  # [m] added to that search around one place, to serve the places near it
_AT_ONCE = 32  # boxes that are tested together


class _Room(NamedTuple):
    """Arrays to work in, for M walls and k beams: those of `walls_about`, then what is known of boxes and beams."""

    found: Ints  # (M,)
    about: Array  # (6, M)
    away: Array  # (M,) how far [m] each box is at least, the nearest first
    candidates: Ints  # (M,)
    rings: Ints  # (RINGS + 2,)
    boxes: Array  # (4, M + _AT_ONCE) x and y where boxes begin, and where they end [m]
    aside: Array  # (_AT_ONCE,) above 0 of boxes that no beam meets
    ahead: Array  # (2, k) the beams' directions
    slopes: Array  # (2, k) one over them
    left: Array  # (k,) 1 of beams that may end farther away, or else 0


@part
def _boxes_about(lines: SegmentIndex, resolution: float, x: float, y: float, reach: float, room: _Room) -> int:
    """The number of boxes within reach of a place, after they were written."""
    walls, boxes = lines.walls, room.boxes
    there = walls_about(lines, x, y, reach, room.found, room.about, room.away, room.candidates, room.rings)
    count = 0
    for i in range(there):
        m = room.found[i]
        if walls[6, m] < walls[8, m]:
            for side in range(4):
                boxes[side, count] = walls[6 + side, m] * resolution
            room.away[count] = room.away[i]
            count += 1
    return count


@part
def _aim(cos_h: float, sin_h: float, cos_b: Array, sin_b: Array, nearest: Array, room: _Room) -> float:
    """Write the directions of beams, and which are left; returns the greatest of their `nearest`, -inf if none is."""
    farthest = -math.inf
    for k in range(room.left.shape[0]):
        dx, dy = direction(cos_h, sin_h, cos_b[k], sin_b[k])
        room.ahead[0, k], room.ahead[1, k] = dx, dy
        room.slopes[0, k], room.slopes[1, k] = 1.0 / dx, 1.0 / dy
        room.left[k] = 1.0 if nearest[k] < math.inf else 0.0
    for k in range(room.left.shape[0]):
        farthest = max(farthest, nearest[k] if nearest[k] < math.inf else -math.inf)
    return farthest


@part
def _set_aside(
    boxes: Array, first: int, x: float, y: float, cos_h: float, sin_h: float, low: float, high: float, aside: Array
) -> None:
    """Write above 0 for the boxes from number `first` on that are beside the cone of beams between two sines."""
    right, left = math.sqrt(max(1.0 - low * low, 0.0)), math.sqrt(max(1.0 - high * high, 0.0))
    # The normals of its edges, outward.
    right_x, right_y = cos_h * low + sin_h * right, sin_h * low - cos_h * right
    left_x, left_y = -cos_h * high - sin_h * left, -sin_h * high + cos_h * left
    for j in range(_AT_ONCE):
        i = np.uint64(j) + np.uint64(first)
        x0, y0, x1, y1 = boxes[0, i] - x, boxes[1, i] - y, boxes[2, i] - x, boxes[3, i] - y
        one = min(right_x * x0, right_x * x1) + min(right_y * y0, right_y * y1)
        other = min(left_x * x0, left_x * x1) + min(left_y * y0, left_y * y1)
        aside[j] = max(one, other)


@part
def _end_beams(
    x0: float, y0: float, x1: float, y1: float, begin: int, end: int, slopes: Array, nearest: Array, left: Array
) -> None:
    """Set `left` to 0 of beams begin..end-1 that enter a box nearer than `nearest`; corners count from their origin.

    What only touches the box, or is nan, does not enter it.
    """
    least = SAFETY * (abs(x0) + abs(x1) + abs(y0) + abs(y1))
    for k in range(np.uint64(begin), np.uint64(end)):
        one_x, other_x = x0 * slopes[0, k], x1 * slopes[0, k]
        one_y, other_y = y0 * slopes[1, k], y1 * slopes[1, k]
        into = max(min(one_x, other_x), min(one_y, other_y)) + least
        out_of = min(max(one_x, other_x), max(one_y, other_y))
        left[k] = 0.0 if (into < out_of) & (into < nearest[k]) & (out_of > least) else left[k]


@part
def _trimmed(begin: int, end: int, left: Array) -> tuple[int, int]:
    """Of the beams from `begin` to `end` - 1, those from the first that is left to the last."""
    while begin < end and left[begin] == 0.0:
        begin += 1
    while begin < end and left[end - 1] == 0.0:
        end -= 1
    return begin, end


@part
def _end_near(
    x: float,
    y: float,
    cos_h: float,
    sin_h: float,
    sin_b: Array,
    nearest: Array,
    farthest: float,
    count: int,
    around: float,
    room: _Room,
) -> None:
    """Leave of the beams those that enter none of `count` boxes nearer than `nearest`.

    The boxes are those about a place `around` [m] from here; none farther away than `farthest` matters.
    """
    boxes, left = room.boxes, room.left
    begin, end = _trimmed(0, left.shape[0], left)
    for first in range(0, count, _AT_ONCE):
        if begin == end or room.away[first] - around > farthest:
            return
        # Of beams in another order, some that enter a box are not tested, and are cast.
        _set_aside(boxes, first, x, y, cos_h, sin_h, sin_b[begin], sin_b[end - 1], room.aside)
        for i in range(first, min(first + _AT_ONCE, count)):
            if room.aside[i - first] > 0.0:
                continue
            x0, y0, x1, y1 = boxes[0, i] - x, boxes[1, i] - y, boxes[2, i] - x, boxes[3, i] - y
            _end_beams(x0, y0, x1, y1, begin, end, room.slopes, nearest, left)
            begin, end = _trimmed(begin, end, left)
            if begin == end:
                return


@kernel
def cast_beyond(
    resolution: float,
    rows: int,
    cols: int,
    super_cols: int,
    supers: Ints32,
    tables: Ints32,
    pages: NDArray[np.uint64],
    free_room: NDArray[np.uint16],
    boxes: Array,
    first: Ints,
    walls: Array,
    origin_x: float,
    origin_y: float,
    yaw: float,
    poses: Array,
    cos_b: Array,
    sin_b: Array,
    nearest: Array,
    range_max: Array,
    out: Array,
) -> None:
    """Write what `amorsim.kernels.raycast.rays.cast` does, but 0 for beams that are sure to end nearer than `nearest`.

    The map is that of `amorsim.kernels.raycast.scans.cast_scans`; `range_max` is (N,) [m], and `nearest` is (N, k) [m],
    inf for beams that need no range. Fewest are cast if they are in order, and within a quarter turn of the heading.
    """
    grid = Grid(resolution, rows, cols, super_cols, supers, tables, pages, free_room)
    lines = SegmentIndex(boxes, first, walls)
    count, beams = walls.shape[1], cos_b.shape[1]
    room = _Room(
        np.empty(count, dtype=np.int64),
        np.empty((6, count)),
        np.empty(count),
        np.empty(count, dtype=np.int64),
        np.empty(RINGS + 2, dtype=np.int64),
        np.empty((4, count + _AT_ONCE)),
        np.empty(_AT_ONCE),
        np.empty((2, beams)),
        np.empty((2, beams)),
        np.empty(beams),
    )
    cos_yaw, sin_yaw = math.cos(yaw), math.sin(yaw)
    # Where boxes were looked for, and how many there are.
    here_x, here_y, there = math.inf, math.inf, 0
    for n in range(poses.shape[0]):
        if range_max[n] < 0.0:
            out[n] = np.inf
            continue
        x, y = to_frame(poses[n, 0], poses[n, 1], origin_x, origin_y, cos_yaw, sin_yaw)
        heading, b = poses[n, 2] - yaw, n if cos_b.shape[0] > 1 else 0
        cos_h, sin_h = math.cos(heading), math.sin(heading)
        is_nan = x != x or y != y or cos_h != cos_h
        inside = 0.0 <= x < grid.cols * resolution and 0.0 <= y < grid.rows * resolution
        col, row = (cell_of(x, resolution), cell_of(y, resolution)) if inside else (-1, -1)
        if is_nan or is_occupied(grid, row, col):
            out[n] = np.nan if is_nan else 0.0
            continue
        farthest = _aim(cos_h, sin_h, cos_b[b], sin_b[b], nearest[n], room)
        if farthest > 0.0:
            around = math.sqrt((x - here_x) * (x - here_x) + (y - here_y) * (y - here_y))
            if not around <= _NEARBY:
                here_x, here_y, around = x, y, 0.0
                there = _boxes_about(lines, resolution, x, y, _REACH + _NEARBY, room)
            _end_near(x, y, cos_h, sin_h, sin_b[b], nearest[n], farthest, there, around, room)
        for k in range(beams):
            dx, dy = room.ahead[0, k], room.ahead[1, k]
            if dx != dx or dy != dy:
                out[n, k] = np.nan
            elif room.left[k] > 0.0:
                out[n, k] = march(grid, x, y, col, row, dx, dy, range_max[n])
            else:
                out[n, k] = 0.0
