"""Walls that a map was drawn from, as bounds on where a ray may first meet an occupied cell.

A segment occupies the cells that its closed line touches, so all of them lie in a rectangle: the segment, grown on
every side by what a cell reaches beyond a point of it. Seen from outside it, a rectangle covers an interval of
bearings, and lies beyond a line: that of its near side, or of its near end. Along a beam of direction d the line
n . q = c is met where 1/t = (n . d) / c. That is linear in d, so the greatest 1/t of all rectangles over the beams of a
scan is a one-dimensional depth buffer, filled without a division, several beams at a time. Nothing is occupied before
it. What it is good for depends on how tight it is; the bits of the grid decide what is read.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from amorsim.kernels.compile import kernel

__all__ = ["SAFETY", "Lines", "bound_scan", "bucket_of", "lines_of", "no_lines"]

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

SAFETY = 1e-9
"""Relative, on every bound: many times the roundings on the way to it."""
_SLACK = 1e-3  # [cells] by which rectangles are larger than need be, for end points snapped to grid lines and roundings
_BLOCK = 16  # segments whose distance is asked for at once
_MOST = 2  # segments near a scan, for each of its beams, from which on bounds cost more than they save
_EDGE = 1e-12  # [of a quarter turn] by which a rectangle covers more than it does


class Lines(NamedTuple):
    """Segments of a map in its own frame [m], in blocks of neighbours."""

    boxes: Floats
    """(blocks, 4) xmin, ymin, xmax, ymax of the occupied cells of a block's segments."""
    first: Integers
    """(blocks + 1,): a block's first segment, and one past its last, that of the next."""
    walls: Floats
    """(M, 6) x0, y0; unit vector along the segment; length; how far its cells reach beyond it."""


@kernel
def bucket_of(x: float, y: float, beyond: float, scale: float) -> int:
    """Which of ``4 * scale`` sectors the direction (x, y) is in; `beyond` is added to its place in quarter turns.

    Sectors are of equal steps not of the angle but of one that grows with it and needs no arc tangent.
    """
    sum_ = abs(x) + abs(y)
    part = y / sum_ if sum_ > 0.0 else 0.0
    place = (part if y >= 0.0 else 4.0 + part) if x >= 0.0 else 2.0 - part
    place += beyond
    if place < 0.0:
        place += 4.0
    if place >= 4.0:
        place -= 4.0
    return min(int(place * scale), int(4.0 * scale) - 1)


@kernel
def _is_near(lines: Lines, block: int, x: float, y: float, reach: float) -> bool:
    """Whether anything that a block's segments occupy may be within reach."""
    away_x = max(lines.boxes[block, 0] - x, 0.0, x - lines.boxes[block, 2])
    away_y = max(lines.boxes[block, 1] - y, 0.0, y - lines.boxes[block, 3])
    return bool(away_x * away_x + away_y * away_y <= reach * reach)


@kernel
def _raise(low: int, high: int, a: float, b: float, cos_b: Floats, sin_b: Floats, nearness: Floats) -> None:
    """Let beams low..high-1 be at least as near as a line with a * x + b * y = 1."""
    for i in range(np.uint64(low), np.uint64(high)):
        value = a * cos_b[i] + b * sin_b[i]
        nearness[i] = value if value > nearness[i] else nearness[i]


@kernel
def bound_scan(
    lines: Lines,
    x: float,
    y: float,
    cos_h: float,
    sin_h: float,
    reach: float,
    starts: Integers,
    scale: float,
    cos_b: Floats,
    sin_b: Floats,
    nearness: Floats,
) -> bool:
    """Raise `nearness` (k,) [1/m] to 1/t, where no beam meets an occupied cell before t.

    Returns False, and `nearness` says nothing, from where no wall can be told from its start, and where too many are
    near for this to pay.

    Parameters
    ----------
    x, y, cos_h, sin_h
        Where the scan is taken from, and its heading, in the map's frame.
    reach
        [m]: walls farther away are passed over.
    starts, scale
        The sectors of `bucket_of`: beams starts[s] to starts[s + 1] - 1 are in sector s.
    cos_b, sin_b
        (k,): beams in the order of their sectors.
    """
    last = len(starts) - 2
    walls = lines.walls
    left = _MOST * len(cos_b)
    # Blocks hold some that are not near: where there are twice too many, none need be looked at to tell.
    about = 2 * left
    for block in range(lines.boxes.shape[0]):
        if _is_near(lines, block, x, y, reach):
            about -= lines.first[block + 1] - lines.first[block]
    if about < 0:
        return False
    for block in range(lines.boxes.shape[0]):
        if not _is_near(lines, block, x, y, reach):
            continue
        for m in range(lines.first[block], lines.first[block + 1]):
            tx = walls[m, 2]
            ty = walls[m, 3]
            margin = walls[m, 5]
            to_x = walls[m, 0] - x
            to_y = walls[m, 1] - y
            # Across and along the segment, so turned that it runs anticlockwise as seen from here.
            across = ty * to_x - tx * to_y
            along = tx * to_x + ty * to_y
            length = walls[m, 4]
            if across < 0.0:
                across = -across
                along = -along - length
                tx, ty = -tx, -ty
            near = across - margin
            start = along - margin
            stop = along + length + margin
            if near > reach or start > reach or stop < -reach:
                continue
            left -= 1
            if left < 0:
                return False
            # The segment's direction as the beams count bearings.
            ux = cos_h * tx + sin_h * ty
            uy = cos_h * ty - sin_h * tx
            far = across + margin
            if near > margin:
                a = uy / near
                b = -ux / near
                first_n = far if start > 0.0 else near
                last_n = far if stop < 0.0 else near
            elif start > 0.0:
                a = ux / start
                b = uy / start
                first_n, last_n, stop = far, near, (start if near <= 0.0 else stop)
            elif stop < 0.0:
                a = ux / stop
                b = uy / stop
                first_n, last_n, start = near, far, (stop if near <= 0.0 else start)
            elif near > 0.0:
                a = uy / near
                b = -ux / near
                first_n = last_n = near
            else:
                return False
            low = bucket_of(first_n * uy + start * ux, start * uy - first_n * ux, -_EDGE, scale)
            high = bucket_of(last_n * uy + stop * ux, stop * uy - last_n * ux, _EDGE, scale)
            if low <= high:
                _raise(starts[low], starts[high + 1], a, b, cos_b, sin_b, nearness)
            else:
                _raise(starts[low], starts[last + 1], a, b, cos_b, sin_b, nearness)
                _raise(starts[0], starts[high + 1], a, b, cos_b, sin_b, nearness)
    return True


def no_lines() -> Lines:
    """Lines of a map that has none."""
    return Lines(np.empty((0, 4)), np.zeros(1, dtype=np.int64), np.empty((0, 6)))


def lines_of(segments: Floats, rows: int, cols: int, resolution: float, margins: Floats | None = None) -> Lines:
    """Lines of segments (M, 4), x0 y0 x1 y1 [m] in the frame of a map of rows x cols cells, and of the map's border.

    `margins` (M,) [m] says how far what is occupied reaches beyond each segment; where not given it is the cells that
    the segment touches. The border is needed because outside is occupied: a beam that no segment covers ends there.
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
        margin = np.append(margins, np.full(4, resolution * _SLACK))
    order = np.argsort(_curve(ends, max(width, height)), kind="stable")
    walls = np.concatenate([ends[:, :2], unit, length[:, None], margin[:, None]], axis=1)[order]
    ends, margin = ends[order], margin[order]
    block = _BLOCK * max(1, math.isqrt(len(ends)) // (4 * _BLOCK))
    first = np.append(np.arange(0, len(ends), block), len(ends))
    beyond = 1.5 * margin[:, None]  # the corner of a rectangle is the square root of 2 margins away
    low = np.minimum.reduceat(np.minimum(ends[:, :2], ends[:, 2:]) - beyond, first[:-1])
    high = np.maximum.reduceat(np.maximum(ends[:, :2], ends[:, 2:]) + beyond, first[:-1])
    return Lines(np.concatenate([low, high], axis=1), first.astype(np.int64), np.ascontiguousarray(walls))


def _curve(ends: Floats, size: float) -> Any:
    """Place of each segment's middle on a Morton curve through the map: neighbours on it are near one another."""
    middle = (ends[:, :2] + ends[:, 2:]) / 2.0
    steps = np.clip(middle / size * 65536.0, 0, 65535).astype(np.int64)
    place = np.zeros(len(ends), dtype=np.int64)
    for bit in range(16):
        for axis in range(2):
            place |= ((steps[:, axis] >> bit) & 1) << (2 * bit + axis)
    return place
