"""The behaviour of a wandering car, row by row: along the arc with most room, and back the way it came."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from amorsim.array_types import Array
from amorsim.kernels.behaviours.free_space import Sight, see_points
from amorsim.kernels.behaviours.wandering import Wish
from amorsim.kernels.compile import kernel

__all__ = ["CAR_COLUMNS", "CarBody", "wander_car"]


# Columns of the memory of a row.
_BACKING = 0  # [m] still to go back, 0 where it drives ahead
_SPEED = 1  # [m/s] at which it drives now, by its own reckoning
_WRITTEN = 2  # places written on its trail, less those it went back over
_LEAN = 3  # part of its sharpest curve, from -1 to 1, that it likes to drive
_SINCE = 4  # [m] since it chose what it likes
_SEEN = 5  # points that it keeps in mind
CAR_COLUMNS = 6

_ARCS = 6  # curves to either side that are weighed
_HORIZON = 3.0  # times its length, as far as arcs are looked along
_STEPS = 24  # footprints along an arc
_SPACING = 0.1  # part of its length between places on the trail
_TIME_TO_STOP = 1.2  # [s] it never drives faster than it stops in within this time
_SHORT = 0.25  # part of its length: with less room on all arcs it goes back
_BACK = 1.5  # times its length that it goes back
_KEPT = 24  # beams of a scan, about, whose points it keeps in mind: what it passes it sees no more
_NEAR = 1.5  # times its length, as far as they matter
_MARGIN = 1e-3  # [m] by which more than the swept ring is looked at: more than any rounding
_RESTLESS = 4.0  # times its length after which it likes another curve


class CarBody(NamedTuple):
    """The knowledge of N cars about themselves."""

    front: float
    """The footprint reaches so far ahead of the base point [m],"""
    rear: float
    """so far behind it, a negative number,"""
    half_width: float
    """and so far to either side."""
    limits: Array
    """Of the drive, (N, 4)."""
    curvature_max: Array
    """(N, 1) [1/m]"""


@kernel
def _on_the_way(
    points: Array, near: Array, bend: float, front: float, rear: float, half_width: float, horizon: float
) -> int:
    """How many of `points` (2, p) the footprint may meet along an arc of curvature `bend`; they come into `near`.

    It turns about the middle of the arc, so it sweeps a ring, or a strip where it goes straight on.
    """
    tip = max(abs(front), abs(rear))
    farthest = horizon + tip + half_width + _MARGIN
    is_straight = abs(bend) * farthest < 1e-3
    radius = 0.0 if is_straight else 1.0 / bend
    aside = half_width + abs(bend) * farthest * farthest + _MARGIN
    inner = max(abs(radius) - half_width - _MARGIN, 0.0)
    outer = math.sqrt(tip * tip + (abs(radius) + half_width) ** 2) + _MARGIN
    count = 0
    for n in range(points.shape[1]):
        x = points[0, n]
        y = points[1, n]
        if not x * x + y * y < farthest * farthest:
            continue
        if is_straight:
            may_meet = abs(y) < aside
        else:
            square = x * x + (y - radius) * (y - radius)
            may_meet = inner * inner <= square <= outer * outer
        if may_meet:
            near[0, count] = x
            near[1, count] = y
            count += 1
    return count


@kernel
def _room(
    points: Array, near: Array, bend: float, front: float, rear: float, half_width: float, horizon: float
) -> float:
    """The way [m] of the footprint along an arc of curvature `bend` until one of `points` (2, p) is in it.

    `near` (2, p) is room to work in.
    """
    count = _on_the_way(points, near, bend, front, rear, half_width, horizon)
    step = horizon / _STEPS
    for k in range(1, _STEPS + 1):
        way = step * k
        angle = bend * way
        if abs(angle) < 1e-6:
            x = way
            y = 0.0
        else:
            x = math.sin(angle) / bend
            y = (1.0 - math.cos(angle)) / bend
        c = math.cos(angle)
        s = math.sin(angle)
        meets = False
        for n in range(count):
            dx = near[0, n] - x
            dy = near[1, n] - y
            along = c * dx + s * dy
            meets |= (rear < along) & (along < front) & (abs(c * dy - s * dx) < half_width)
        if meets:
            return way - step
    return horizon


@kernel
def _best_arc(
    points: Array, near: Array, lean: float, sharpest: float, body: CarBody, keep: float
) -> tuple[float, float]:
    """The room [m] on the best arc, and its curvature: most room, less its difference from the preferred arc.

    Of arcs equally good it is the rightmost. They are tried from the liked one on, so that those which could not be
    better with all the room there is need no trying.
    """
    length = body.front - body.rear
    horizon = _HORIZON * length
    best = -math.inf
    best_arc = 2 * _ARCS + 1
    room = 0.0
    middle = math.floor(lean * _ARCS + 0.5) + _ARCS
    for m in range(4 * _ARCS + 1):
        arc = middle + (m + 1) // 2 * (1 if m % 2 else -1)
        if not 0 <= arc <= 2 * _ARCS:
            continue
        share = (arc - _ARCS) / _ARCS
        less = 0.2 * length * abs(share - lean)
        if horizon - less < best or (horizon - less == best and arc > best_arc):
            continue
        front, half_width = body.front + keep, body.half_width + keep
        free = _room(points, near, share * sharpest, front, body.rear, half_width, horizon)
        worth = free - less
        if worth > best or (worth == best and arc < best_arc):
            best = worth
            best_arc = arc
            room = free
    return room, (best_arc - _ARCS) / _ARCS * sharpest


@kernel
def wander_car(
    sight: Sight,
    pose: Array,
    body: CarBody,
    wish: Wish,
    draws: Array,
    dt: float,
    memory: Array,
    trail: Array,
    seen: Array,
    first: int,
    end: int,
    out: Array,
) -> None:
    """Twists of wandering cars, into `out` (N, 3).

    Parameters
    ----------
    sight, pose, wish
        As in `amorsim.kernels.behaviours.wandering.wander`.
    body
        What the cars know of themselves.
    draws
        Uniform random numbers, (N, 2).
    memory, trail, seen
        What it remembers, (N, CAR_COLUMNS), the places where its base point was, (N, m, 2), and where it saw
        something, (N, p, 2), by its estimate; changed.
    first, end
        The rows that are worked on.
    """
    count = sight.ranges.shape[1] * sight.samples
    now = np.empty((3, count))
    points = np.empty((2, count + seen.shape[1]))
    near = np.empty(points.shape)
    length = body.front - body.rear
    places = trail.shape[1]
    for i in range(first, end):
        see_points(sight.ranges[i], sight.beams[i], sight.half_angle[i, 0], now)
        points[:, :count] = now[:2]
        own = memory[i]
        c = math.cos(pose[i, 2])
        s = math.sin(pose[i, 2])
        kept = int(own[_SEEN])
        for n in range(seen.shape[1]):
            points[0, count + n] = math.inf
            points[1, count + n] = math.inf
            if n < kept:
                dx = seen[i, n, 0] - pose[i, 0]
                dy = seen[i, n, 1] - pose[i, 1]
                points[0, count + n] = c * dx + s * dy
                points[1, count + n] = c * dy - s * dx
        for n in range(0, count, max(count // _KEPT, 1)):
            x = points[0, n]
            y = points[1, n]
            if math.isfinite(x) and x * x + y * y < (_NEAR * length) ** 2:
                seen[i, kept % seen.shape[1], 0] = pose[i, 0] + c * x - s * y
                seen[i, kept % seen.shape[1], 1] = pose[i, 1] + s * x + c * y
                kept += 1
        own[_SEEN] = kept
        fastest = min(wish.speed[i, 0], body.limits[i, 0])
        braking = body.limits[i, 2]
        sharpest = body.curvature_max[i, 0]
        v = 0.0
        bend = 0.0
        if own[_BACKING] > 0.0:
            # Along the places where it was, newest first; what lies behind the rear axle is steered for.
            written = int(own[_WRITTEN])
            distance = 0.0
            x = 0.0
            y = 0.0
            while written > 0:
                place = trail[i, (written - 1) % places]
                dx = place[0] - pose[i, 0]
                dy = place[1] - pose[i, 1]
                x = c * dx + s * dy
                y = c * dy - s * dx
                distance = math.sqrt(x * x + y * y)
                if x < 0.0 and distance > 0.3 * length:
                    break
                written -= 1
            own[_WRITTEN] = written
            if written == 0 or own[_SPEED] > 0.0:
                own[_BACKING] = 0.0 if written == 0 else own[_BACKING]
            else:
                v = -min(0.5 * fastest, own[_BACKING] / _TIME_TO_STOP)
                if v > -0.02:
                    v = 0.0
                    own[_BACKING] = 0.0
                bend = min(max(2.0 * y / (distance * distance), -sharpest), sharpest)
        else:
            written = int(own[_WRITTEN])
            last = trail[i, (written - 1) % places]
            if written == 0 or (pose[i, 0] - last[0]) ** 2 + (pose[i, 1] - last[1]) ** 2 > (_SPACING * length) ** 2:
                trail[i, written % places, 0] = pose[i, 0]
                trail[i, written % places, 1] = pose[i, 1]
                own[_WRITTEN] = written + 1.0
            if own[_SINCE] > _RESTLESS * length:
                own[_LEAN] = 2.0 * draws[i, 0] - 1.0
                own[_SINCE] = 0.0
            keep = max(wish.clearance[i, 0], 0.25 * body.half_width)
            room, bend = _best_arc(points, near, own[_LEAN], sharpest, body, keep)
            if room < _SHORT * length:
                if own[_SPEED] == 0.0:
                    own[_BACKING] = _BACK * length
                    own[_LEAN] = 1.0 if draws[i, 1] < 0.5 else -1.0
                    own[_SINCE] = 0.0
            else:
                v = min(fastest, room / _TIME_TO_STOP)
                if math.isfinite(braking):
                    v = min(v, math.sqrt(braking * room))
        change = braking * dt
        before = own[_SPEED]
        own[_SPEED] = min(max(v, before - change), before + change)
        own[_SINCE] += abs(own[_SPEED]) * dt
        if own[_BACKING] > 0.0:
            own[_BACKING] = max(own[_BACKING] + min(own[_SPEED], 0.0) * dt, 1e-9)
        out[i, 0] = v
        out[i, 1] = 0.0
        out[i, 2] = v * bend
