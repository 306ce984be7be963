"""The cells that a scan observes: those in which its beams end, and those that they cross before.

They are marked in a square window around the laser. A beam crosses all cells that its line touches.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from amorsim.array_types import Array
from amorsim.kernels.compile import part

__all__ = ["HIT", "MISSED", "Area", "Window", "see", "window_for"]


MISSED = 1
HIT = 2
_BEYOND = 1e-6  # [m] by which an end is put further, as it may lie on the border of the cell that stopped the beam
_BITS = 40  # of the fraction of a cell; rounded there, a line is off by 1e-9 cells after a thousand of them
_ONE = float(1 << _BITS)


class Area(NamedTuple):
    """The size of a map of cells."""

    rows: int
    cols: int
    resolution: float  # [m]


class Window(NamedTuple):
    """The cells around a laser as one scan observes them: 0 for not at all, `MISSED` or `HIT`."""

    marks: npt.NDArray[np.uint8]  # (side * side,), the laser's cell in the middle
    side: int


def window_for(area: Area, range_max: float) -> Window:
    """A window for scans of up to `range_max` [m] in maps of an area."""
    reach = min(range_max, math.hypot(area.rows, area.cols) * area.resolution) / area.resolution
    side = 2 * math.ceil(reach + 2.0) + 1
    return Window(np.zeros(side * side, np.uint8), side)


@part
def _cross(window: Window, x: float, y: float, dx: float, dy: float, length: float) -> None:
    """Mark the cells of a beam from (x, y) [cells] in the window, in direction (dx, dy), after `length` [cells].

    Along its longer axis it passes from line to line. Between two lines it is in one cell, or in two that are
    neighbours; both are marked in any case, as a branch on which it is would be as good as random. Places along the
    shorter axis are whole numbers of 2^-40 cells: such sums are exact, and their floor is a shift.
    """
    is_steep = abs(dy) > abs(dx)
    u, v = (y, x) if is_steep else (x, y)
    du, dv = (dy, dx) if is_steep else (dx, dy)
    step_u, step_v = (window.side, 1) if is_steep else (1, window.side)
    first = math.floor(u)
    last = math.floor(u + length * du)
    lines = abs(last - first)
    ahead = 1 if last > first else -1
    edge = (first + 1 - u) if ahead > 0 else (u - first)  # to the first line
    slope = dv / abs(du)
    mark = first * step_u
    at: Any = math.floor(v)
    place: Any = np.int64((v + edge * slope) * _ONE)
    step: Any = np.int64(slope * _ONE)
    for _ in range(lines):
        window.marks[mark + at * step_v] = MISSED
        at = place >> _BITS
        window.marks[mark + at * step_v] = MISSED
        place += step
        mark += ahead * step_u
    window.marks[mark + at * step_v] = MISSED
    at = math.floor(v + length * dv)
    window.marks[mark + at * step_v] = MISSED


@part
def see(
    area: Area,
    origin: Array,
    pose: Array,
    ranges: Array,
    cos_b: Array,
    sin_b: Array,
    range_max: float,
    window: Window,
) -> tuple[int, int]:
    """Mark the cells that a scan hits and misses; returns the row and column of the window's lower left cell.

    Beams of inf saw nothing up to `range_max` [m]; those of -inf and nan say nothing. A cell that one beam hits and
    others miss is hit. The window may reach beyond the area.

    Parameters
    ----------
    origin
        x, y [m] of the area's lower left corner in the world, (2,).
    pose
        Of the laser in the world, (3,).
    ranges, cos_b, sin_b
        Of the beams, with cosine and sine of their bearings, (k,).
    """
    window.marks[:] = 0
    half = window.side // 2
    reach = half - 1.0
    x = (pose[0] - origin[0]) / area.resolution
    y = (pose[1] - origin[1]) / area.resolution
    col = math.floor(x) - half
    row = math.floor(y) - half
    x -= col
    y -= row
    c = math.cos(pose[2])
    s = math.sin(pose[2])
    for k in range(ranges.shape[0]):
        if ranges[k] >= 0.0:
            length = (range_max if ranges[k] > range_max else ranges[k] + _BEYOND) / area.resolution
            dx = c * cos_b[k] - s * sin_b[k]
            dy = s * cos_b[k] + c * sin_b[k]
            _cross(window, x, y, dx, dy, min(length, reach))
    for k in range(ranges.shape[0]):
        length = (ranges[k] + _BEYOND) / area.resolution
        if 0.0 <= ranges[k] <= range_max and length <= reach:
            end_x = math.floor(x + length * (c * cos_b[k] - s * sin_b[k]))
            end_y = math.floor(y + length * (s * cos_b[k] + c * sin_b[k]))
            window.marks[end_y * window.side + end_x] = HIT
    return row, col
