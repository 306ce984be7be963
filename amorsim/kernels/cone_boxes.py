"""A cone's nearest return from walls that are boxes of cells, all occupied: told by quotients, with no ray cast.

A ray enters such a box by the side that it meets, at the quotient that defines a distance (`amorsim.kernels.rays`).
Along a side the distance grows from the ray nearest to square on to either hand, so of all rays of a cone one or two
are asked.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from amorsim.kernels.compile import part
from amorsim.kernels.cone_cells import SAFETY
from amorsim.kernels.rays import direction

__all__ = ["bearing_of", "enter_box", "rays_between"]

Floats = NDArray[np.float64]

_NEXT = 0.05  # [rays] within which a wall that ends beside a ray counts as met; so rough are bearings


@part
def bearing_of(x: float, y: float) -> float:
    """The angle [rad] of a direction, to 4e-6: good for telling which rays are about it.

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
def rays_between(
    x0: float, y0: float, x1: float, y1: float, half_angle: float, step: float, rays: int
) -> tuple[int, int]:
    """First and last ray of a cone from one direction anticlockwise to another; the last before the first if none."""
    low = bearing_of(x0, y0)
    high = bearing_of(x1, y1)
    if high < low:
        if high >= -half_angle - step:
            low -= 2.0 * math.pi
        else:
            high += 2.0 * math.pi
    first = max(math.ceil((low + half_angle) / step - _NEXT), 0.0)
    last = min(math.floor((high + half_angle) / step + _NEXT), rays - 1.0)
    return int(first), int(last)


@part
def _into(low: float, high: float, cell: int, resolution: float, start: float, component: float) -> tuple[float, float]:
    """Where a ray from a cell of an axis comes between two grid lines, and where it leaves for good.

    -inf where it is there, and inf where it never gets there.
    """
    line = low if component > 0.0 else high
    into = (line * resolution - start) / component
    if low <= cell < high:
        into = -np.inf
    elif component == 0.0 or (component > 0.0) != (cell < low):
        into = np.inf
    line = high if component > 0.0 else low
    out = (line * resolution - start) / component if component != 0.0 else np.inf
    return into, out


@part
def _least_by_side(
    across: bool,
    col0: float,
    row0: float,
    col1: float,
    row1: float,
    col: int,
    row: int,
    resolution: float,
    x: float,
    y: float,
    cos_h: float,
    sin_h: float,
    cos_b: Floats,
    sin_b: Floats,
    first: int,
    last: int,
    square: float,
    least: float,
) -> float:
    """The less of `least` and the distance at which any of rays first..last enters a box by the side along one axis.

    `square` is the number of the ray that would meet the side squarely, `across` whether that side is a grid line of x.
    """
    k = first
    way = 1
    if square >= last:
        k = last
        way = -1
    elif square > first:
        k = math.floor(square)
    while first <= k <= last:
        dx, dy = direction(cos_h, sin_h, cos_b[0, k], sin_b[0, k])
        into_x, out_x = _into(col0, col1, col, resolution, x, dx)
        into_y, out_y = _into(row0, row1, row, resolution, y, dy)
        # It gets in if neither axis leaves before the other is in; where both happen at once, x is first.
        if into_x <= out_y and into_y < out_x:
            into = max(into_x, into_y)
            if into < least:
                least = into
            by_side = into_x >= into_y if across else into_y >= into_x
            # The next one is nearer only where this one is just short of square.
            if by_side and (k >= square or way < 0):
                break
        k += way
    return least


@part
def enter_box(
    col0: float,
    row0: float,
    col1: float,
    row1: float,
    col: int,
    row: int,
    resolution: float,
    x: float,
    y: float,
    cos_h: float,
    sin_h: float,
    half_angle: float,
    step: float,
    square: float,
    cos_b: Floats,
    sin_b: Floats,
    least: float,
) -> float:
    """The less of `least` and the distance at which any ray of a cone enters a box of occupied cells.

    Parameters
    ----------
    col0, row0, col1, row1
        The grid lines that bound the box.
    col, row
        The free cell of the cone's point (x, y).
    square
        Number of the ray along the map's x axis, in a turn about the middle of the cone.
    """
    rays = cos_b.shape[1]
    x0 = col0 * resolution - x
    x1 = col1 * resolution - x
    y0 = row0 * resolution - y
    y1 = row1 * resolution - y
    quarter = 0.5 * math.pi / step
    middle = 0.5 * (rays - 1)
    for across in (True, False):
        if across:
            before = col < col0
            beyond = col >= col1
            near = x0 if before else x1
            turns = 0.0 if before else 2.0
            right_x, right_y, left_x, left_y = near, (y0 if before else y1), near, (y1 if before else y0)
        else:
            before = row < row0
            beyond = row >= row1
            near = y0 if before else y1
            turns = 1.0 if before else 3.0
            right_x, right_y, left_x, left_y = (x1 if before else x0), near, (x0 if before else x1), near
        if not (before or beyond) or abs(near) > least * (1.0 + SAFETY):
            continue
        first, last = rays_between(
            cos_h * right_x + sin_h * right_y,
            cos_h * right_y - sin_h * right_x,
            cos_h * left_x + sin_h * left_y,
            cos_h * left_y - sin_h * left_x,
            half_angle,
            step,
            rays,
        )
        if first > last:
            continue
        to = square + turns * quarter
        if to - middle > 2.0 * quarter:
            to -= 4.0 * quarter
        least = _least_by_side(
            across,
            col0,
            row0,
            col1,
            row1,
            col,
            row,
            resolution,
            x,
            y,
            cos_h,
            sin_h,
            cos_b,
            sin_b,
            first,
            last,
            to,
            least,
        )
    return least
