"""Human-like avoidance: the direction in which the free way ahead leads nearest to the goal.

After J. Guzzi, A. Giusti, L. M. Gambardella, G. Theraulaz and G. A. Di Caro, "Human-friendly robot navigation in
dynamic environments", ICRA 2013.
"""

from __future__ import annotations

import math
from typing import Any

from amorsim.array_types import Array
from amorsim.kernels.compile import kernel, part

__all__ = ["free_way_among", "human_velocities"]

Column = Any

_WIDEST = 1.6  # [rad] from the way to the goal
_TOUCHING = 1e-6  # [m] that others are kept away at least, so that a robot may leave one that it touches


@part
def free_way_among(others: Array, c: float, s: float, speed: float, room: float, horizon: float, moving: bool) -> float:
    """The way [m] in the direction (c, s) at `speed` [m/s] before a disc meets another, `horizon` at most.

    `others` (M, 5) are places x, y [m] from the disc, velocities [m/s] and radii [m]; `room` [m] is its own radius with
    its margin. Others go on as they do, or stand unless `moving`.
    """
    best = horizon
    for j in range(others.shape[0]):
        x, y = others[j, 0], others[j, 1]
        if not (abs(x) < math.inf and abs(y) < math.inf):
            continue
        # As long as it takes for a metre.
        vx = c - (others[j, 2] / speed if moving and speed > 0.0 else 0.0)
        vy = s - (others[j, 3] / speed if moving and speed > 0.0 else 0.0)
        distance = math.sqrt(x * x + y * y)
        both = min(room + others[j, 4], max(distance - _TOUCHING, 0.0))
        nearer = x * vx + y * vy
        if nearer <= 0.0:
            continue
        fast = vx * vx + vy * vy
        inside = nearer * nearer - fast * (distance * distance - both * both)
        if inside >= 0.0:
            best = min(best, max((nearer - math.sqrt(inside)) / fast, 0.0))
    return best


@kernel
def human_velocities(
    others: Array,
    target: Array,
    room: Column,
    speed: Column,
    reaction: Column,
    horizon: Column,
    turns: int,
    first: int,
    end: int,
    ways: Array,
    out: Array,
) -> None:
    """The velocities of robots among others, into `out` (N, 2) [m/s], for the rows from `first` to `end`.

    Of the directions up to 90 degrees and a little from the target, the robot takes the one in which its free way leads
    nearest to a place `horizon` [m] away towards the target, and is no faster than lets it come to rest in the free way
    within `reaction` [s].

    Parameters
    ----------
    others
        (N, M, 5) x, y [m], vx, vy [m/s] and radius [m] of the others, from each robot; nan or inf for none.
    target
        (N, 2) [m] from the robot.
    room, speed
        (N, 1) radius with margin [m], and the speed [m/s] that it likes best.
    turns
        How many directions there are in a full circle.
    ways
        (N, D, 2) the directions [rad] from that of the target, and the free way [m] in each.
    """
    step = 2.0 * math.pi / turns
    each = int(_WIDEST / step)
    for i in range(first, end):
        far = horizon[i, 0]
        away = math.sqrt(target[i, 0] * target[i, 0] + target[i, 1] * target[i, 1])
        out[i, 0] = 0.0
        out[i, 1] = 0.0
        if away == 0.0:
            continue
        tx = target[i, 0] / away
        ty = target[i, 1] / away
        best = far
        found = False
        best_x = 0.0
        best_y = 0.0
        for n in range(min(2 * each + 1, ways.shape[1])):
            # Straight ahead first, then to both sides in turn.
            bend = step * ((n + 1) // 2) * (1.0 if n % 2 == 1 else -1.0)
            c = math.cos(bend)
            s = math.sin(bend)
            dx = c * tx - s * ty
            dy = s * tx + c * ty
            way = free_way_among(others[i], dx, dy, speed[i, 0], room[i, 0], far, True)
            ways[i, n, 0] = bend
            ways[i, n, 1] = way
            left = abs(s) * far if c * far < way else math.sqrt(max(far * far + way * way - 2.0 * far * way * c, 0.0))
            if left < best:
                best = left
                best_x = dx
                best_y = dy
                found = True
        if found:
            way = free_way_among(others[i], best_x, best_y, speed[i, 0], room[i, 0], far, False)
            fast = min(speed[i, 0], way / reaction[i, 0])
            out[i, 0] = fast * best_x
            out[i, 1] = fast * best_y
