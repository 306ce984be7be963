"""A cone's nearest return from a wall that is a box of occupied cells: from quotients, with no ray cast.

A ray enters such a box by a side that it meets, at the quotient that defines a distance
(`amorsim.kernels.raycast.rays`). Along a side the distance grows to both sides of its nearest point, so only the
rays around that point are tested.
"""

from __future__ import annotations

import math

import numpy as np

from amorsim.array_types import Array
from amorsim.kernels.compile import part
from amorsim.kernels.raycast.rays import direction

__all__ = ["NEXT", "bearing_of", "enter_box"]


NEXT = 0.05  # [rays] within which things next to a ray count as hit, because bearings are that rough


@part
def bearing_of(x: float, y: float) -> float:
    """The angle [rad] of a direction, to 4e-6: enough to find the rays next to it.

    The arc tangent of z up to 1 is z times a polynomial in z * z, here fitted at Chebyshev's points.
    """
    low = min(abs(x), abs(y))
    high = max(abs(x), abs(y))
    z = low / high if high > 0.0 else 0.0
    w = z * z
    angle = 0.05733179602962784 - 0.01342247840194614 * w
    angle = 0.19558996708261733 + w * (-0.12111113029350314 + w * angle)
    angle = z * (0.9999955182994817 + w * (-0.3329888274017294 + w * angle))
    if abs(y) > abs(x):
        angle = 0.5 * math.pi - angle
    if x < 0.0:
        angle = math.pi - angle
    return angle if y >= 0.0 else -angle


@part
def _between(
    low: float, high: float, cell: int, resolution: float, start: float, component: float
) -> tuple[float, float]:
    """The distances at which a ray from a cell of an axis gets between two grid lines, and leaves them.

    -inf where it is there, and inf where it never gets there.
    """
    up = component > 0.0
    into = ((low if up else high) * resolution - start) / component
    out = ((high if up else low) * resolution - start) / component
    never = (component == 0.0) | (up != (cell < low))
    into = np.inf if never else into
    into = -np.inf if (low <= cell) & (cell < high) else into
    return into, (np.inf if component == 0.0 else out)


@part
def enter_box(
    walls: Array,
    m: int,
    col: int,
    row: int,
    resolution: float,
    x: float,
    y: float,
    cos_h: float,
    sin_h: float,
    cos_b: Array,
    sin_b: Array,
    about: float,
    least: float,
    nearest: int,
) -> tuple[float, int]:
    """The less of `least` and the distance at which one of the rays next to number `about` enters the box of wall `m`.

    And the number of its ray, where that of `least` is `nearest`: the lowest of those that go as far. The cone's point
    (x, y) is in the free cell (row, col).
    """
    last = cos_b.shape[1] - 1
    first = math.floor(about - NEXT)
    # Mostly two, but three where roundings may have put it beyond the second.
    for j in range(2 if about + NEXT < first + 1.0 else 3):
        k = min(max(first + j, 0), last)
        dx, dy = direction(cos_h, sin_h, cos_b[0, k], sin_b[0, k])
        into_x, out_x = _between(walls[6, m], walls[8, m], col, resolution, x, dx)
        into_y, out_y = _between(walls[7, m], walls[9, m], row, resolution, y, dy)
        # It gets in if neither axis leaves before the other is in; where both happen at once, x is first.
        into = max(into_x, into_y)
        is_nearer = (into < least) | ((into == least) & (k < nearest))
        gets_in = (into_x <= out_y) & (into_y < out_x) & is_nearer
        least = into if gets_in else least
        nearest = k if gets_in else nearest
    return least, nearest
