"""Directions that a robot may take: vector field histograms (VFH+) and gaps."""

from __future__ import annotations

import math
from typing import Any

from amorsim.array_types import Array, Bools
from amorsim.kernels.compile import kernel, part
from amorsim.kernels.kinematics.poses import wrap

__all__ = ["block_sectors", "choose_openings"]

Column = Any

_WIDE = 8  # sectors: an opening of more has directions along both of its sides and towards the goal


@part
def block_sectors(points: Array, room: float, far: float, blocked: Bools) -> None:
    """Mark the sectors (S,) around a disc that points (2, p) within `far` [m] block; sector 0 begins at -pi.

    A point at the distance d blocks the directions within asin(room / d) of its own: the disc of radius `room` [m]
    about the base point would meet it. A sector is blocked if any of it is. A point within `room` blocks a half circle.
    """
    count = blocked.shape[0]
    width = 2.0 * math.pi / count
    blocked[:] = False
    for n in range(points.shape[1]):
        x = points[0, n]
        y = points[1, n]
        if not (abs(x) < math.inf and abs(y) < math.inf):
            continue
        d = math.sqrt(x * x + y * y)
        if d > far:
            continue
        half = math.asin(room / d) if d > room else 0.5 * math.pi
        middle = math.atan2(y, x)
        low = math.floor((middle - half + math.pi) / width)
        high = math.ceil((middle + half + math.pi) / width)
        for sector in range(low, high):
            blocked[sector % count] = True


@part
def _cost(bearing: float, goal: float, last: float, weights: Array) -> float:
    """The cost of a direction: of its angles from the goal, the present heading and the last choice."""
    cost: float = weights[0] * abs(wrap(bearing - goal)) + weights[1] * abs(wrap(bearing))
    cost += weights[2] * abs(wrap(bearing - last))
    return cost


@kernel
def choose_openings(
    points: Array,
    room: Array,
    far: Column,
    target: Array,
    weights: Array,
    first: int,
    end: int,
    blocked: Bools,
    chosen: Array,
) -> None:
    """Directions through openings, for the rows from `first` to `end`, by VFH+.

    Of openings that are narrow the middle is a candidate; of wide ones both sides, a few sectors in, and the goal's
    direction if it is in it. The one of least cost is taken.

    Parameters
    ----------
    points
        (N, 2, p) [m] that were seen, in the robots' frames; inf for none.
    room, far
        (N, 1) radius of the robot with what it keeps free, and how far it looks [m].
    target
        (N, 2) [m] the place that it is led to.
    weights
        (N, 3) of the angles from the target, from the present heading, and from the last choice.
    blocked
        (N, S) gets which sectors are blocked.
    chosen
        (N, 1) the direction chosen [rad]; the last one on entry, nan on return if all are blocked.
    """
    sectors = blocked.shape[1]
    width = 2.0 * math.pi / sectors
    for i in range(first, end):
        mine = blocked[i]
        block_sectors(points[i], room[i, 0], far[i, 0], mine)
        goal = math.atan2(target[i, 1], target[i, 0])
        last = 0.0 if math.isnan(chosen[i, 0]) else chosen[i, 0]
        best = math.inf
        found = math.nan
        begin = -1
        for s in range(sectors):
            if mine[s]:
                begin = s
                break
        if begin < 0:  # all is free
            chosen[i, 0] = goal
            continue
        s = 1
        while s <= sectors:
            if mine[(begin + s) % sectors]:
                s += 1
                continue
            size = 0
            while s + size <= sectors and not mine[(begin + s + size) % sectors]:
                size += 1
            low = -math.pi + (begin + s) * width
            high = low + size * width
            if size <= _WIDE:
                middle = wrap(0.5 * (low + high))
                cost = _cost(middle, goal, last, weights[i])
                if cost < best:
                    best = cost
                    found = middle
            else:
                inside = 0.5 * _WIDE * width
                for k in range(3):
                    bearing = low + inside if k == 0 else high - inside
                    if k == 2:
                        off = wrap(goal - low)
                        off = off if off >= 0.0 else off + 2.0 * math.pi
                        if not inside <= off <= high - low - inside:
                            continue
                        bearing = goal
                    bearing = wrap(bearing)
                    cost = _cost(bearing, goal, last, weights[i])
                    if cost < best:
                        best = cost
                        found = bearing
            s += size
        chosen[i, 0] = found
