"""Correlative scan matching: the pose within a window at which a scan fits a blurred picture of another one best.

All poses of the window are weighed, so that no start is too far away for it. Blocks of them are weighed at once on a
coarse picture whose values are never too low, and those that cannot be best are left out. Source: E. Olson, "Real-time
correlative scan matching" (2009).
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from amorsim.array_types import Array, Ints
from amorsim.kernels.compile import kernel, part
from amorsim.kernels.kinematics.poses import wrap

__all__ = ["BLOCK", "Picture", "Window", "add", "clear", "correlate", "draw", "picture", "weigh"]


BLOCK = 8  # cells of the picture to a side of a coarse one
_SPREAD = 3.0  # standard deviations to which points are blurred
_PASSED = 0.4  # how much less a scan fits with a point where another one saw nothing
_CLEAR = 3.0  # standard deviations before a point that a beam passes through
_PULL = 0.05  # how much less a pose at the window's border fits: along a corridor all fit alike


class Picture(NamedTuple):
    """A blurred picture of points: how well a point fits in each cell, from 0 to 1, and below 0 where space is free."""

    resolution: float  # [m]
    std: float  # [m] of the blur
    corner: Array  # (2,) [m] its lower left corner
    fine: npt.NDArray[np.float32]  # (n, n), n a multiple of BLOCK
    coarse: npt.NDArray[np.float32]  # (n / BLOCK, n / BLOCK), the largest value in each block


class Window(NamedTuple):
    """The poses that are weighed: to either side of the start."""

    linear: float  # [m]
    angular: float  # [rad]
    angular_step: float  # [rad]


def picture(reach: float, resolution: float, std: float) -> Picture:
    """Room for a picture of points up to `reach` [m] away from the origin."""
    blocks = max(1, math.ceil(2.0 * (reach + _SPREAD * std) / (resolution * BLOCK)))
    side = blocks * BLOCK
    corner = np.full(2, -0.5 * side * resolution)
    return Picture(resolution, std, corner, np.zeros((side, side), np.float32), np.zeros((blocks, blocks), np.float32))


@kernel
def draw(points: Array, out: Picture) -> None:
    """Draw points (k, 2) [m], and forget those drawn before."""
    out.fine[:] = 0.0
    out.coarse[:] = 0.0
    add(points, 0.0, 0.0, 0.0, out)


@part
def add(points: Array, x: float, y: float, heading: float, out: Picture) -> None:
    """Draw more points (k, 2) [m], those of a robot at (x, y, heading)."""
    c = math.cos(heading)
    s = math.sin(heading)
    side = out.fine.shape[0]
    reach = math.ceil(_SPREAD * out.std / out.resolution)
    scale = -0.5 * (out.resolution / out.std) ** 2
    for i in range(points.shape[0]):
        if math.isnan(points[i, 0]):
            continue
        u = (x + c * points[i, 0] - s * points[i, 1] - out.corner[0]) / out.resolution
        v = (y + s * points[i, 0] + c * points[i, 1] - out.corner[1]) / out.resolution
        col = math.floor(u)
        row = math.floor(v)
        for r in range(max(row - reach, 0), min(row + reach + 1, side)):
            for k in range(max(col - reach, 0), min(col + reach + 1, side)):
                dx = k + 0.5 - u
                dy = r + 0.5 - v
                value = np.float32(math.exp(scale * (dx * dx + dy * dy)))
                if value > out.fine[r, k]:
                    out.fine[r, k] = value
                    if value > out.coarse[r // BLOCK, k // BLOCK]:
                        out.coarse[r // BLOCK, k // BLOCK] = value


@kernel
def clear(points: Array, x: float, y: float, out: Picture) -> None:
    """Mark as free the cells that beams from (x, y) [m] to points (k, 2) [m] cross, except near a point."""
    side = out.fine.shape[0]
    u = (x - out.corner[0]) / out.resolution
    v = (y - out.corner[1]) / out.resolution
    margin = _CLEAR * out.std / out.resolution
    free = np.float32(-_PASSED)
    for i in range(points.shape[0]):
        if math.isnan(points[i, 0]):
            continue
        du = (points[i, 0] - x) / out.resolution
        dv = (points[i, 1] - y) / out.resolution
        length = math.sqrt(du * du + dv * dv)
        for step in range(1, int(length - margin)):
            col = math.floor(u + du * step / length)
            row = math.floor(v + dv * step / length)
            for r in range(max(row - 1, 0), min(row + 2, side)):
                for k in range(max(col - 1, 0), min(col + 2, side)):
                    if out.fine[r, k] == 0.0:
                        out.fine[r, k] = free


@kernel
def weigh(on: Picture, points: Array, pose: Array) -> float:
    """How well points (k, 2) at a pose (3,) fit a picture: the mean of their cells, 0 for no points."""
    side = on.fine.shape[0]
    c = math.cos(pose[2])
    s = math.sin(pose[2])
    total: Any = 0.0
    count = 0
    for i in range(points.shape[0]):
        if math.isnan(points[i, 0]):
            continue
        count += 1
        col = math.floor((pose[0] + c * points[i, 0] - s * points[i, 1] - on.corner[0]) / on.resolution)
        row = math.floor((pose[1] + s * points[i, 0] + c * points[i, 1] - on.corner[1]) / on.resolution)
        if 0 <= row < side and 0 <= col < side:
            total += on.fine[row, col]
    return float(total) / count if count > 0 else 0.0


@part
def _fine(on: Picture, cells: Ints, count: int, row: int, col: int) -> float:
    """The sum of the picture's values in `count` cells that are moved by (row, col)."""
    side = on.fine.shape[0]
    total: Any = 0.0
    for i in range(count):
        r = cells[i, 0] + row
        k = cells[i, 1] + col
        if 0 <= r < side and 0 <= k < side:
            total += on.fine[r, k]
    return float(total)


@part
def _coarse(on: Picture, cells: Ints, count: int, row: int, col: int) -> float:
    """An upper bound of the sum for `count` cells moved by (row, col) or by up to BLOCK - 1 cells more."""
    blocks = on.coarse.shape[0]
    total: Any = 0.0
    for i in range(count):
        r = (cells[i, 0] + row) // BLOCK
        k = (cells[i, 1] + col) // BLOCK
        most = np.float32(0.0)
        for br in range(max(r, 0), min(r + 2, blocks)):
            for bk in range(max(k, 0), min(k + 2, blocks)):
                most = max(most, on.coarse[br, bk])
        total += most
    return float(total)


@kernel
def correlate(on: Picture, points: Array, start: Array, window: Window, cells: Ints, out: Array) -> float:
    """Find the pose (3,) in a window around `start` (3,) at which points (k, 2) fit a picture best; returns how well.

    How well is from 0, not at all, to 1, and a little less away from the start. `cells` is room for (k, 2) numbers. Of
    equal poses the one tried first wins: headings from the start outwards, then rows and columns.
    """
    turns = math.ceil(window.angular / window.angular_step - 1e-9) if window.angular > 0.0 else 0
    reach = math.ceil(window.linear / on.resolution - 1e-9)
    best = -math.inf
    count = 0
    out[:] = start
    for k in range(2 * turns + 1):
        turn = ((k + 1) // 2) * (1 if k % 2 else -1) * window.angular_step
        c = math.cos(start[2] + turn)
        s = math.sin(start[2] + turn)
        share = turn / window.angular if turns > 0 else 0.0
        turned = _PULL * share * share
        count = 0
        for i in range(points.shape[0]):
            if math.isnan(points[i, 0]):
                continue
            x = start[0] + c * points[i, 0] - s * points[i, 1] - on.corner[0]
            y = start[1] + s * points[i, 0] + c * points[i, 1] - on.corner[1]
            cells[count, 0] = math.floor(y / on.resolution)
            cells[count, 1] = math.floor(x / on.resolution)
            count += 1
        if count == 0:
            return 0.0
        for row in range(-reach, reach + 1, BLOCK):
            for col in range(-reach, reach + 1, BLOCK):
                if _coarse(on, cells, count, row, col) - turned * count <= best:
                    continue
                for r in range(row, min(row + BLOCK, reach + 1)):
                    for q in range(col, min(col + BLOCK, reach + 1)):
                        aside = _PULL * (r * r + q * q) / (reach * reach) if reach > 0 else 0.0
                        value = _fine(on, cells, count, r, q) - (turned + aside) * count
                        if value > best:
                            best = value
                            out[0] = start[0] + q * on.resolution
                            out[1] = start[1] + r * on.resolution
                            out[2] = wrap(start[2] + turn)
    return best / count
