"""The behaviour of a wandering car, row by row: along the arc with most room, and back the way it came."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import numpy.typing as npt

from amorsim.kernels.behaviours.free_space import see_points
from amorsim.kernels.compile import kernel

__all__ = ["CAR_COLUMNS", "wander_car"]

Floats = npt.NDArray[np.float64]
# A component's parameter over rows, (N, 1) float64; declared as the number that it is for one row.
Column = Any

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
_RESTLESS = 4.0  # times its length after which it likes another curve


@kernel
def _room(points: Floats, bend: float, front: float, rear: float, half_width: float, horizon: float) -> float:
    """How far [m] the footprint goes along an arc of curvature `bend`, ahead, before a point is in it."""
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
        for n in range(points.shape[0]):
            dx = points[n, 0] - x
            dy = points[n, 1] - y
            along = c * dx + s * dy
            if rear < along < front and abs(c * dy - s * dx) < half_width:
                return way - step
    return horizon


@kernel
def wander_car(
    ranges: Floats,
    pose: Floats,
    beams: Floats,
    half_angle: Floats,
    samples: int,
    front: float,
    rear: float,
    half_width: float,
    speed: Column,
    clearance: Column,
    limits: Floats,
    curvature_max: Floats,
    draws: Floats,
    dt: float,
    memory: Floats,
    trail: Floats,
    seen: Floats,
    out: Floats,
) -> None:
    """Twists of wandering cars, into `out` (N, 3).

    Parameters
    ----------
    ranges, pose, beams, half_angle, samples
        As in `amorsim.kernels.behaviours.wandering.wander`.
    front, rear, half_width
        The footprint about the base point [m]; `rear` is negative.
    speed, clearance
        Fastest [m/s], and what is kept free beside and before it [m], each (N, 1).
    limits, curvature_max
        Of the drive, (N, 4) and (N, 1).
    draws
        Uniform random numbers, (N, 2).
    memory, trail, seen
        What it remembers, (N, CAR_COLUMNS), the places where its base point was, (N, m, 2), and where it saw
        something, (N, p, 2), by its estimate; changed.
    """
    count = ranges.shape[1] * samples
    now = np.empty((3, count))
    points = np.empty((count + seen.shape[1], 2))
    length = front - rear
    places = trail.shape[1]
    for i in range(ranges.shape[0]):
        see_points(ranges[i], beams[i], half_angle[i, 0], now)
        for n in range(count):
            points[n, 0] = now[0, n]
            points[n, 1] = now[1, n]
        own = memory[i]
        c = math.cos(pose[i, 2])
        s = math.sin(pose[i, 2])
        kept = int(own[_SEEN])
        for n in range(seen.shape[1]):
            points[count + n, 0] = math.inf
            points[count + n, 1] = math.inf
            if n < kept:
                dx = seen[i, n, 0] - pose[i, 0]
                dy = seen[i, n, 1] - pose[i, 1]
                points[count + n, 0] = c * dx + s * dy
                points[count + n, 1] = c * dy - s * dx
        for n in range(0, count, max(count // _KEPT, 1)):
            x = points[n, 0]
            y = points[n, 1]
            if math.isfinite(x) and x * x + y * y < (_NEAR * length) ** 2:
                seen[i, kept % seen.shape[1], 0] = pose[i, 0] + c * x - s * y
                seen[i, kept % seen.shape[1], 1] = pose[i, 1] + s * x + c * y
                kept += 1
        own[_SEEN] = kept
        fastest = min(speed[i, 0], limits[i, 0])
        braking = limits[i, 2]
        sharpest = curvature_max[i, 0]
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
            keep = max(clearance[i, 0], 0.25 * half_width)
            best = -math.inf
            room = 0.0
            for k in range(2 * _ARCS + 1):
                part = (k - _ARCS) / _ARCS
                free = _room(points, part * sharpest, front + keep, rear, half_width + keep, _HORIZON * length)
                worth = free - 0.2 * length * abs(part - own[_LEAN])
                if worth > best:
                    best = worth
                    room = free
                    bend = part * sharpest
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
