"""Hybrid reciprocal velocity obstacles (HRVO): of velocities that keep clear of all others, the nearest to the wanted.

After J. Snape, J. van den Berg, S. J. Guy and D. Manocha, "The hybrid reciprocal velocity obstacle", IEEE Transactions
on Robotics 27 (4), 2011.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import numpy.typing as npt

from amorsim.kernels.compile import kernel, part

__all__ = ["hybrid_velocities"]

Floats = npt.NDArray[np.float64]
Column = Any

_SPARE = 1e-9  # [m/s] by which a velocity may be inside by rounding


@part
def _obstacle(x: float, y: float, vx: float, vy: float, own: Floats, both: float, out: Floats) -> None:
    """The cone of velocities that lead into another, into `out` (6,): apex, and the directions of both sides.

    `out[2:4]` is the right side, `out[4:6]` the left one, seen from the apex. The apex lies between that of the
    velocity obstacle and the reciprocal one, so that the robot passes on the side on which it is already, and does half
    of it.
    """
    distance = math.sqrt(x * x + y * y)
    middle = math.atan2(y, x)
    half = math.asin(min(both / distance, 1.0)) if distance > 0.0 else 0.5 * math.pi
    if distance <= both:
        half = 0.5 * math.pi
    rx, ry = math.cos(middle - half), math.sin(middle - half)
    lx, ly = math.cos(middle + half), math.sin(middle + half)
    out[2], out[3], out[4], out[5] = rx, ry, lx, ly
    cross = rx * ly - ry * lx
    mx, my = 0.5 * (own[0] + vx), 0.5 * (own[1] + vy)
    if cross < 1e-9 or distance <= both:
        out[0], out[1] = vx, vy
        return
    # From the other's velocity along one side, as far as that of the reciprocal obstacle lies.
    dx, dy = own[0] - vx, own[1] - vy
    if x * (own[1] - vy) - y * (own[0] - vx) > 0.0:
        part_of = 0.5 * (dx * ly - dy * lx) / cross
        out[0], out[1] = vx + part_of * rx, vy + part_of * ry
    else:
        part_of = 0.5 * (rx * dy - ry * dx) / cross
        out[0], out[1] = vx + part_of * lx, vy + part_of * ly
    if math.isnan(out[0]) or math.isnan(out[1]):
        out[0], out[1] = mx, my


@part
def _is_inside(cone: Floats, x: float, y: float) -> bool:
    """Whether a velocity is in a cone."""
    dx, dy = x - cone[0], y - cone[1]
    left_of_right = cone[2] * dy - cone[3] * dx
    left_of_left = cone[4] * dy - cone[5] * dx
    return bool(left_of_right > _SPARE and left_of_left < -_SPARE)


@kernel
def hybrid_velocities(
    others: Floats,
    own: Floats,
    wanted: Floats,
    radius: Column,
    speed: Column,
    first: int,
    end: int,
    cones: Floats,
    out: Floats,
) -> None:
    """The velocities of robots among others, into `out` (N, 2) [m/s], for the rows from `first` to `end`.

    Candidates are the wanted velocity, its projections on the sides of all cones, and where two sides, or a side and
    the circle of the top speed, meet. The one nearest to the wanted velocity that is in no cone is taken; if there is
    none, the one that is in none of the most of the nearest.

    Parameters
    ----------
    others
        (N, M, 5) x, y [m], vx, vy [m/s] and radius [m] of the others, from each robot, the nearest first; nan or inf
        for none.
    own, wanted
        (N, 2) velocities.
    radius, speed
        (N, 1) its radius [m], and its top speed [m/s].
    cones
        (N, M, 6) of each other robot: apex, right side, left side; nan for none.
    """
    slots = others.shape[1]
    candidates = np.empty((1 + 2 * slots * 3 + 2 * slots * (2 * slots - 1) // 2 + 1, 2))
    for i in range(first, end):
        count = 0
        for j in range(slots):
            cones[i, j, :] = math.nan
            if abs(others[i, j, 0]) < math.inf and abs(others[i, j, 1]) < math.inf:
                _obstacle(
                    others[i, j, 0],
                    others[i, j, 1],
                    others[i, j, 2],
                    others[i, j, 3],
                    own[i],
                    radius[i, 0] + others[i, j, 4],
                    cones[i, count],
                )
                count += 1
        most = speed[i, 0]
        wx, wy = wanted[i, 0], wanted[i, 1]
        size = math.sqrt(wx * wx + wy * wy)
        if size > most:
            wx, wy = wx / size * most, wy / size * most
        candidates[0, 0], candidates[0, 1] = wx, wy
        found = 1
        for a in range(2 * count):
            ax, ay = cones[i, a // 2, 0], cones[i, a // 2, 1]
            dx, dy = cones[i, a // 2, 2 + 2 * (a % 2)], cones[i, a // 2, 3 + 2 * (a % 2)]
            t = dx * (wx - ax) + dy * (wy - ay)
            if t > 0.0:
                candidates[found, 0], candidates[found, 1] = ax + t * dx, ay + t * dy
                found += 1
            along = ax * dx + ay * dy
            inside = along * along + most * most - ax * ax - ay * ay
            if inside >= 0.0:
                root = math.sqrt(inside)
                for sign in range(2):
                    t = -along + (root if sign == 0 else -root)
                    if t > 0.0:
                        candidates[found, 0], candidates[found, 1] = ax + t * dx, ay + t * dy
                        found += 1
            for b in range(a):
                bx, by = cones[i, b // 2, 0], cones[i, b // 2, 1]
                ex, ey = cones[i, b // 2, 2 + 2 * (b % 2)], cones[i, b // 2, 3 + 2 * (b % 2)]
                cross = dx * ey - dy * ex
                if abs(cross) > 1e-9:
                    t = ((bx - ax) * ey - (by - ay) * ex) / cross
                    u = ((bx - ax) * dy - (by - ay) * dx) / cross
                    if t > 0.0 and u > 0.0:
                        candidates[found, 0], candidates[found, 1] = ax + t * dx, ay + t * dy
                        found += 1
        best = math.inf
        deepest = -1
        out[i, 0] = 0.0
        out[i, 1] = 0.0
        for k in range(found):
            vx, vy = candidates[k, 0], candidates[k, 1]
            if vx * vx + vy * vy > most * most * (1.0 + 1e-9):
                continue
            kept = 0  # of the nearest, until the first that it leads into
            while kept < count and not _is_inside(cones[i, kept], vx, vy):
                kept += 1
            off = (vx - wx) * (vx - wx) + (vy - wy) * (vy - wy)
            if kept > deepest or (kept == deepest and off < best):
                deepest = kept
                best = off
                out[i, 0] = vx
                out[i, 1] = vy
