"""Bug algorithms and gaps: directions from a scan, and little memory."""

from __future__ import annotations

import math
from typing import Any

from amorsim.array_types import Array, Bools
from amorsim.kernels.avoidance.histogram import block_sectors
from amorsim.kernels.compile import kernel, part
from amorsim.kernels.kinematics.poses import wrap

__all__ = ["BUG_COLUMNS", "bug2", "nearness", "tangent_bug"]

Column = Any

BUG_COLUMNS = 7
"""Of a bug's memory: goal x, y [m], where it set out for it x, y [m], whether it follows a border, the goal's distance
[m] where it began to, and for how long [s] it has."""
_NEARER = 0.1  # [m] than where it met the border, to leave it
_ON_LINE = 0.1  # [m] from the line to the goal
_CORRECTION = 1.5  # [rad/m] towards the border or away from it
_SETTLE = 2.0  # [s] on a border before it may be left


@part
def _sector(bearing: float, sectors: int) -> int:
    """The number of the sector that a bearing [rad] lies in, counted from behind, anticlockwise."""
    return math.floor((wrap(bearing) + math.pi) / (2.0 * math.pi) * sectors) % sectors


@part
def _nearest(points: Array) -> tuple[float, float]:
    """The distance [m] and the bearing [rad] of the nearest point (2, p); inf if there is none."""
    least = math.inf
    bearing = 0.0
    for n in range(points.shape[1]):
        x, y = points[0, n], points[1, n]
        if abs(x) < math.inf and abs(y) < math.inf:
            d = math.sqrt(x * x + y * y)
            if d < least:
                least = d
                bearing = math.atan2(y, x)
    return least, bearing


@part
def _remember(memory: Array, pose: Array, gx: float, gy: float) -> None:
    """Note the goal; a new one begins a new line from here."""
    if math.sqrt((memory[0] - gx) ** 2 + (memory[1] - gy) ** 2) > 0.05 or math.isnan(memory[0]):
        memory[0], memory[1], memory[2], memory[3] = gx, gy, pose[0], pose[1]
        memory[4] = 0.0
    else:
        # The goal in the world wanders a little with the rounding of the way there and back.
        memory[0], memory[1] = gx, gy


@part
def _look(
    points: Array, room: float, target: Array, pose: Array, far: float, blocked: Bools, memory: Array
) -> tuple[float, float]:
    """Note the goal, and mark the sectors that are blocked nearer than it within `far` [m].

    The goal's distance [m] and bearing [rad].
    """
    c, s = math.cos(pose[2]), math.sin(pose[2])
    _remember(memory, pose, pose[0] + c * target[0] - s * target[1], pose[1] + s * target[0] + c * target[1])
    away = math.sqrt(target[0] * target[0] + target[1] * target[1])
    block_sectors(points, room, min(far, away), blocked)
    return away, math.atan2(target[1], target[0])


@part
def _along_border(points: Array, keep: float) -> float:
    """The direction along the nearest surface, which stays to the right at a distance [m]."""
    distance, bearing = _nearest(points)
    lean = min(max(_CORRECTION * (distance - keep), -0.7), 0.7)
    return wrap(bearing + 0.5 * math.pi - lean)


@kernel
def bug2(
    points: Array,
    room: Array,
    target: Array,
    pose: Array,
    far: Column,
    dt: float,
    blocked: Bools,
    memory: Array,
    bearing: Array,
) -> None:
    """Directions by Bug2, into `bearing` (N, 1).

    Straight for the goal until something is in the way within `far` (N, 1) [m], then along its border, which stays to
    the right, until the robot is back on the line from its start to the goal, nearer than where it left it.
    """
    for i in range(target.shape[0]):
        mine = memory[i]
        reach = room[i, 0] + far[i, 0]
        away, to_goal = _look(points[i], room[i, 0], target[i], pose[i], reach, blocked[i], mine)
        is_open = not blocked[i, _sector(to_goal, blocked.shape[1])]
        if mine[4] == 0.0 and not is_open:
            mine[4], mine[5], mine[6] = 1.0, away, 0.0
        elif mine[4] == 1.0:
            mine[6] += dt
            lx, ly = mine[0] - mine[2], mine[1] - mine[3]
            length = math.sqrt(lx * lx + ly * ly)
            off = abs(lx * (pose[i, 1] - mine[3]) - ly * (pose[i, 0] - mine[2])) / max(length, 1e-9)
            if is_open and mine[6] >= _SETTLE and off < _ON_LINE and away < mine[5] - _NEARER:
                mine[4] = 0.0
        bearing[i, 0] = to_goal if mine[4] == 0.0 else _along_border(points[i], room[i, 0] + 0.5 * far[i, 0])


@kernel
def tangent_bug(
    points: Array,
    room: Array,
    target: Array,
    pose: Array,
    far: Column,
    dt: float,
    blocked: Bools,
    memory: Array,
    bearing: Array,
) -> None:
    """Directions by a tangent bug, into `bearing` (N, 1).

    If the way to the goal is blocked within sight, it goes for the edge of what blocks it, of the two the one over
    which the way is shorter, as far as `far` (N, 1) [m] shows. Where that leads away from the goal, it follows the
    border until it sees a way nearer to the goal than it ever was.
    """
    sectors = blocked.shape[1]
    width = 2.0 * math.pi / sectors
    for i in range(target.shape[0]):
        mine = memory[i]
        away, to_goal = _look(points[i], room[i, 0], target[i], pose[i], far[i, 0], blocked[i], mine)
        middle = _sector(to_goal, sectors)
        if not blocked[i, middle] and (mine[4] == 0.0 or (mine[6] >= _SETTLE and away < mine[5] - _NEARER)):
            mine[4] = 0.0
            bearing[i, 0] = to_goal
            continue
        mine[6] += dt
        # The edges to both sides, and how far off what blocks is there.
        best = math.inf
        found = math.nan
        for side in range(2):
            sign = 1 if side == 0 else -1
            for n in range(1, sectors):
                sector = (middle + sign * n) % sectors
                if blocked[i, sector]:
                    continue
                direction = wrap(-math.pi + (sector + 0.5) * width)
                edge = wrap(direction - sign * width)
                reach = far[i, 0]
                for k in range(points.shape[2]):
                    x, y = points[i, 0, k], points[i, 1, k]
                    if abs(x) < math.inf and abs(y) < math.inf:
                        d = math.sqrt(x * x + y * y)
                        if d < reach and abs(wrap(math.atan2(y, x) - edge)) <= (
                            math.asin(room[i, 0] / d) if d > room[i, 0] else 0.5 * math.pi
                        ):
                            reach = d
                ex, ey = reach * math.cos(direction), reach * math.sin(direction)
                way = reach + math.sqrt((target[i, 0] - ex) ** 2 + (target[i, 1] - ey) ** 2)
                if way < best:
                    best = way
                    found = direction
                break
        if mine[4] == 0.0 and (math.isnan(found) or abs(wrap(found - to_goal)) > 0.5 * math.pi):
            mine[4], mine[5], mine[6] = 1.0, away, 0.0
        bearing[i, 0] = _along_border(points[i], room[i, 0] + 0.2) if mine[4] == 1.0 else found


@kernel
def nearness(
    points: Array,
    room: Array,
    target: Array,
    far: Column,
    near: Column,
    blocked: Bools,
    bearing: Array,
) -> None:
    """Directions by a nearness diagram, into `bearing` (N, 1), nan where there is no region to go to.

    The free walking area is the region of open directions whose side is nearest to the goal's. In it the robot goes for
    the goal, or else near its nearer side if it is wide, or through its middle. Where things are within `near` (N, 1)
    [m] of its circle, it is turned away from them, the more the nearer they are.
    """
    sectors = blocked.shape[1]
    width = 2.0 * math.pi / sectors
    wide = sectors // 4
    for i in range(target.shape[0]):
        to_goal = math.atan2(target[i, 1], target[i, 0])
        away = math.sqrt(target[i, 0] * target[i, 0] + target[i, 1] * target[i, 1])
        mine = blocked[i]
        block_sectors(points[i], room[i, 0], min(far[i, 0], away), mine)
        middle = _sector(to_goal, sectors)
        direction = to_goal
        if mine[middle]:
            offset = 0
            sign = 0
            for n in range(1, sectors // 2 + 1):
                if not mine[(middle + n) % sectors]:
                    offset, sign = n, 1
                    break
                if not mine[(middle - n) % sectors]:
                    offset, sign = n, -1
                    break
            if sign == 0:
                bearing[i, 0] = math.nan
                continue
            size = 0
            while size < sectors and not mine[(middle + sign * (offset + size)) % sectors]:
                size += 1
            inside = 0.5 * size if size < wide else 0.25 * wide
            direction = -math.pi + (middle + sign * (offset + inside - 0.5) + 0.5) * width
        # Away from what is near.
        turn = 0.0
        for n in range(points.shape[2]):
            x, y = points[i, 0, n], points[i, 1, n]
            if not (abs(x) < math.inf and abs(y) < math.inf):
                continue
            gap = math.sqrt(x * x + y * y) - room[i, 0]
            if gap < near[i, 0]:
                off = wrap(math.atan2(y, x) - direction)
                if abs(off) < 0.5 * math.pi:
                    push = (near[i, 0] - max(gap, 0.0)) / near[i, 0] * (0.5 * math.pi - abs(off))
                    if push > abs(turn):
                        turn = -push if off > 0.0 else push
        bearing[i, 0] = wrap(direction + turn)
