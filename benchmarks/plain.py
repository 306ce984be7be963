"""The plain traversal: walks a ray from cell to cell through an array of bytes.

This is the yardstick of all ray casting, and it is frozen: figures that were published with it stay comparable only
while it stays as it is. Do not tune it. It computes what the project calls exact (the distance at which the ray
enters the first occupied cell, grid lines computed and never accumulated), by one test a cell.
"""

from __future__ import annotations

import math
from typing import Any

import numba
import numpy as np
import numpy.typing as npt

__all__ = ["cast"]

Array = npt.NDArray[np.float64]


def _walk(cells: Any, resolution: float, x: float, y: float, dx: float, dy: float, range_max: float) -> float:
    rows, cols = cells.shape
    col, row = math.floor(x / resolution), math.floor(y / resolution)
    if not (0 <= row < rows and 0 <= col < cols) or cells[row, col]:
        return 0.0
    step_x, step_y = (1 if dx > 0.0 else -1), (1 if dy > 0.0 else -1)
    line_x, line_y = (col + 1 if dx > 0.0 else col), (row + 1 if dy > 0.0 else row)
    tx = (line_x * resolution - x) / dx if dx != 0.0 else math.inf
    ty = (line_y * resolution - y) / dy if dy != 0.0 else math.inf
    while True:
        if tx <= ty:
            distance = tx
            col += step_x
            line_x += step_x
            tx = (line_x * resolution - x) / dx
        else:
            distance = ty
            row += step_y
            line_y += step_y
            ty = (line_y * resolution - y) / dy
        if distance > range_max:
            return math.inf
        if not (0 <= row < rows and 0 <= col < cols) or cells[row, col]:
            return distance


_walk_compiled = numba.njit(nogil=True, error_model="numpy", inline="never")(_walk)


def _scan(
    cells: Any, resolution: float, poses: Array, cosines: Array, sines: Array, range_max: float, out: Any
) -> None:
    for n in range(len(poses)):
        c, s = math.cos(poses[n, 2]), math.sin(poses[n, 2])
        for k in range(len(cosines)):
            dx = c * cosines[k] - s * sines[k]
            dy = s * cosines[k] + c * sines[k]
            out[n, k] = _walk_compiled(cells, resolution, poses[n, 0], poses[n, 1], dx, dy, range_max)


_scan_compiled: Any = numba.njit(nogil=True, error_model="numpy")(_scan)


def cast(cells: npt.NDArray[np.uint8], resolution: float, poses: Array, bearings: Array, range_max: float) -> Array:
    """Distance [m] along each beam to where it enters the first occupied cell, `(N, k)`; inf beyond `range_max`.

    Parameters
    ----------
    cells
        `(rows, cols)`, row 0 lowest, not 0 where occupied; its lower left corner is the world's origin.
    resolution
        Side of a cell [m].
    poses
        `(N, 3)` x, y [m] and heading [rad].
    bearings
        `(k,)` [rad], anticlockwise from the heading.
    """
    out = np.empty((len(poses), len(bearings)))
    _scan_compiled(cells, resolution, poses, np.cos(bearings), np.sin(bearings), range_max, out)
    return out
