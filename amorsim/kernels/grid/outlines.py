"""Outlines of occupied cells as segments, so that a bitmap has walls to look up as a map of lines has.

A ray that comes from a free cell enters an occupied one by a side that the two share. So the sides between free and
occupied cells are all that it can meet first. They are followed round what is occupied, free cells on the left hand,
in straight runs, and neighbouring runs are taken together as long as some line passes them all within a tolerance:
the wedge of directions of such lines, as seen from the first corner, narrows from corner to corner. What is taken
together lies in a narrow strip along a segment, such as `amorsim.kernels.grid.segments` looks up. Walls along the axes
become one strip each, of just their cells, and staircases of oblique walls a few.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from amorsim.array_types import Array
from amorsim.kernels.compile import kernel
from amorsim.kernels.grid.grid import NONE, ONE, Grid, word_at
from amorsim.kernels.grid.segment_boxes import index_segments
from amorsim.kernels.grid.segments import SegmentIndex

__all__ = ["MOST_STRIPS", "outline_lines", "strips_of", "trace"]

MOST_STRIPS = 2_500_000
"""Of a map: looking them up takes 0.4 kB each, so 1 GB in all."""

Cells = NDArray[np.uint8]

_TOLERANCE = 1.6  # [cells] a corner may be off the line; more than 1, so that a thin wall is one strip
_MOST_CORNERS = 1024  # of one strip
_USUAL_STRIPS = 65_536  # of a map; where there are more, all are traced again
_MARGIN = 1e-3  # [cells] by which a strip is wider than the sides in it, for roundings
_EXACT = 0.02  # [cells] by which one along an axis may be wider than another, and is still to be preferred
_THIN_MARGIN = 1e-6  # [cells] the same for one along an axis, whose corners are whole numbers


@kernel
def _is_taken(cells: Cells, row: int, col: int) -> bool:
    if row < 0 or col < 0 or row >= cells.shape[0] or col >= cells.shape[1]:
        return True
    return bool(cells[row, col] != 0)


@kernel
def _run(cells: Cells, seen: Cells, x: int, y: int, heading: int) -> Any:
    """`(x, y, heading, is_inside)` after following sides straight on from a corner, as far as they go.

    `heading` counts quarter turns. The occupied cell of a side is on its right; the run ends where that changes from
    inside the map to outside. Sides along which `heading` is 0 are marked in `seen`, by their free cell.
    """
    step_x = 1 if heading == 0 else (-1 if heading == 2 else 0)
    step_y = 1 if heading == 1 else (-1 if heading == 3 else 0)
    # From a corner to the cells left and right of the side ahead.
    left_row = 0 if heading < 2 else -1
    left_col = 0 if heading == 0 or heading == 3 else -1
    right_row = 0 if heading == 1 or heading == 2 else -1
    right_col = 0 if heading < 2 else -1
    rows, cols = cells.shape
    row, col = y + right_row, x + right_col
    is_inside = 0 <= row < rows and 0 <= col < cols
    while True:
        if heading == 0:
            seen[y, x] = 1
        x += step_x
        y += step_y
        if _is_taken(cells, y + left_row, x + left_col):
            return x, y, (heading + 1) & 3, is_inside
        row, col = y + right_row, x + right_col
        if not _is_taken(cells, row, col):
            return x, y, (heading + 3) & 3, is_inside
        if (0 <= row < rows and 0 <= col < cols) != is_inside:
            return x, y, heading, is_inside


@kernel
def _narrow(x: float, y: float, wedge: Array) -> bool:
    """Keep in a wedge the lines through (0, 0) that pass (x, y) within the tolerance; false, unchanged, if none.

    `wedge` holds the unit vectors of its right and its left side, 0 where all lines are in it.
    """
    square = x * x + y * y
    if square <= _TOLERANCE * _TOLERANCE:
        return True
    # A line has no sense: turn the vector into the wedge's half plane.
    if x * (wedge[0] + wedge[2]) + y * (wedge[1] + wedge[3]) < 0.0:
        x, y = -x, -y
    along = math.sqrt(square - _TOLERANCE * _TOLERANCE) / square
    beside = _TOLERANCE / square
    right_x, right_y = x * along + y * beside, y * along - x * beside
    left_x, left_y = x * along - y * beside, y * along + x * beside
    if wedge[0] != 0.0 or wedge[1] != 0.0:
        if wedge[0] * right_y - wedge[1] * right_x < 0.0:
            right_x, right_y = wedge[0], wedge[1]
        if wedge[2] * left_y - wedge[3] * left_x > 0.0:
            left_x, left_y = wedge[2], wedge[3]
        if right_x * left_y - right_y * left_x < 0.0:
            return False
    wedge[0], wedge[1], wedge[2], wedge[3] = right_x, right_y, left_x, left_y
    return True


@kernel
def _finish(corners: Array, count: int, wedge: Array, strip: Array) -> None:
    """Write the narrowest strip about some corners: x0, y0, x1, y1 of its segment, and how far it reaches beyond it."""
    narrowest = np.inf
    for trial in range(3):
        # An axis, which for walls along it is exact, or the middle of the wedge.
        ux = wedge[0] + wedge[2] if trial == 2 else trial * 1.0
        uy = wedge[1] + wedge[3] if trial == 2 else 1.0 - trial
        length = math.sqrt(ux * ux + uy * uy)
        if length == 0.0:
            continue
        ux /= length
        uy /= length
        first, last, right, left = np.inf, -np.inf, np.inf, -np.inf
        for i in range(count):
            along = corners[i, 0] * ux + corners[i, 1] * uy
            across = corners[i, 1] * ux - corners[i, 0] * uy
            first, last = min(first, along), max(last, along)
            right, left = min(right, across), max(left, across)
        margin = 0.5 * (left - right)
        if margin < narrowest - (_EXACT if trial == 2 else 0.0):
            narrowest = margin
            middle = 0.5 * (left + right)
            first += margin
            last -= margin
            if first > last:
                first = last = 0.5 * (first + last)
            strip[0], strip[1] = first * ux - middle * uy, first * uy + middle * ux
            strip[2], strip[3] = last * ux - middle * uy, last * uy + middle * ux
            strip[4] = margin + (_MARGIN if trial == 2 else _THIN_MARGIN)


@kernel
def _follow(cells: Cells, seen: Cells, x: int, y: int, corners: Array, made: int, strips: Array) -> int:
    """Write the strips along one outline, from the corner where it begins to head 0; how many there are then."""
    wedge = np.zeros(4)
    strip = np.empty(5)
    heading = 0
    count = 0
    is_closed = False
    while not is_closed:
        is_closed = heading == 0 and seen[y, x] != 0
        is_inside = False
        x0, y0 = x, y
        if not is_closed:
            x, y, heading, is_inside = _run(cells, seen, x, y, heading)
        if is_inside and 0 < count < _MOST_CORNERS and _narrow(x - corners[0, 0], y - corners[0, 1], wedge):
            corners[count, 0], corners[count, 1] = x, y
            count += 1
            continue
        if count > 0:
            _finish(corners, count, wedge, strip)
            if made < strips.shape[0]:
                strips[made] = strip
            made += 1
            count = 0
        if is_inside:
            wedge[:] = 0.0
            corners[0, 0], corners[0, 1] = x0, y0
            corners[1, 0], corners[1, 1] = x, y
            count = 2
            _narrow(np.float64(x - x0), np.float64(y - y0), wedge)
    return made


@kernel
def trace(grid: Grid, cells: Cells, seen: Cells, strips: Array, most: int) -> int:
    """Write strips that hold all sides by which a ray can come from a free cell into an occupied one of the map.

    Parameters
    ----------
    grid, cells
        The same map twice: as a grid, and as an array (rows, cols) that is not 0 where occupied.
    seen
        (rows, cols) of zeros, for the kernel's own use.
    strips
        (M, 5): x0, y0, x1, y1 of a segment, and how far the strip reaches beyond it on all sides [cells]. As many as it
        has room for are written; their number is returned.
    most
        If there are more, the rest is not looked for, and some number above it is returned.
    """
    rows, cols = cells.shape
    corners = np.empty((_MOST_CORNERS, 2))
    made = 0
    # Every outline has a side that heads 0: free above, occupied below, which may be the map's lower border.
    for block_row in range(-1, (rows + 7) >> 3):
        for block_col in range((cols + 7) >> 3):
            word: Any = word_at(grid, block_row, block_col)
            if word == NONE:
                continue
            above = word_at(grid, block_row + 1, block_col)
            tops = word & ~((word >> np.uint64(8)) | (above << np.uint64(56)))
            bit = 0
            while tops != NONE:
                if tops & ONE:
                    row = 8 * block_row + (bit >> 3) + 1
                    col = 8 * block_col + (bit & 7)
                    if row < rows and col < cols and not seen[row, col]:
                        made = _follow(cells, seen, col, row, corners, made, strips)
                        if made > most:
                            return made
                tops >>= ONE
                bit += 1
    return made


def strips_of(grid: Grid, cells: Cells, most: int = MOST_STRIPS) -> Array:
    """Strips (M, 5) of the cells of a grid, given as an array too; see `trace`.

    Raises
    ------
    OverflowError
        If there are more than `most`: then the cells are noise, or nearly.
    """
    strips = np.empty((_USUAL_STRIPS, 5))  # what is not written to takes no memory
    made = trace(grid, cells, np.zeros_like(cells), strips, most)
    if made > most:
        raise OverflowError(f"more than {most} strips")
    if made > len(strips):
        strips = np.empty((made, 5))
        trace(grid, cells, np.zeros_like(cells), strips, most)
    return strips[:made]


def outline_lines(grid: Grid, cells: Cells, most: int = MOST_STRIPS) -> SegmentIndex:
    """Lines along the outlines of a grid's cells, for scans to look up; raises as `strips_of`."""
    strips = strips_of(grid, cells, most) * grid.resolution
    return index_segments(strips[:, :4], grid.rows, grid.cols, grid.resolution, strips[:, 4], grid)
