"""Scans as points and short lines: where each beam ended, and the surface around that place."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from amorsim.array_types import Array
from amorsim.kernels.compile import kernel, part

__all__ = ["Outline", "new_outline", "outline", "outlines"]


_REACH = 0.15  # [m] around a point, from which its line is fitted ...
_BEAMS = 2.5  # ... or so many distances between beams, if that is farther
_NEXT = 1.6  # or so many distances to the next point
_FARTHEST = 1.0  # [m]
_STRAIGHT = 0.1  # largest ratio of the spreads across and along a line
_MOST = 12  # beams to either side
_LOST = 3  # beams in a row, at most, that saw nothing between two points of a line: a reading that was lost is no gap
_STRAIGHTER = 4.0  # how many times less the points to one side spread across their line where there is a corner


class Outline(NamedTuple):
    """A scan in its robot's frame; nan where a beam saw nothing, lines also where there is no clear surface."""

    points: Array  # (k, 2) [m]
    lines: Array  # (k, 4) a point of the surface [m], and its unit normal towards the laser
    rays: Array  # (k, 2) unit directions of the beams


def new_outline(beams: int) -> Outline:
    """Room for an outline of so many beams."""
    return Outline(np.empty((beams, 2)), np.empty((beams, 4)), np.empty((beams, 2)))


@part
def outline(ranges: Array, cos_b: Array, sin_b: Array, range_max: float, mount: Array, out: Outline) -> None:
    """The outline of a scan (k,) of a laser at `mount` (3,) on its robot."""
    count = ranges.shape[0]
    c = math.cos(mount[2])
    s = math.sin(mount[2])
    for i in range(count):
        dx = c * cos_b[i] - s * sin_b[i]
        dy = s * cos_b[i] + c * sin_b[i]
        out.rays[i, 0] = dx
        out.rays[i, 1] = dy
        is_seen = 0.0 < ranges[i] <= range_max and ranges[i] < math.inf
        out.points[i, 0] = mount[0] + ranges[i] * dx if is_seen else math.nan
        out.points[i, 1] = mount[1] + ranges[i] * dy if is_seen else math.nan
    for i in range(count):
        _line(ranges, i, out)


@part
def _line(ranges: Array, i: int, out: Outline) -> None:
    """Fit a line through the points around point i: their mean, and the direction of their least spread.

    Where the points to one side alone lie much straighter, there is a corner, and the line is theirs.
    """
    count = ranges.shape[0]
    for j in range(4):
        out.lines[i, j] = math.nan
    if math.isnan(out.points[i, 0]):
        return
    other = i + 1 if i + 1 < count else i - 1
    if other < 0:
        return
    turn = out.rays[i, 0] * out.rays[other, 1] - out.rays[i, 1] * out.rays[other, 0]
    reach = min(max(_REACH, _BEAMS * ranges[i] * abs(turn), _NEXT * _nearest_neighbour(out, i)), _FARTHEST)
    first = _end(out, i, -1, reach)
    last = _end(out, i, 1, reach)
    x, y, angle, spread = _fit(out, i, first, last)
    if spread > 0.0:
        for side in range(2):
            u, v, slope, aside = _fit(out, i, first, i) if side == 0 else _fit(out, i, i, last)
            if aside * _STRAIGHTER < spread:
                x = u
                y = v
                angle = slope
                spread = aside * _STRAIGHTER
    if not spread < math.inf:
        return
    nx = -math.sin(angle)
    ny = math.cos(angle)
    if nx * out.rays[i, 0] + ny * out.rays[i, 1] > 0.0:
        nx = -nx
        ny = -ny
    out.lines[i, 0] = x
    out.lines[i, 1] = y
    out.lines[i, 2] = nx
    out.lines[i, 3] = ny


@part
def _nearest_neighbour(of: Outline, i: int) -> float:
    """The distance [m] of point i from the nearer one of the next points to either side; inf if there are none."""
    least = math.inf
    for step in (-1, 1):
        j = _next_seen(of, i, step)
        if j >= 0:
            least = min(least, math.hypot(of.points[j, 0] - of.points[i, 0], of.points[j, 1] - of.points[i, 1]))
    return least


@part
def _next_seen(of: Outline, i: int, step: int) -> int:
    """The next beam from beam i on that saw something, past at most `_LOST` that did not; -1 if there is none."""
    for n in range(1, _LOST + 2):
        j = i + step * n
        if not 0 <= j < of.points.shape[0]:
            return -1
        if not math.isnan(of.points[j, 0]):
            return j
    return -1


@part
def _end(of: Outline, i: int, step: int, reach: float) -> int:
    """The last beam from beam i on up to which all points are within `reach` [m] of point i."""
    last = i
    for _ in range(_MOST):
        j = _next_seen(of, last, step)
        if j < 0 or abs(j - i) > _MOST:
            break
        dx = of.points[j, 0] - of.points[i, 0]
        dy = of.points[j, 1] - of.points[i, 1]
        if not dx * dx + dy * dy <= reach * reach:
            break
        last = j
    return last


@part
def _fit(of: Outline, i: int, first: int, last: int) -> tuple[float, float, float, float]:
    """The line through the points of some beams: a point of it, its direction [rad], and their variance across [m^2].

    The variance is inf if they are fewer than three, or do not lie along a line.
    """
    x = of.points[i, 0]
    y = of.points[i, 1]
    sx = 0.0
    sy = 0.0
    sxx = 0.0
    sxy = 0.0
    syy = 0.0
    n = 0
    for j in range(first, last + 1):
        if math.isnan(of.points[j, 0]):
            continue
        n += 1
        dx = of.points[j, 0] - x
        dy = of.points[j, 1] - y
        sx += dx
        sy += dy
        sxx += dx * dx
        sxy += dx * dy
        syy += dy * dy
    if n < 3:
        return x, y, 0.0, math.inf
    sx /= n
    sy /= n
    a = sxx / n - sx * sx
    b = sxy / n - sx * sy
    d = syy / n - sy * sy
    # The eigenvalues of the 2 x 2 matrix of spreads.
    half = 0.5 * (a - d)
    root = math.sqrt(half * half + b * b)
    mean = 0.5 * (a + d)
    if not mean - root <= _STRAIGHT * (mean + root):
        return x, y, 0.0, math.inf
    return x + sx, y + sy, 0.5 * math.atan2(2.0 * b, a - d), max(0.0, mean - root) * n / (n - 2)


@kernel
def outlines(
    ranges: Array,
    cos_b: Array,
    sin_b: Array,
    range_max: Array,
    mounts: Array,
    points: Array,
    lines: Array,
    rays: Array,
) -> None:
    """Outlines of scans (N, k), into points (N, k, 2), lines (N, k, 4) and rays (N, k, 2); see `Outline`."""
    for i in range(ranges.shape[0]):
        b = i if cos_b.shape[0] > 1 else 0
        reach = range_max[i if range_max.shape[0] > 1 else 0, 0]
        outline(ranges[i], cos_b[b], sin_b[b], reach, mounts[i], Outline(points[i], lines[i], rays[i]))
