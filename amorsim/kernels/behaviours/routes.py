"""Steps along waypoints: once, round and round, or there and back."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from amorsim.array_types import Array, Ints
from amorsim.kernels.compile import kernel, part
from amorsim.kernels.kinematics.poses import wrap

__all__ = ["BACK", "ONCE", "ROUND", "Progress", "follow_route"]

# A component's parameter over rows, (N, 1) float64; declared as the number that it is for one row.
Column = Any

ONCE, ROUND, BACK = range(3)
"""What comes after the last waypoint: nothing, the first, or the one before."""

_EARLY = 1e-9  # [s] before the patience is over
_STANDS = 1e-12  # [m] a way shorter than this has no direction


class Progress(NamedTuple):
    """How far bodies are on their routes, each (N, 1); the last three as they were before the latest step."""

    following: Ints  # number of the next waypoint; that of all of them when the last was passed
    way: Ints  # 1 forwards through the list, -1 backwards
    rest: Array  # [s] that is left of a pause
    last_following: Ints
    last_way: Ints
    last_rest: Array
    blocked: Array  # [s] for which it has been blocked without a break


@part
def _after(number: int, way: int, count: int, order: int) -> tuple[int, int]:
    """The waypoint after one, and the way through the list from there."""
    if order == ONCE:
        return min(number + 1, count), way
    if order == ROUND:
        return (number + 1) % count, way
    if number >= count - 1:
        way = -1
    elif number <= 0:
        way = 1
    return min(max(number + way, 0), count - 1), way


@part
def _time_around(points: Array, speed: float, pause: float, order: int) -> float:
    """The time from a waypoint to the same one again, with pauses [s]; inf if that is never or at once."""
    count = points.shape[0]
    if order == ONCE:
        return math.inf
    length = 0.0
    for k in range(count - 1):
        dx = points[k + 1, 0] - points[k, 0]
        dy = points[k + 1, 1] - points[k, 1]
        length += math.sqrt(dx * dx + dy * dy)
    stops = count
    if order == BACK:
        length *= 2.0
        stops = max(2 * count - 2, 1)
    else:
        dx = points[0, 0] - points[count - 1, 0]
        dy = points[0, 1] - points[count - 1, 1]
        length += math.sqrt(dx * dx + dy * dy)
    under_way = 0.0
    if length > 0.0:
        under_way = length / speed if speed > 0.0 else math.inf
    around = under_way + stops * pause
    return around if around > 0.0 else math.inf


@kernel
def follow_route(
    poses: Array,
    free: Array,
    points: Array,
    progress: Progress,
    ways: Array,
    speed: Column,
    pause: Column,
    patience: Column,
    turn_rate: Column,
    order: int,
    skips: bool,
    faces: bool,
    dt: float,
) -> None:
    """Write the way of a step (dx [m], dy [m], turn [rad]) in the world into `ways` (N, 3), past waypoints on it.

    Parameters
    ----------
    poses, free
        Of the bodies, (N, 3), and the fraction of the latest step that was free, (N, 1).
    points
        The waypoints [m], (N, W, 2).
    speed, pause, patience, turn_rate
        [m/s], [s], [s] and [rad/s], (N, 1).
    order
        `ONCE`, `ROUND` or `BACK`.
    skips
        Whether a body that has been blocked for its patience leaves its next waypoint out.
    faces
        Whether it turns to where it goes.
    """
    following_of, way_of, rest_of, last_following, last_way, last_rest, blocked = progress
    count = points.shape[1]
    for i in range(poses.shape[0]):
        short = free[i, 0] < 1.0
        blocked[i, 0] = blocked[i, 0] + dt if short else 0.0
        # A body that was stopped before a waypoint has not passed it.
        following = last_following[i, 0] if short else following_of[i, 0]
        way = last_way[i, 0] if short else way_of[i, 0]
        rest = last_rest[i, 0] if short else rest_of[i, 0]
        if skips and short and blocked[i, 0] >= patience[i, 0] - _EARLY:
            following, way = _after(following, way, count, order)
            blocked[i, 0] = 0.0
        last_following[i, 0] = following
        last_way[i, 0] = way
        last_rest[i, 0] = rest
        x = poses[i, 0]
        y = poses[i, 1]
        left = dt
        around = -1.0
        # To the next waypoint, and then less than once around.
        for _ in range(2 * count + 1):
            # First rest, then go, then arrive.
            resting = min(rest, left)
            rest -= resting
            left -= resting
            target = points[i, min(following, count - 1)]
            dx = target[0] - x
            dy = target[1] - y
            distance = math.sqrt(dx * dx + dy * dy)
            far = speed[i, 0] * left
            if not (left > 0.0 and far >= distance and following < count):
                if distance > far:
                    share = far / distance
                    x = target[0] if share >= 1.0 else x + share * dx
                    y = target[1] if share >= 1.0 else y + share * dy
                break
            x = target[0]
            y = target[1]
            left = max(left - distance / (speed[i, 0] if speed[i, 0] > 0.0 else 1.0), 0.0)
            rest = pause[i, 0]
            following, way = _after(following, way, count, order)
            if not left > 0.0:
                break
            if around < 0.0:
                around = _time_around(points[i], speed[i, 0], pause[i, 0], order)
            if left >= around:
                left %= around
        following_of[i, 0] = following
        way_of[i, 0] = way
        rest_of[i, 0] = rest
        dx = x - poses[i, 0]
        dy = y - poses[i, 1]
        ways[i, 0] = dx
        ways[i, 1] = dy
        ways[i, 2] = 0.0
        # A body that was just blocked does not turn: its corners may touch the obstacle.
        if faces and abs(dx) + abs(dy) > _STANDS and free[i, 0] >= 1.0:
            most = turn_rate[i, 0] * dt
            ways[i, 2] = min(max(wrap(math.atan2(dy, dx) - poses[i, 2]), -most), most)
