"""Plain twins of the kernels: slow, obvious, and what "exact" means in the tests."""

from __future__ import annotations

import math
from typing import Any

import numba
import numpy as np
from numpy.typing import NDArray


@numba.njit
def cell_of(start: float, resolution: float) -> int:
    """Cell i with i * resolution <= start < (i + 1) * resolution."""
    i = math.floor(start / resolution)
    while i * resolution > start:
        i -= 1
    while (i + 1) * resolution <= start:
        i += 1
    return i


@numba.njit
def line_at(line: int, resolution: float, start: float, component: float) -> float:
    """Distance at which a ray meets a grid line; a zero component meets none."""
    return math.inf if component == 0.0 else (line * resolution - start) / component


@numba.njit
def traverse(cells: Any, resolution: float, x: float, y: float, dx: float, dy: float, range_max: float) -> float:
    """Distance [m] at which a ray enters the first occupied cell of an array (rows, cols), cell by cell."""
    if math.isnan(x) or math.isnan(y) or math.isnan(dx) or math.isnan(dy):
        return math.nan
    rows, cols = cells.shape
    if not (0.0 <= x < cols * resolution and 0.0 <= y < rows * resolution):
        return 0.0
    col = cell_of(x, resolution)
    row = cell_of(y, resolution)
    if cells[row, col]:
        return 0.0
    while dx != 0.0 or dy != 0.0:
        tx = line_at(col + 1 if dx > 0.0 else col, resolution, x, dx)
        ty = line_at(row + 1 if dy > 0.0 else row, resolution, y, dy)
        # Both are inf where a component all but vanishes; a zero one still meets no line.
        if tx <= ty and dx != 0.0:
            distance = tx
            col += 1 if dx > 0.0 else -1
        else:
            distance = ty
            row += 1 if dy > 0.0 else -1
        if distance > range_max:
            return math.inf
        if not (0 <= row < rows and 0 <= col < cols) or cells[row, col]:
            return distance + 0.0
    return math.inf


@numba.njit
def cast(
    cells: Any, resolution: float, origin: Any, poses: Any, cos_b: Any, sin_b: Any, range_max: Any
) -> NDArray[np.float64]:
    """Distances (N, k) of the beams (1 or N, k) of poses (N, 3) in the world, by `traverse`."""
    origin_x, origin_y, yaw = origin
    out = np.empty((len(poses), cos_b.shape[1]))
    for n in range(len(poses)):
        x = poses[n, 0] - origin_x
        y = poses[n, 1] - origin_y
        if yaw != 0.0:
            x, y = math.cos(yaw) * x + math.sin(yaw) * y, math.cos(yaw) * y - math.sin(yaw) * x
        h = poses[n, 2] - yaw
        b = n if len(cos_b) > 1 else 0
        for k in range(cos_b.shape[1]):
            dx = math.cos(h) * cos_b[b, k] - math.sin(h) * sin_b[b, k]
            dy = math.sin(h) * cos_b[b, k] + math.cos(h) * sin_b[b, k]
            out[n, k] = traverse(cells, resolution, x, y, dx, dy, range_max[n if len(range_max) > 1 else 0])
    return out
