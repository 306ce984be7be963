"""Ranges the way of the original AMORsim: along the cells of Bresenham's line.

Source of the line: J. E. Bresenham, "Algorithm for computer control of a digital plotter", IBM Systems Journal 4(1),
1965. It may slip through a wall's diagonal crack and gives distances between the centres of cells; the exact method is
`amorsim.kernels.raycast.rays`.
"""

from __future__ import annotations

import math

import numpy as np

from amorsim.array_types import Array, Ints
from amorsim.kernels.compile import kernel
from amorsim.kernels.grid.grid import Grid, is_occupied
from amorsim.kernels.raycast.rays import direction, to_frame

__all__ = ["bresenham_cast", "bresenham_cells"]


@kernel
def _next(
    col: int, row: int, error: int, across: int, along: int, step_col: int, step_row: int
) -> tuple[int, int, int]:
    """The cell after (col, row) on the line, and the error term there."""
    twice = 2 * error
    if twice >= along:
        error += along
        col += step_col
    if twice <= across:
        error += across
        row += step_row
    return col, row, error


@kernel
def bresenham_cells(col: int, row: int, last_col: int, last_row: int, out: Ints) -> None:
    """Write the cells (column, row) `(n, 2)` of the line between two cells, both included, into `out`.

    There are max(columns apart, rows apart) + 1 of them.
    """
    across = abs(last_col - col)
    along = -abs(last_row - row)
    step_col = 1 if col < last_col else -1
    step_row = 1 if row < last_row else -1
    error = across + along
    for n in range(out.shape[0]):
        out[n, 0] = col
        out[n, 1] = row
        col, row, error = _next(col, row, error, across, along, step_col, step_row)


@kernel
def bresenham_cast(
    grid: Grid,
    origin_x: float,
    origin_y: float,
    yaw: float,
    poses: Array,
    cos_b: Array,
    sin_b: Array,
    range_max: Array,
    out: Array,
) -> None:
    """Write the distance [m] along every beam to the first occupied cell on the line to the range's end.

    Arguments are those of `rays.cast`, with `range_max` (N,). The distance is between the centres of the beam's first
    cell and of that cell, inf where no cell of the line is occupied or it is beyond the range, nan where a pose is.
    """
    cos_yaw = math.cos(yaw)
    sin_yaw = math.sin(yaw)
    resolution = grid.resolution
    for n in range(poses.shape[0]):
        x, y = to_frame(poses[n, 0], poses[n, 1], origin_x, origin_y, cos_yaw, sin_yaw)
        cos_h = math.cos(poses[n, 2] - yaw)
        sin_h = math.sin(poses[n, 2] - yaw)
        if x != x or y != y or cos_h != cos_h:
            out[n] = np.nan
            continue
        first_col = math.floor(x / resolution)
        first_row = math.floor(y / resolution)
        b = n if cos_b.shape[0] > 1 else 0
        for k in range(out.shape[1]):
            dx, dy = direction(cos_h, sin_h, cos_b[b, k], sin_b[b, k])
            last_col = math.floor((x + range_max[n] * dx) / resolution)
            last_row = math.floor((y + range_max[n] * dy) / resolution)
            col, row = first_col, first_row
            across = abs(last_col - col)
            along = -abs(last_row - row)
            step_col = 1 if col < last_col else -1
            step_row = 1 if row < last_row else -1
            error = across + along
            found = np.inf
            for _ in range(max(across, -along) + 1):
                if is_occupied(grid, row, col):
                    away_x = (col - first_col) * resolution
                    away_y = (row - first_row) * resolution
                    found = math.sqrt(away_x * away_x + away_y * away_y)
                    break
                col, row, error = _next(col, row, error, across, along, step_col, step_row)
            out[n, k] = found if found <= range_max[n] else np.inf
