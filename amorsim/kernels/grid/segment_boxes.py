"""The lines of a map made from its segments: boxes around the cells that they occupy, in blocks of neighbours."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from amorsim.array_types import Array
from amorsim.kernels.grid.grid import Grid
from amorsim.kernels.grid.rasterise import SNAP
from amorsim.kernels.grid.segments import SegmentIndex
from amorsim.kernels.grid.solids import NOT_SOLID, solids_of

__all__ = ["index_segments", "no_segments"]


_SLACK = 1e-3  # [cells] by which rectangles are larger than need be, for end points snapped to grid lines and roundings
_THIN_SLACK = 1e-6  # [cells] the same for those made of whole cells, in which only roundings count
_BLOCK = 16  # segments whose distance is computed at once


def no_segments() -> SegmentIndex:
    """The lines of a map without segments."""
    return SegmentIndex(np.empty((4, 0)), np.zeros(1, dtype=np.int64), np.empty((10, 0)))


def index_segments(
    segments: Array,
    rows: int,
    cols: int,
    resolution: float,
    margins: Array | None = None,
    grid: Grid | None = None,
) -> SegmentIndex:
    """Lines of segments (M, 4), x0 y0 x1 y1 [m] in the frame of a map of rows x cols cells, and of the map's border.

    `margins` (M,) [m] says how far what is occupied reaches beyond each segment; where not given it is the cells that
    the segment touches. The border is needed because outside is occupied: a beam that no segment covers ends there.
    Without the `grid` of the map no wall is known to be a box.
    """
    width, height = cols * resolution, rows * resolution
    border = np.array([[0, 0, width, 0], [width, 0, width, height], [width, height, 0, height], [0, height, 0, 0]])
    ends = np.concatenate([segments.reshape(-1, 4), border])
    run = ends[:, 2:] - ends[:, :2]
    length = np.hypot(run[:, 0], run[:, 1])
    unit = np.where(length[:, None] > 0.0, run / np.where(length > 0.0, length, 1.0)[:, None], [1.0, 0.0])
    # A cell that holds a point of the segment reaches as far from it, across and along; what is outside does not.
    margin = resolution * (np.abs(unit).sum(axis=1) + _SLACK)
    if margins is not None:
        margin[:-4] = margins
    margin[-4:] = resolution * _THIN_SLACK
    walls = np.concatenate([ends[:, :2], unit, length[:, None], margin[:, None]], axis=1)
    if margins is None:
        _tighten(walls[:-4], ends[:-4], resolution)
    boxes = np.tile(NOT_SOLID, (len(walls), 1))
    if grid is not None:
        boxes[:-4] = solids_of(grid, walls[:-4])
        # What is outside is occupied, at its corners too.
        boxes[-4:, 0] = boxes[-4:, 1] = -1.0
        boxes[-4:, 2], boxes[-4:, 3] = cols + 1.0, rows + 1.0
        for n, (line, at) in enumerate(((3, 0.0), (0, cols), (1, rows), (2, 0.0))):
            boxes[len(walls) - 4 + n, line] = at
    walls = np.concatenate([walls, boxes], axis=1)
    order = np.argsort(_curve(ends, max(width, height)), kind="stable")
    walls, ends, margin = walls[order], ends[order], margin[order]
    block = _BLOCK * max(1, math.isqrt(len(ends)) // (4 * _BLOCK))
    first = np.append(np.arange(0, len(ends), block), len(ends))
    beyond = 1.5 * margin[:, None]  # the corner of a rectangle is the square root of 2 margins away
    low = np.minimum.reduceat(np.minimum(ends[:, :2], ends[:, 2:]) - beyond, first[:-1])
    high = np.maximum.reduceat(np.maximum(ends[:, :2], ends[:, 2:]) + beyond, first[:-1])
    return SegmentIndex(
        np.ascontiguousarray(np.concatenate([low, high], axis=1).T),
        first.astype(np.int64),
        np.ascontiguousarray(walls.T),
    )


def _tighten(walls: Array, ends: Array, resolution: float) -> None:
    """Give walls along an axis the rectangle of their cells: whole rows or columns of them, one or two wide.

    Then a wall met squarely bounds a beam to rounding, not to a cell or two.
    """
    cells = ends / resolution
    low = np.ceil(np.minimum(cells[:, :2], cells[:, 2:]) - 3.0 * SNAP) - 1.0
    high = np.floor(np.maximum(cells[:, :2], cells[:, 2:]) + 3.0 * SNAP) + 1.0
    size = high - low
    for axis in range(2):
        across = 1 - axis
        thin = (size[:, across] <= 2.0) & (size[:, axis] >= size[:, across])
        half = 0.5 * size[thin, across]
        start = np.empty((len(half), 2))
        start[:, axis] = low[thin, axis] + half
        start[:, across] = low[thin, across] + half
        walls[thin, :2] = start * resolution
        walls[thin, 2 + axis], walls[thin, 2 + across] = 1.0, 0.0
        walls[thin, 4] = (size[thin, axis] - size[thin, across]) * resolution
        walls[thin, 5] = (half + _THIN_SLACK) * resolution


def _curve(ends: Array, size: float) -> Any:
    """Place of each segment's middle on a Morton curve through the map: neighbours on it are near one another."""
    middle = (ends[:, :2] + ends[:, 2:]) / 2.0
    steps = np.clip(middle / size * 65536.0, 0, 65535).astype(np.int64)
    place = np.zeros(len(ends), dtype=np.int64)
    for bit in range(16):
        for axis in range(2):
            place |= ((steps[:, axis] >> bit) & 1) << (2 * bit + axis)
    return place
