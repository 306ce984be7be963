"""Line segments into cells: every cell that the closed line touches, exactly.

Coordinates here are in cells, so that cell (row j, column i) is the closed square [i, i+1] x [j, j+1]. A
segment along a grid line touches the cells on both sides of it, one through a corner touches all four.

Floating care. Metres divided by a resolution miss whole numbers by a rounding or two (0.35 / 0.05 is
6.999999999999999), so end points within `SNAP` of a grid line are put on it, before anything else. From there
on the answer is that of real arithmetic on the snapped end points: where a segment crosses a grid line is
estimated to well within `DOUBT` of a cell, and only if that is too near a whole number to tell is the side of
the grid point taken from the sign of a determinant in doubled precision, as accurate as 100 bits.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from amorsim.array_types import Array
from amorsim.kernels.compile import kernel
from amorsim.kernels.grid.draft import Draft, finish, grow, mark_box, new_draft
from amorsim.kernels.grid.grid import Grid

__all__ = ["MOST_CELLS", "SNAP", "grid_from_segments", "mark_segments", "snapped"]

SNAP = 1e-6
"""An end point this near to a grid line [cells] lies on it."""
DOUBT = 1e-6
"""An estimated crossing this near to a grid point [cells] is decided exactly."""
MOST_CELLS = 2**27
"""Rows or columns up to which the estimates stay within `DOUBT`: four roundings of such a number are 6e-8."""


@kernel
def _two_sum(a: float, b: float) -> Any:
    """`(sum, error)`: the rounded sum, and its rounding error (Knuth 1969)."""
    total = a + b
    part = total - a
    return total, (a - (total - part)) + (b - part)


@kernel
def _two_product(a: float, b: float) -> Any:
    """`(product, error)`: the rounded product, and its rounding error (Dekker 1971)."""
    product = a * b
    wide = 134217729.0 * a
    a_high = wide - (wide - a)
    a_low = a - a_high
    wide = 134217729.0 * b
    b_high = wide - (wide - b)
    b_low = b - b_high
    return product, ((a_high * b_high - product) + a_high * b_low + a_low * b_high) + a_low * b_low


@kernel
def _side(x0: float, y0: float, x1: float, y1: float, x: float, y: float) -> int:
    """Sign of (x1-x0)*(y-y0) - (y1-y0)*(x-x0): 1 where the point is left of it, 0 on its line, -1 right."""
    ax, ax_low = _two_sum(x1, -x0)
    ay, ay_low = _two_sum(y1, -y0)
    bx, bx_low = _two_sum(x, -x0)
    by, by_low = _two_sum(y, -y0)
    first, first_low = _two_product(ax, by)
    second, second_low = _two_product(ay, bx)
    first_low += ax * by_low + ax_low * by
    second_low += ay * bx_low + ay_low * bx
    value, low = _two_sum(first, -second)
    value += low + (first_low - second_low)
    return 1 if value > 0.0 else (-1 if value < 0.0 else 0)


@kernel
def _crossing(x0: float, y0: float, x1: float, y1: float, line: float) -> Any:
    """`(floor, ceil)` of the exact x where a rising segment (y0 < y1) meets the line y = `line`."""
    x = x0 + (line - y0) / (y1 - y0) * (x1 - x0)
    nearest = math.floor(x + 0.5)
    if abs(x - nearest) > DOUBT:
        return math.floor(x), math.ceil(x)
    # A grid point left of a rising segment has the crossing on its right.
    side = _side(x0, y0, x1, y1, nearest, line)
    whole = int(nearest)
    return (whole - 1 if side < 0 else whole), (whole + 1 if side > 0 else whole)


@kernel
def _mark_segment(draft: Draft, x0: float, y0: float, x1: float, y1: float) -> bool:
    """Occupy the cells that one segment touches, row by row; false if the draft has to grow first."""
    if y0 > y1:
        x0, y0, x1, y1 = x1, y1, x0, y0
    # Closed cells: an end point on a grid line touches the row below it, and a crossing on one the column
    # left of it.
    first: int = max(math.ceil(y0) - 1, 0)
    last: int = min(math.floor(y1), draft.rows - 1)
    if y0 == y1 or x0 == x1:  # as most walls go, and all their cells at once
        return mark_box(draft, first, last, math.ceil(min(x0, x1)) - 1, math.floor(max(x0, x1)))
    # Floor and ceiling of x where the segment comes into the row, by its lower line or by its own lower end.
    if first > y0:
        low_floor, low_ceil = _crossing(x0, y0, x1, y1, np.float64(first))
    else:
        low_floor, low_ceil = math.floor(x0), math.ceil(x0)
    for row in range(first, last + 1):
        top = row + 1
        if top < y0 or top == y0:
            high_floor, high_ceil = low_floor, low_ceil
        elif top < y1:
            high_floor, high_ceil = _crossing(x0, y0, x1, y1, np.float64(top))
        else:
            high_floor, high_ceil = math.floor(x1), math.ceil(x1)
        if not mark_box(draft, row, row, min(low_ceil, high_ceil) - 1, max(low_floor, high_floor)):
            return False
        low_floor, low_ceil = high_floor, high_ceil
    return True


@kernel
def mark_segments(segments: Array, start: int, draft: Draft) -> int:
    """Occupy the cells that segments (M, 4) touch, x0 y0 x1 y1 in cells, from number `start` on.

    Returns the number of segments done. If that is less than M the draft is full: grow it, and go on from
    there.
    """
    for m in range(start, segments.shape[0]):
        if not _mark_segment(draft, segments[m, 0], segments[m, 1], segments[m, 2], segments[m, 3]):
            return m
    return len(segments)


def snapped(coordinates: Array) -> Array:
    """The same coordinates [cells], those within `SNAP` of a whole number replaced by it."""
    nearest = np.rint(coordinates)
    return np.where(np.abs(coordinates - nearest) <= SNAP, nearest, coordinates)


def grid_from_segments(
    segments: Array, rows: int, cols: int, resolution: float, offset: tuple[int, int] = (0, 0)
) -> Grid:
    """The grid of rows x cols cells, `resolution` [m] wide, that the closed lines of segments touch.

    Parameters
    ----------
    segments
        (M, 4): x0, y0, x1, y1 [m]. Parts outside the grid are left out.
    rows, cols
        Size of the grid, at most `MOST_CELLS` each.
    offset
        Column and row, counted from the origin of the segments' coordinates, of the grid's lower left cell.
    """
    shift = np.array([offset[0], offset[1], offset[0], offset[1]], dtype=np.float64)
    scaled = snapped(np.asarray(segments, dtype=np.float64).reshape(-1, 4) / resolution)
    scaled = np.ascontiguousarray(scaled - shift)
    draft = new_draft(rows, cols)
    done = mark_segments(scaled, 0, draft)
    while done < len(scaled):
        grow(draft)
        done = mark_segments(scaled, done, draft)
    return finish(draft, resolution)
