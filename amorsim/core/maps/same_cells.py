"""Comparison of the cells of two maps, independent of their source."""

from __future__ import annotations

import numpy as np

from amorsim.core.maps.map import Map, drawn_alike

__all__ = ["have_same_cells"]

_STRIP = 2**24  # cells to unpack at a time
_MOST = 2**33  # the most cells to unpack: some seconds


def have_same_cells(one: Map, other: Map) -> bool:
    """Whether two maps have the same cells in the same places, so that all ranges and collisions are the same.

    The same cells are unknown, too.
    Maps of more than 2^33 cells count as the same only if their walls were drawn in the same order.
    """
    if (one.resolution, one.shape, one.origin) != (other.resolution, other.shape, other.origin):
        return False
    # If drawn in the same order, cells lie in the same pages; otherwise they must be unpacked.
    if drawn_alike(one.grid, other.grid) and drawn_alike(one.unknown, other.unknown):
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
        is_known = one.unknown is None and other.unknown is None
        if not is_known and not np.array_equal(one.unknown_array(strip), other.unknown_array(strip)):
            return False
    return True
