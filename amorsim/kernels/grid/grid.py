"""Occupied cells as bits, held sparsely, with the room around every free place stored with them.

Three levels, each eight or sixty-four times as wide as the one below::

    cell                                                    one bit
    word         8 x 8 cells      one uint64, bit 8 * (row % 8) + (col % 8)
    page        64 x 64 cells     8 x 8 words
    table     4096 x 4096 cells   64 x 64 pages
    supers                        the dense top, one entry a table

An entry of `supers` or of a table that is not negative is an index one level down. A negative one says that
all of it is free, and how much room there is: for each of the four quadrants a ray can go to, the side of a
free square that has this place as its near corner, in units of its own level (7 bits each, so 127 at most).
Empty words in a page with walls keep the same in `room` (4 bits each, in words). A ray crosses free space in
a few such squares, and memory follows the length of the walls, not the area.

Page 0 and table 0 are wholly occupied and shared by every place that is. Bits beyond the map's rows and
columns are set, so that outside is occupied at every level.

Row 0 is the lowest, column 0 the leftmost. Quadrant ``(dx < 0) + 2 * (dy < 0)`` is the one that a ray of
direction (dx, dy) goes to.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from amorsim.array_types import Ints, Ints32
from amorsim.kernels.compile import kernel

__all__ = [
    "Grid",
    "box_is_free",
    "is_occupied",
    "next_occupied",
    "occupied_boxes",
    "square_ahead",
    "word_at",
    "word_mask",
]

ALL = np.uint64(0xFFFFFFFFFFFFFFFF)
NONE = np.uint64(0)
ONE = np.uint64(1)


class Grid(NamedTuple):
    """A finished grid, to be read; its fields are explained at the top of the module."""

    resolution: float
    """Side of a cell [m]."""
    rows: int
    cols: int
    super_cols: int
    """Entries of `supers` in one of its rows."""
    supers: Ints32
    tables: Ints32
    """(tables, 4096)"""
    pages: NDArray[np.uint64]
    """(pages, 64)"""
    room: NDArray[np.uint16]
    """(pages, 64)"""


@kernel
def word_at(grid: Grid, block_row: int, block_col: int) -> Any:
    """Bits of the 8 x 8 cells of a block, uint64; all ones outside the map, cells beyond its edge set."""
    if block_row < 0 or block_col < 0 or block_row * 8 >= grid.rows or block_col * 8 >= grid.cols:
        return ALL
    table = grid.supers[(block_row >> 9) * grid.super_cols + (block_col >> 9)]
    if table < 0:
        return NONE
    page = grid.tables[table, ((block_row >> 3) & 63) * 64 + ((block_col >> 3) & 63)]
    if page < 0:
        return NONE
    return grid.pages[page, (block_row & 7) * 8 + (block_col & 7)]


@kernel
def is_occupied(grid: Grid, row: int, col: int) -> bool:
    """Whether a cell is occupied; every cell outside the map is."""
    bit = np.uint64((row & 7) * 8 + (col & 7))
    return bool((word_at(grid, row >> 3, col >> 3) >> bit) & ONE)


@kernel
def word_mask(row0: int, col0: int, row1: int, col1: int) -> Any:
    """Bits of rows row0..row1 and columns col0..col1 (0 to 7, inclusive) of a word."""
    columns = (np.uint64(0xFF) >> np.uint64(7 - (col1 - col0))) << np.uint64(col0)
    spread = columns * np.uint64(0x0101010101010101)
    return ((spread << np.uint64(8 * row0)) & (ALL >> np.uint64(8 * (7 - row1)))) & ALL


@kernel
def square_ahead(grid: Grid, row: int, col: int, quadrant: int) -> Any:
    """The side [cells] of a free square about a cell, as `(side, shift)`; the side is 0 where there is none.

    At the square's near corner, where a ray of this quadrant enters it, is the free word, page or table that holds the
    cell; that unit is ``1 << shift`` cells wide (shift 3, 6 or 12). There is no square where the word that holds the
    cell is not empty, nor outside the map.
    """
    if row < 0 or col < 0 or row >= grid.rows or col >= grid.cols:
        return 0, 3
    entry = grid.supers[(row >> 12) * grid.super_cols + (col >> 12)]
    if entry < 0:
        return ((entry >> (7 * quadrant)) & 127) << 12, 12
    page = grid.tables[entry, ((row >> 6) & 63) * 64 + ((col >> 6) & 63)]
    if page < 0:
        return ((page >> (7 * quadrant)) & 127) << 6, 6
    word = ((row >> 3) & 7) * 8 + ((col >> 3) & 7)
    return ((np.int64(grid.room[page, word]) >> (4 * quadrant)) & 15) << 3, 3


@kernel
def box_is_free(grid: Grid, row0: int, col0: int, row1: int, col1: int) -> bool:
    """Whether no cell of an inclusive box of cells is occupied; one that reaches outside is not free."""
    if row0 > row1 or col0 > col1:
        return True
    if row0 < 0 or col0 < 0 or row1 >= grid.rows or col1 >= grid.cols:
        return False
    row = row0
    while row <= row1:
        # One band of cells that lie in the same words, widened to a page or table where all of it is free at
        # that level.
        next_row = row1 + 1
        col = col0
        while col <= col1:
            entry: Any = grid.supers[(row >> 12) * grid.super_cols + (col >> 12)]
            if entry < 0:
                side: Any = np.int64(entry & 127) << 12
                col = ((col >> 12) << 12) + side
                next_row = min(next_row, ((row >> 12) << 12) + side)
                continue
            page: Any = grid.tables[entry, ((row >> 6) & 63) * 64 + ((col >> 6) & 63)]
            if page < 0:
                side = np.int64(page & 127) << 6
                col = ((col >> 6) << 6) + side
                next_row = min(next_row, ((row >> 6) << 6) + side)
                continue
            last_row = min(row1, row | 7)
            last_col = min(col1, col | 7)
            word = grid.pages[page, ((row >> 3) & 7) * 8 + ((col >> 3) & 7)]
            if word & word_mask(row & 7, col & 7, last_row & 7, last_col & 7):
                return False
            col = last_col + 1
            next_row = min(next_row, last_row + 1)
        row = next_row
    return True


@kernel
def next_occupied(grid: Grid, row0: int, row1: int, col: int) -> int:
    """The first column from `col` on in which one of the map's rows row0..row1 is occupied; `cols` where none is."""
    first = grid.cols
    row = row0
    while row <= row1:
        last_row = min(row1, row | 7)
        at = col
        while at < first:
            entry: Any = grid.supers[(row >> 12) * grid.super_cols + (at >> 12)]
            if entry < 0:
                at = ((at >> 12) + 1) << 12
                continue
            page: Any = grid.tables[entry, ((row >> 6) & 63) * 64 + ((at >> 6) & 63)]
            if page < 0:
                at = ((at >> 6) + 1) << 6
                continue
            word = grid.pages[page, ((row >> 3) & 7) * 8 + ((at >> 3) & 7)]
            word = word & word_mask(row & 7, at & 7, last_row & 7, 7)
            if word:
                # Its rows laid over each other, a bit a column.
                word = word | (word >> np.uint64(32))
                word = word | (word >> np.uint64(16))
                word = word | (word >> np.uint64(8))
                while not (word >> np.uint64(at & 7)) & ONE:
                    at += 1
                first = min(first, at)
            at = (at | 7) + 1
        row = last_row + 1
    return first


@kernel
def occupied_boxes(
    grid: Grid,
    row0: Ints,
    row1: Ints,
    col0: Ints,
    col1: Ints,
    out: NDArray[np.uint8],
) -> None:
    """Write 1 for every box of cells with an occupied one in it, 0 for the others.

    Box (i, j) of `out` is rows row0[i]..row1[i] and columns col0[j]..col1[j], inclusive. Of a box that
    reaches outside the map only the part inside counts, unless it has none: then it is occupied.
    """
    for i in range(out.shape[0]):
        low = max(row0[i], 0)
        high = min(row1[i], grid.rows - 1)
        # From `start` on the next occupied one, which most boxes have in common with the one before.
        start, wall = 0, -1
        for j in range(out.shape[1]):
            left = max(col0[j], 0)
            right = min(col1[j], grid.cols - 1)
            if low > high or left > right:
                out[i, j] = 1
                continue
            if left < start or left > wall:
                start, wall = left, next_occupied(grid, low, high, left)
            out[i, j] = 1 if wall <= right else 0
