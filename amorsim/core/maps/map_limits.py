"""Limits of maps: the largest number of cells, and the memory that they take."""

from __future__ import annotations

import math

import numpy as np

from amorsim.array_types import Array
from amorsim.core.errors import MapError
from amorsim.kernels.grid.rasterise import MOST_CELLS

__all__ = ["refuse_not_finite", "refuse_too_far", "refuse_too_large", "refuse_too_much_memory"]

# A double still resolves a thousandth of a cell there.
_FARTHEST_CELL = 2**43
_MOST_TABLES = 2**23
_TABLE_CELLS = 4096
# A page of 64 x 64 cells takes 512 bytes of bits and 128 of room.
_PAGE_CELLS = 64
_PAGE_BYTES = 640
# Of a table: 4 bytes for each of its pages.
_TABLE_BYTES = 16_384
# The limit for the cells of one map; with the memory needed to draw them, that is 1 GB.
_MOST_GRID_BYTES = 400_000_000


def refuse_not_finite(walls: Array, what: str) -> None:
    """Raise `MapError` if a wall has a number that is not finite."""
    bad = ~np.isfinite(walls).all(axis=1)
    if bad.any():
        m = int(np.argmax(bad))
        raise MapError(f"{what} {m} is {tuple(walls[m].tolist())}; expected finite x0, y0, x1, y1 in metres")


def refuse_too_large(rows: float, cols: float, side: float) -> None:
    """Raise `MapError` if there are more cells than a grid can number."""
    # Also true of rows or columns that overflowed to inf or nan.
    tables = (rows // _TABLE_CELLS + 1) * (cols // _TABLE_CELLS + 1)
    if not (rows <= MOST_CELLS and cols <= MOST_CELLS and tables <= _MOST_TABLES):
        raise MapError(
            f"the map is {cols * side:.6g} m x {rows * side:.6g} m: too large for cells of {side:g} m; "
            "pass a coarser resolution, or leave out what lies far away"
        )


def refuse_too_far(low: Array, high: Array, side: float) -> None:
    """Raise `MapError` if cells lie too far from the world's origin for doubles to resolve them."""
    farthest = float(np.maximum(np.abs(low), np.abs(high)).max())
    if farthest > _FARTHEST_CELL:
        raise MapError(
            f"the map reaches to {farthest * side:.6g} m from the world's origin, where doubles do not tell "
            f"cells of {side:g} m apart; move it nearer"
        )


def refuse_too_much_memory(walls: Array, rows: int, cols: int, side: float, offset: tuple[int, int]) -> None:
    """Raise `MapError` if the cells that walls touch could take more than 400 MB."""
    needed = _grid_bytes(walls, rows, cols, side, offset)
    if needed <= _MOST_GRID_BYTES:
        return
    scale = 1.0  # of the cells, for as much as may be taken
    size = needed
    while size > _MOST_GRID_BYTES:
        scale *= 1.2
        corner = math.floor(offset[0] / scale), math.floor(offset[1] / scale)
        size = _grid_bytes(walls, math.ceil(rows / scale), math.ceil(cols / scale), side * scale, corner)
    length = float((np.abs(walls[:, 2] - walls[:, 0]) + np.abs(walls[:, 3] - walls[:, 1])).sum())
    raise MapError(
        f"{len(walls)} walls of {length:.6g} m in all, on a map of {cols * side:.6g} m x {rows * side:.6g} m, would "
        f"take about {needed / 1e9:.3g} GB in cells of {side:g} m; pass a resolution of {side * scale:.3g} m or coarser"
    )


def _grid_bytes(walls: Array, rows: int, cols: int, side: float, offset: tuple[int, int]) -> float:
    """Upper bound of the memory [bytes] of the cells that walls touch: every wall counts its own pages."""
    low = np.minimum(walls[:, :2], walls[:, 2:]) / side - offset
    high = np.maximum(walls[:, :2], walls[:, 2:]) / side - offset
    size = 0.0
    for cells, each in ((_PAGE_CELLS, _PAGE_BYTES), (_TABLE_CELLS, _TABLE_BYTES)):
        # A wall along a grid line touches the cells on both sides of it, which may be in different pages.
        first, last = np.floor((np.ceil(low) - 1.0).clip(0.0) / cells), np.floor(high / cells)
        across, up = (last - first + 1.0).T
        straight = (walls[:, 0] == walls[:, 2]) | (walls[:, 1] == walls[:, 3])
        touched = float(np.where(straight, across * up, across + up).sum())
        width, height = cols // cells + 1, rows // cells + 1
        # The outside is occupied, so pages along the right and the upper edge are always needed.
        size += each * min(touched + width + height, width * height)
    return size
