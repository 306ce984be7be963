"""The free space that a wandering robot sees, and its choice of direction.

The robot is taken as a disc about its base point, as wide as it sweeps when it turns in place. The disc that
it stands on is free (it came there along a checked corridor), so turning is always safe; driving is checked
against every point seen.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from amorsim.array_types import Array
from amorsim.kernels.compile import part

__all__ = [
    "Sight",
    "choose_direction",
    "directions_within",
    "find_opening",
    "free_way",
    "nearest_distance",
    "nearest_side",
    "see_points",
]


_ARC_SAMPLES = 7  # points that stand for the arc on which a sonar's return lies
_DOUBT = 0.05  # [m] by which a point must be nearer than another cone's reading to be ruled out by it
_LOOK_STEP = 0.5  # [m] between the places along a direction whose novelty is weighed
_NEAR = 0.7  # [m] within which a place counts as visited
_KNOWN = 0.12  # worth of a visited place, of a new one's
_USEFUL = 0.4  # [m] a direction with less room is not taken
_AHEAD = 6.0  # [m] beyond which room counts no more
_NARROW = 0.02  # [m] by which a direction is asked to be wider than the way that is driven
_SPREAD = math.radians(2.0)  # between directions that are weighed
_ABEAM_FIRST = math.radians(62.0)
_ABEAM_COUNT = 8  # directions about abeam, twice that far between


class Sight(NamedTuple):
    """The readings and the beams of the range finders of N robots."""

    ranges: Array
    """(N, k) [m]"""
    beams: Array
    """(N, 5, k) where each range is seen from and which way: poses in the robot's frame, cosine and sine of the
    heading."""
    half_angle: Array
    """(N, 1) half the angle of the cone about that [rad]."""
    samples: int
    """The number of points for a return: 1 for a beam, more on the arc of a cone."""


@part
def see_points(ranges: Array, beams: Array, half_angle: float, points: Array) -> None:
    """Points of returns, x and y [m] in the robot's frame, into `points` (3, p); inf for no return.

    Its last row is scratch space, for values computed from the points.

    `ranges` (k,) [m] are seen from `beams` (5, k): x, y and headings in the robot's frame, cosine and sine of these.
    With a `half_angle` [rad] a return may come from anywhere on an arc: there are `p // k` points on each, less those
    that another cone saw past.
    """
    k = ranges.shape[0]
    samples = points.shape[1] // k
    if samples == 1:
        for j in range(k):
            reach = 0.0 if ranges[j] == -math.inf else ranges[j]  # too near to measure: at the sensor itself
            seen = abs(reach) < math.inf
            x = beams[0, j] + reach * beams[3, j]
            y = beams[1, j] + reach * beams[4, j]
            points[0, j] = x if seen else math.inf
            points[1, j] = y if seen else math.inf
        return
    for j in range(k):
        for n in range(samples):
            index = j * samples + n
            points[0, index] = math.inf
            points[1, index] = math.inf
            if not math.isfinite(ranges[j]):
                continue
            bearing = beams[2, j] + half_angle * (2.0 * n / (samples - 1) - 1.0)
            x = beams[0, j] + ranges[j] * math.cos(bearing)
            y = beams[1, j] + ranges[j] * math.sin(bearing)
            if not _seen_past(ranges, beams, half_angle, j, x, y):
                points[0, index] = x
                points[1, index] = y


@part
def _seen_past(ranges: Array, beams: Array, half_angle: float, own: int, x: float, y: float) -> bool:
    """Whether a cone other than `own` holds the point and has its nearest return farther away."""
    for j in range(ranges.shape[0]):
        if j == own or math.isnan(ranges[j]):
            continue
        dx = x - beams[0, j]
        dy = y - beams[1, j]
        distance = math.sqrt(dx * dx + dy * dy)
        if distance + _DOUBT < ranges[j]:
            along = dx * beams[3, j] + dy * beams[4, j]
            if along >= distance * math.cos(half_angle):
                return True
    return False


@part
def _least(numbers: Array) -> float:
    """The least of some numbers, which are overwritten: halves are compared, several numbers at a time."""
    count = numbers.shape[0]
    if count == 0:
        return math.inf
    while count > 1:
        half = count // 2
        low = numbers[:half]
        high = numbers[count - half : count]
        for n in range(half):
            low[n] = high[n] if high[n] < low[n] else low[n]
        count -= half
    return float(numbers[0])


@part
def free_way(points: Array, bearing: float, half_width: float, spread: float) -> float:
    """How far [m] a disc of radius `half_width` goes along `bearing` before it meets a point.

    With a `spread` above 0 points count as so much nearer to the way, per metre that they are ahead: the robot may
    not keep the bearing so well.
    """
    c = math.cos(bearing)
    s = math.sin(bearing)
    square = half_width * half_width
    ways = points[2]
    for n in range(points.shape[1]):
        along = c * points[0, n] + s * points[1, n]
        across = max(0.0, abs(c * points[1, n] - s * points[0, n]) - spread * along)
        room = square - across * across
        way = along - math.sqrt(room)
        ways[n] = way if (along > 0.0) & (room > 0.0) else math.inf
    return max(_least(ways), 0.0)


@part
def nearest_distance(points: Array) -> float:
    """Distance [m] from the base point to the nearest point."""
    squares = points[2]
    for n in range(points.shape[1]):
        squares[n] = points[0, n] * points[0, n] + points[1, n] * points[1, n]
    return math.sqrt(_least(squares))


@part
def nearest_side(points: Array) -> float:
    """The side of the nearest point: 1 left, -1 right."""
    nearest = math.inf
    side = 1.0
    for n in range(points.shape[1]):
        square = points[0, n] * points[0, n] + points[1, n] * points[1, n]
        if square < nearest:
            nearest = square
            side = 1.0 if points[1, n] > 0.0 else -1.0
    return side


@part
def _worth(pose: Array, trail: Array, visits: int, bearing: float, free: float) -> float:
    """The score of a direction: places along the free path; those near the robot's trail count little."""
    heading = pose[2] + bearing
    c = math.cos(heading)
    s = math.sin(heading)
    kept = min(visits, trail.shape[0])
    worth = 0.0
    for step in range(1, int(min(free, _AHEAD) / _LOOK_STEP) + 1):
        x = pose[0] + c * _LOOK_STEP * step
        y = pose[1] + s * _LOOK_STEP * step
        value = 1.0
        for n in range(kept):
            dx = trail[n, 0] - x
            dy = trail[n, 1] - y
            if dx * dx + dy * dy < _NEAR * _NEAR:
                value = _KNOWN
                break
        worth += value
    return worth


@part
def find_opening(points: Array, view: Array, half_width: float, side: float) -> tuple[float, float]:
    """The longest way [m] about abeam on one side (1 for the left, -1 for the right), and its bearing [rad]."""
    longest = 0.0
    found = side * _ABEAM_FIRST
    for n in range(_ABEAM_COUNT):
        bearing = side * (_ABEAM_FIRST + 2.0 * _SPREAD * n)
        if view[0] <= bearing <= view[1]:
            free = min(_AHEAD, free_way(points, bearing, half_width + _NARROW, 0.0))
            if free > longest:
                longest = free
                found = bearing
    return longest, found


@part
def directions_within(view: Array) -> int:
    """The number of bearings that `choose_direction` weighs in a view (least, greatest bearing [rad])."""
    return int((view[1] - view[0]) / _SPREAD) + 1


@part
def choose_direction(
    points: Array,
    weights: Array,
    view: Array,
    half_width: float,
    pose: Array,
    trail: Array,
    visits: int,
    draw: float,
    bar: float,
) -> float:
    """A bearing [rad] with room ahead, or nan if there is none.

    Drawn among all directions within `view` (least, greatest bearing) by the cube of their scores: room, and places
    that are not on the `trail` (places, 2) [m] of the last `visits`. With a `bar` above 0, no direction is taken whose
    score is less than `bar` times that of straight ahead. `weights` is scratch space, a number for each of
    `directions_within` the view.
    """
    least = view[0]
    count = directions_within(view)
    bar *= _worth(pose, trail, visits, 0.0, free_way(points, 0.0, half_width, 0.0))
    for spare in (_NARROW, 0.0):
        total = 0.0
        for n in range(count):
            bearing = least + _SPREAD * n
            free = free_way(points, bearing, half_width + spare, 0.0)
            weights[n] = 0.0
            # Not worth the looking up where even wholly new places would not do.
            if free > _USEFUL and min(free, _AHEAD) / _LOOK_STEP > bar:
                worth = _worth(pose, trail, visits, bearing, free) * (1.0 - 0.1 * abs(bearing))
                if worth > bar:
                    weights[n] = worth * worth * worth
            total += weights[n]
        if total > 0.0:
            mark = draw * total
            for n in range(count):
                mark -= weights[n]
                if mark < 0.0:
                    return float(least + _SPREAD * n)
        if bar > 0.0:
            break
    return math.nan
