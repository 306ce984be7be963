"""Keys: the points of the last scans, in the frame of the newest of them."""

from __future__ import annotations

import math

from amorsim.array_types import Array
from amorsim.kernels.compile import kernel, part
from amorsim.kernels.matching import icp
from amorsim.kernels.matching.outlines import Outline

__all__ = ["extend"]


_FARTHEST = 20.0  # [m] from the robot that points of before are kept
_APART = 0.1  # [m] from a new point that older ones are kept
_THROUGH = 0.05  # [m] from a beam at which it passes through a point ...
_BEFORE = 0.3  # [m] ... that is so far before its end


@part
def _is_superseded(x: float, y: float, scan: Outline) -> bool:
    """Whether an older point is where the new scan has one, or the new scan sees through it."""
    for j in range(scan.points.shape[0]):
        px = scan.points[j, 0]
        if math.isnan(px):
            continue
        py = scan.points[j, 1]
        dx = x - px
        dy = y - py
        if dx * dx + dy * dy < _APART * _APART:
            return True
        across = dx * scan.rays[j, 1] - dy * scan.rays[j, 0]
        along = dx * scan.rays[j, 0] + dy * scan.rays[j, 1]
        if -_THROUGH < across < _THROUGH and _BEFORE - math.sqrt(px * px + py * py) < along < -_BEFORE:
            return True
    return False


@part
def _copy(points: Array, lines: Array, j: int, key: icp.Reference, place: int) -> None:
    """Copy a point and its line to a place in a key."""
    for k in range(2):
        key.points[place, k] = points[j, k]
    for k in range(4):
        key.lines[place, k] = lines[j, k]


@kernel
def extend(scan: Outline, key: icp.Reference, moved: Array) -> None:
    """Add a scan to a key, whose frame becomes the scan's; `moved` (3,) is that frame in the key's.

    Points of before are kept, the oldest first, where the scan shows nothing. Where there is no room for all of them,
    the oldest are left out.
    """
    c = math.cos(moved[2])
    s = math.sin(moved[2])
    size = key.points.shape[0]
    count = 0
    for j in range(size):
        if math.isnan(key.points[j, 0]):
            break
        x, y = _turned(key.points[j, 0] - moved[0], key.points[j, 1] - moved[1], c, s)
        if x * x + y * y > _FARTHEST * _FARTHEST or _is_superseded(x, y, scan):
            continue
        key.points[count, 0] = x
        key.points[count, 1] = y
        u, v = _turned(key.lines[j, 0] - moved[0], key.lines[j, 1] - moved[1], c, s)
        key.lines[count, 0] = u
        key.lines[count, 1] = v
        key.lines[count, 2], key.lines[count, 3] = _turned(key.lines[j, 2], key.lines[j, 3], c, s)
        count += 1
    new = 0
    for j in range(scan.points.shape[0]):
        if not math.isnan(scan.points[j, 0]):
            new += 1
    surplus = max(0, count + new - size)
    count -= surplus
    for j in range(count):
        _copy(key.points, key.lines, j + surplus, key, j)
    for j in range(scan.points.shape[0]):
        if not math.isnan(scan.points[j, 0]):
            _copy(scan.points, scan.lines, j, key, count)
            count += 1
    for j in range(count, size):
        for k in range(2):
            key.points[j, k] = math.nan
        for k in range(4):
            key.lines[j, k] = math.nan
    icp.index(key)


@part
def _turned(x: float, y: float, c: float, s: float) -> tuple[float, float]:
    """A vector in a frame that is turned by the angle of cosine c and sine s."""
    return c * x + s * y, c * y - s * x
