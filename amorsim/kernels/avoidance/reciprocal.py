"""Optimal reciprocal collision avoidance (ORCA): half-planes of velocities, and the one nearest to the wanted one.

After J. van den Berg, S. J. Guy, M. Lin and D. Manocha, "Reciprocal n-body collision avoidance", ISRR 2009, and its
authors' RVO2 library, whose steps it takes in the same order.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from amorsim.array_types import Array
from amorsim.kernels.compile import kernel, part

__all__ = ["half_plane", "nearest_velocity", "reciprocal_velocities"]

Column = Any

_PARALLEL = 1e-5  # determinant of two directions that count as parallel


@part
def half_plane(
    x: float,
    y: float,
    vx: float,
    vy: float,
    own_x: float,
    own_y: float,
    both: float,
    horizon: float,
    dt: float,
    out: Array,
) -> None:
    """The border of the velocities that ORCA permits, into `out` (4,): a point on it, and its direction; free left.

    Another is at (x, y) [m] with (vx, vy) [m/s], `both` [m] is the sum of the radii. It takes half of the change that
    keeps the two apart for `horizon` [s], or that parts them within `dt` [s] if they overlap.
    """
    rx = own_x - vx
    ry = own_y - vy
    square = x * x + y * y
    apart = square > both * both
    inverse = 1.0 / horizon if apart else 1.0 / dt
    # From the centre of the cut-off circle to the relative velocity.
    wx = rx - inverse * x
    wy = ry - inverse * y
    w_square = wx * wx + wy * wy
    dot = wx * x + wy * y
    if not apart or (dot < 0.0 and dot * dot > both * both * w_square):
        length = math.sqrt(w_square)
        ux = wx / length if length > 0.0 else 1.0
        uy = wy / length if length > 0.0 else 0.0
        change = both * inverse - length
        out[2] = uy
        out[3] = -ux
        out[0] = own_x + 0.5 * change * ux
        out[1] = own_y + 0.5 * change * uy
        return
    leg = math.sqrt(square - both * both)
    if x * wy - y * wx > 0.0:
        out[2] = (x * leg - y * both) / square
        out[3] = (x * both + y * leg) / square
    else:
        out[2] = -(x * leg + y * both) / square
        out[3] = -(-x * both + y * leg) / square
    along = rx * out[2] + ry * out[3]
    out[0] = own_x + 0.5 * (along * out[2] - rx)
    out[1] = own_y + 0.5 * (along * out[3] - ry)


@part
def _on_line(lines: Array, number: int, most: float, wx: float, wy: float, farthest: bool, out: Array) -> bool:
    """The best velocity on a border among those that earlier ones permit, into `out` (2,); whether there is any."""
    px, py, dx, dy = lines[number, 0], lines[number, 1], lines[number, 2], lines[number, 3]
    dot = px * dx + py * dy
    inside = dot * dot + most * most - px * px - py * py
    if inside < 0.0:
        return False
    root = math.sqrt(inside)
    low = -dot - root
    high = -dot + root
    for i in range(number):
        denominator = dx * lines[i, 3] - dy * lines[i, 2]
        numerator = lines[i, 2] * (py - lines[i, 1]) - lines[i, 3] * (px - lines[i, 0])
        if abs(denominator) <= _PARALLEL:
            if numerator < 0.0:
                return False
            continue
        t = numerator / denominator
        if denominator >= 0.0:
            high = min(high, t)
        else:
            low = max(low, t)
        if low > high:
            return False
    t = min(max(dx * (wx - px) + dy * (wy - py), low), high)
    if farthest:
        t = high if wx * dx + wy * dy > 0.0 else low
    out[0] = px + t * dx
    out[1] = py + t * dy
    return True


@part
def _within(lines: Array, count: int, most: float, wx: float, wy: float, farthest: bool, out: Array) -> int:
    """The best velocity that all borders permit, into `out` (2,); the number of the first that cannot be kept."""
    size = math.sqrt(wx * wx + wy * wy)
    out[0] = wx
    out[1] = wy
    if farthest or size > most:
        out[0] = wx * most if farthest else wx / size * most
        out[1] = wy * most if farthest else wy / size * most
    for i in range(count):
        if lines[i, 2] * (lines[i, 1] - out[1]) - lines[i, 3] * (lines[i, 0] - out[0]) > 0.0:
            before_x = out[0]
            before_y = out[1]
            if not _on_line(lines, i, most, wx, wy, farthest, out):
                out[0] = before_x
                out[1] = before_y
                return i
    return count


@part
def nearest_velocity(lines: Array, count: int, most: float, wx: float, wy: float, scratch: Array, out: Array) -> bool:
    """The velocity nearest to (wx, wy), no faster than `most`, that `count` borders (n, 4) permit, into `out` (2,).

    If none is permitted by all, the one that breaks the worst of them least. Returns whether all are kept. `scratch`
    is as large as `lines`.
    """
    failed = _within(lines, count, most, wx, wy, False, out)
    if failed == count:
        return True
    worst = 0.0
    for i in range(failed, count):
        px, py, dx, dy = lines[i, 0], lines[i, 1], lines[i, 2], lines[i, 3]
        if dx * (py - out[1]) - dy * (px - out[0]) <= worst:
            continue
        kept = 0
        for j in range(i):
            qx, qy, ex, ey = lines[j, 0], lines[j, 1], lines[j, 2], lines[j, 3]
            determinant = dx * ey - dy * ex
            if abs(determinant) <= _PARALLEL:
                if dx * ex + dy * ey > 0.0:
                    continue
                scratch[kept, 0] = 0.5 * (px + qx)
                scratch[kept, 1] = 0.5 * (py + qy)
            else:
                t = (ex * (py - qy) - ey * (px - qx)) / determinant
                scratch[kept, 0] = px + t * dx
                scratch[kept, 1] = py + t * dy
            fx = ex - dx
            fy = ey - dy
            length = math.sqrt(fx * fx + fy * fy)
            scratch[kept, 2] = fx / length
            scratch[kept, 3] = fy / length
            kept += 1
        before_x = out[0]
        before_y = out[1]
        if _within(scratch, kept, most, -dy, dx, True, out) < kept:
            # Only by rounding: the present velocity is kept.
            out[0] = before_x
            out[1] = before_y
        worst = dx * (py - out[1]) - dy * (px - out[0])
    return False


@kernel
def reciprocal_velocities(
    others: Array,
    own: Array,
    wanted: Array,
    radius: Column,
    speed: Column,
    horizon: Column,
    dt: float,
    first: int,
    end: int,
    lines: Array,
    out: Array,
) -> None:
    """The velocities of robots among others, into `out` (N, 2) [m/s], for the rows from `first` to `end`.

    Parameters
    ----------
    others
        (N, M, 5) x, y [m], vx, vy [m/s] and radius [m] of the others, from each robot, the nearest first; nan or inf
        for none. Any frame, the same for the rest.
    own, wanted
        (N, 2) velocities.
    radius, speed, horizon
        (N, 1) its radius [m], its top speed [m/s], and the time [s] for which it keeps apart from others.
    dt
        [s] in which two that overlap part.
    lines
        (N, M, 4) the borders: a point and a direction each; nan where there is none.
    """
    scratch = np.empty((lines.shape[1], 4))
    kept = np.empty((lines.shape[1], 4))
    for i in range(first, end):
        count = 0
        for j in range(others.shape[1]):
            lines[i, j, :] = math.nan
            if not (abs(others[i, j, 0]) < math.inf and abs(others[i, j, 1]) < math.inf):
                continue
            half_plane(
                others[i, j, 0],
                others[i, j, 1],
                others[i, j, 2],
                others[i, j, 3],
                own[i, 0],
                own[i, 1],
                radius[i, 0] + others[i, j, 4],
                horizon[i, 0],
                dt,
                lines[i, j],
            )
            kept[count] = lines[i, j]
            count += 1
        nearest_velocity(kept, count, speed[i, 0], wanted[i, 0], wanted[i, 1], scratch, out[i])
