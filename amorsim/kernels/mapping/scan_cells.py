"""The cells that a scan says something about: those that its beams end in, and those that they cross before.

A beam crosses the cells that its line touches, one after the other: J. Amanatides, A. Woo, "A Fast Voxel Traversal
Algorithm for Ray Tracing" (1987). It meets grid line i at ``(i - start) / direction``, computed and never accumulated;
on a tie x goes first.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from amorsim.kernels.compile import part

__all__ = ["Area", "Seen", "room_to_see", "see"]

Floats = npt.NDArray[np.float64]

_BEYOND = 1e-6  # [m] by which an end is put further, as it may lie on the border of the cell that stopped the beam
_HIT = 2
_MISSED = 1


class Area(NamedTuple):
    """The size of a map of cells."""

    rows: int
    cols: int
    resolution: float  # [m]


class Seen(NamedTuple):
    """Room for the cells of one scan: each is listed once, and one that a beam ended in is not missed."""

    hit: npt.NDArray[np.int64]  # (k,) cells that beams ended in, as row * cols + col
    missed: npt.NDArray[np.int64]  # (m,) cells that beams only crossed
    marks: npt.NDArray[np.uint8]  # (s, s) what is known of each cell, s a power of 2: cell (r, c) at (r % s, c % s)


def room_to_see(area: Area, range_max: float, beams: int) -> Seen:
    """Room for scans of up to `range_max` [m] in maps of an area."""
    reach = min(range_max, math.hypot(area.rows, area.cols) * area.resolution) / area.resolution
    side = 1 << max(4, math.ceil(math.log2(2.0 * reach + 4.0)))
    across = min(side * side, area.rows * area.cols)
    return Seen(np.empty(beams, np.int64), np.empty(across, np.int64), np.zeros((side, side), np.uint8))


@part
def _cross(
    area: Area, x: float, y: float, dx: float, dy: float, length: float, is_end_free: bool, seen: Seen, count: int
) -> int:
    """List the cells of a beam before its end, those that no other beam has listed; returns how many there are now.

    The beam starts at (x, y) [cells] inside the area, has the direction (dx, dy), and ends after `length` [cells].
    """
    mask = seen.marks.shape[0] - 1
    col = math.floor(x)
    row = math.floor(y)
    last_col = math.floor(x + length * dx)
    last_row = math.floor(y + length * dy)
    left_x = abs(last_col - col)  # lines still to cross
    left_y = abs(last_row - row)
    step_x = 1 if last_col > col else -1
    step_y = 1 if last_row > row else -1
    first_x = (col + 1 - x) if step_x > 0 else (x - col)
    first_y = (row + 1 - y) if step_y > 0 else (y - row)
    unit_x = 1.0 / abs(dx) if left_x > 0 else math.inf
    unit_y = 1.0 / abs(dy) if left_y > 0 else math.inf
    done_x = 0
    done_y = 0
    tx = first_x * unit_x if left_x > 0 else math.inf
    ty = first_y * unit_y if left_y > 0 else math.inf
    steps = left_x + left_y + (1 if is_end_free else 0)
    for _ in range(steps):
        if row < 0 or row >= area.rows or col < 0 or col >= area.cols:
            break
        at = row & mask, col & mask
        if seen.marks[at] == 0:
            seen.marks[at] = _MISSED
            seen.missed[count] = row * area.cols + col
            count += 1
        if tx <= ty:
            col += step_x
            done_x += 1
            tx = (first_x + done_x) * unit_x if done_x < left_x else math.inf
        else:
            row += step_y
            done_y += 1
            ty = (first_y + done_y) * unit_y if done_y < left_y else math.inf
    return count


@part
def see(
    area: Area,
    origin: Floats,
    pose: Floats,
    ranges: Floats,
    cos_b: Floats,
    sin_b: Floats,
    range_max: float,
    seen: Seen,
) -> tuple[int, int]:
    """List the cells that a scan hits and misses; returns how many of each.

    Beams of inf saw nothing up to `range_max` [m]; those of -inf and nan say nothing. From outside the area nothing
    is listed, and beams end at its border.

    Parameters
    ----------
    origin
        x, y [m] of the area's lower left corner in the world, (2,).
    pose
        Of the laser in the world, (3,).
    ranges, cos_b, sin_b
        Of the beams, with cosine and sine of their bearings, (k,).
    """
    hits = 0
    misses = 0
    x = (pose[0] - origin[0]) / area.resolution
    y = (pose[1] - origin[1]) / area.resolution
    if not (0.0 <= x < area.cols and 0.0 <= y < area.rows):
        return 0, 0
    seen.marks[:] = 0
    mask = seen.marks.shape[0] - 1
    c = math.cos(pose[2])
    s = math.sin(pose[2])
    for k in range(ranges.shape[0]):
        if not (0.0 <= ranges[k] <= range_max):
            continue
        length = (ranges[k] + _BEYOND) / area.resolution
        col = math.floor(x + length * (c * cos_b[k] - s * sin_b[k]))
        row = math.floor(y + length * (s * cos_b[k] + c * sin_b[k]))
        if row < 0 or row >= area.rows or col < 0 or col >= area.cols:
            continue
        if seen.marks[row & mask, col & mask] == 0:
            seen.marks[row & mask, col & mask] = _HIT
            seen.hit[hits] = row * area.cols + col
            hits += 1
    for k in range(ranges.shape[0]):
        is_open = ranges[k] > range_max
        if not (is_open or ranges[k] >= 0.0):
            continue
        length = (range_max if is_open else ranges[k] + _BEYOND) / area.resolution
        dx = c * cos_b[k] - s * sin_b[k]
        dy = s * cos_b[k] + c * sin_b[k]
        misses = _cross(area, x, y, dx, dy, length, is_open, seen, misses)
    return hits, misses
