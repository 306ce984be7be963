"""Comparison of the cells of two maps, independent of their source."""

from __future__ import annotations

import numpy as np

from amorsim.core.map import Map

__all__ = ["have_same_cells"]

_STRIP = 2**24  # cells to unpack at a time
_MOST = 2**33  # the most cells to unpack: some seconds


def have_same_cells(one: Map, other: Map) -> bool:
    """Whether two maps have the same cells in the same places, so that all ranges and collisions are the same.

    Maps of more than 2^33 cells count as the same only if their walls were drawn in the same order.
    """
    if (one.resolution, one.shape, one.origin) != (other.resolution, other.shape, other.origin):
        return False
    # If drawn in the same order, cells lie in the same pages; otherwise they must be unpacked.
    ours, theirs = one.grid, other.grid
    pairs = ((ours.supers, theirs.supers), (ours.tables, theirs.tables), (ours.pages, theirs.pages))
    if all(np.array_equal(mine, its) for mine, its in pairs):
        return True
    rows, cols = one.shape
    if rows * cols > _MOST:
        return False
    width, height = one.size
    step = max(1, _STRIP // cols)
    for row in range(0, rows, step):
        strip = (0.0, row * one.resolution, width, min(height, (row + step) * one.resolution))
        if not np.array_equal(one.to_array(strip), other.to_array(strip)):
            return False
    return True
