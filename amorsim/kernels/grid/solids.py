"""Walls that are boxes of occupied cells, whose distance along a ray is found without cells."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from amorsim.array_types import Array, Ints
from amorsim.kernels.compile import kernel
from amorsim.kernels.grid.grid import ALL, Grid, word_at, word_mask

__all__ = ["NOT_SOLID", "solids_of"]


NOT_SOLID = (1.0, 1.0, 0.0, 0.0)
"""The lines of a wall that is no such box."""
_WHOLE = 0.01  # [cells] within which a wall's rectangle ends at a grid line; it is larger than need be by far less


@kernel
def _find_full(grid: Grid, boxes: Ints, out: NDArray[np.uint8]) -> None:
    """Write 1 for each box (M, 4), its first and last column and row as `solids_of` has them, that has no free cell."""
    for m in range(boxes.shape[0]):
        col0, row0, col1, row1 = boxes[m, 0], boxes[m, 1], boxes[m, 2], boxes[m, 3]
        is_full = col0 < col1 and row0 < row1
        row = row0
        while is_full and row < row1:
            last_row = min(row | 7, row1 - 1)
            col = col0
            while is_full and col < col1:
                last_col = min(col | 7, col1 - 1)
                mask: Any = word_mask(row & 7, col & 7, last_row & 7, last_col & 7)
                is_full = ((word_at(grid, row >> 3, col >> 3) ^ ALL) & mask) == 0
                col = last_col + 1
            row = last_row + 1
        out[m] = is_full


def solids_of(grid: Grid, walls: Array) -> Array:
    """Grid lines (M, 4), least and greatest of x and y as col0, row0, col1, row1, of the box that each wall is.

    `walls` (M, 6) are as `amorsim.kernels.grid.segments.SegmentIndex` has them, each a row. Of a wall that is one side
    of what is occupied the box is one cell deep. `NOT_SOLID` where a wall is not along an axis, or has a free cell.
    """
    begin, unit = walls[:, :2] / grid.resolution, walls[:, 2:4]
    end = begin + unit * walls[:, 4:5] / grid.resolution
    margin = walls[:, 5:] / grid.resolution
    low, high = np.minimum(begin, end) - margin, np.maximum(begin, end) + margin
    lines = np.rint(np.concatenate([low, high], axis=1))
    is_whole = (np.abs(np.concatenate([low, high], axis=1) - lines) < _WHOLE).all(axis=1) & (unit == 0.0).any(axis=1)
    solids = np.tile(NOT_SOLID, (len(walls), 1))
    for deeper in (0, 1):
        boxes = lines.copy()
        for axis in range(2):
            thin = lines[:, axis] == lines[:, 2 + axis]
            boxes[thin, (2 if deeper else 0) + axis] += 1.0 if deeper else -1.0
        boxes[~is_whole] = NOT_SOLID
        full = np.empty(len(boxes), dtype=np.uint8)
        _find_full(grid, boxes.astype(np.int64), full)
        solids[full != 0] = boxes[full != 0]
    return solids
