"""Hybrid reciprocal velocity obstacles (HRVO): of velocities clear of all others, the nearest to the wanted one.

After J. Snape, J. van den Berg, S. J. Guy and D. Manocha, "The hybrid reciprocal velocity obstacle", IEEE Transactions
on Robotics 27 (4), 2011.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from amorsim.array_types import Array, Bools
from amorsim.kernels.compile import inlined, kernel, part

__all__ = ["hybrid_velocities"]

Column = Any

_SPARE = 1e-9  # [m/s] by which a velocity may be inside by rounding
_ROUNDING = 1e-9  # part of the squares of speeds that they are off by at most


@part
def _obstacle(x: float, y: float, vx: float, vy: float, own: Array, both: float, out: Array) -> None:
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


@inlined
def _is_inside(cones: Array, j: int, x: float, y: float) -> bool:
    """Whether a velocity is in cone `j`."""
    dx, dy = x - cones[j, 0], y - cones[j, 1]
    left_of_right = cones[j, 2] * dy - cones[j, 3] * dx
    left_of_left = cones[j, 4] * dy - cones[j, 5] * dx
    return bool(left_of_right > _SPARE and left_of_left < -_SPARE)


class Wish(NamedTuple):
    """The wanted velocity, and bounds of the choice."""

    x: float
    y: float
    """[m/s] the wanted velocity."""
    most: float
    """[m/s] the top speed."""
    off: float
    """[m^2/s^2] the largest squared distance from the wanted velocity."""


@part
def _add(cones: Array, clear: int, wish: Wish, x: float, y: float, count: int, out: Array) -> int:
    """Add a velocity to `count` of them if it is near enough and outside the first `clear` cones; their number."""
    if x * x + y * y > wish.most * wish.most * (1.0 + 1e-9) or _off(wish, x, y) > wish.off:
        return count
    for j in range(clear):
        if _is_inside(cones, j, x, y):
            return count
    out[count, 0] = x
    out[count, 1] = y
    return count + 1


@part
def _off(wish: Wish, x: float, y: float) -> float:
    """The squared distance [m^2/s^2] of a velocity from the wanted one."""
    return (x - wish.x) * (x - wish.x) + (y - wish.y) * (y - wish.y)


@part
def _add_alone(cones: Array, clear: int, wish: Wish, a: int, count: int, out: Array) -> int:
    """Add, as `_add` does, where side `a` is nearest to the wanted velocity, and where it meets the top speed's circle.

    Cone j has the sides 2 j and 2 j + 1.
    """
    ax, ay = cones[a // 2, 0], cones[a // 2, 1]
    dx, dy = cones[a // 2, 2 + 2 * (a % 2)], cones[a // 2, 3 + 2 * (a % 2)]
    t = dx * (wish.x - ax) + dy * (wish.y - ay)
    if t > 0.0:
        count = _add(cones, clear, wish, ax + t * dx, ay + t * dy, count, out)
    along = ax * dx + ay * dy
    inside = along * along + wish.most * wish.most - ax * ax - ay * ay
    if inside >= 0.0:
        root = math.sqrt(inside)
        for sign in range(2):
            t = -along + (root if sign == 0 else -root)
            if t > 0.0:
                count = _add(cones, clear, wish, ax + t * dx, ay + t * dy, count, out)
    return count


@part
def _is_useful(cones: Array, wish: Wish, a: int) -> bool:
    """Whether anything on side `a` may be slow enough, and near enough to the wanted velocity, but for rounding."""
    ax, ay = cones[a // 2, 0], cones[a // 2, 1]
    dx, dy = cones[a // 2, 2 + 2 * (a % 2)], cones[a // 2, 3 + 2 * (a % 2)]
    rounding = _ROUNDING * (ax * ax + ay * ay + wish.most * wish.most)
    away = dx * (wish.y - ay) - dy * (wish.x - ax)
    slow = dx * ay - dy * ax
    return bool(slow * slow <= wish.most * wish.most + rounding and away * away <= wish.off + rounding)


@part
def _add_crossings(cones: Array, clear: int, wish: Wish, a: int, useful: Bools, count: int, out: Array) -> int:
    """Add, as `_add` does, where side `a` meets those earlier sides that are `useful`."""
    ax, ay = cones[a // 2, 0], cones[a // 2, 1]
    dx, dy = cones[a // 2, 2 + 2 * (a % 2)], cones[a // 2, 3 + 2 * (a % 2)]
    for b in range(a):
        if not useful[b]:
            continue
        bx, by = cones[b // 2, 0], cones[b // 2, 1]
        ex, ey = cones[b // 2, 2 + 2 * (b % 2)], cones[b // 2, 3 + 2 * (b % 2)]
        cross = dx * ey - dy * ex
        if abs(cross) <= 1e-9:
            continue
        t = ((bx - ax) * ey - (by - ay) * ex) / cross
        u = ((bx - ax) * dy - (by - ay) * dx) / cross
        if t > 0.0 and u > 0.0:
            count = _add(cones, clear, wish, ax + t * dx, ay + t * dy, count, out)
    return count


@kernel
def hybrid_velocities(
    others: Array,
    own: Array,
    wanted: Array,
    radius: Column,
    speed: Column,
    first: int,
    end: int,
    cones: Array,
    out: Array,
) -> None:
    """The velocities of robots among others, into `out` (N, 2) [m/s], for the rows from `first` to `end`.

    Candidates are the wanted velocity, its projections on the sides of all cones, and where two sides, or a side and
    the circle of the top speed, meet. Of those in no cone, the one nearest to the wanted velocity is taken. If all are
    in cones, it is the one that keeps clear of the nearest others, of as many of them as possible.

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
    kept = np.empty_like(candidates)
    useful = np.empty(2 * slots, dtype=np.bool_)
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
        mine = cones[i]
        most = speed[i, 0]
        wx, wy = wanted[i, 0], wanted[i, 1]
        size = math.sqrt(wx * wx + wy * wy)
        if size > most:
            wx, wy = wx / size * most, wy / size * most
        candidates[0, 0], candidates[0, 1] = wx, wy
        # A few that are found soon: if one of them keeps clear of all, what is farther off is not needed.
        wish = Wish(wx, wy, most, math.inf)
        found = _add(mine, count, wish, wx, wy, 0, kept)
        for a in range(2 * count):
            found = _add_alone(mine, count, wish, a, found, kept)
        least = math.inf
        for k in range(found):
            least = min(least, _off(wish, kept[k, 0], kept[k, 1]))
        wish = Wish(wx, wy, most, least)
        found = 1
        for j in range(count):
            # What keeps clear of one more of the others is left of what kept clear of those before, or on its sides.
            left = 0
            for k in range(found):
                if not _is_inside(mine, j, candidates[k, 0], candidates[k, 1]):
                    kept[left, 0], kept[left, 1] = candidates[k, 0], candidates[k, 1]
                    left += 1
            for a in range(2 * j, 2 * j + 2):
                useful[a] = _is_useful(mine, wish, a)
                if useful[a]:
                    left = _add_alone(mine, j + 1, wish, a, left, kept)
                    left = _add_crossings(mine, j + 1, wish, a, useful, left, kept)
            if left == 0:
                break
            candidates, kept = kept, candidates
            found = left
        best = math.inf
        for k in range(found):
            vx, vy = candidates[k, 0], candidates[k, 1]
            off = _off(wish, vx, vy)
            if off < best:
                best = off
                out[i, 0] = vx
                out[i, 1] = vy
