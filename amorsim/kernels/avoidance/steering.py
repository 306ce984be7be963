"""From places on a path and wanted velocities to twists that a drive can have."""

from __future__ import annotations

import math
from typing import Any

from amorsim.array_types import Array
from amorsim.kernels.avoidance.dynamic_window import moved_on
from amorsim.kernels.avoidance.guide import Guide, ahead_on, find_leg
from amorsim.kernels.behaviours.free_space import Sight, see_points
from amorsim.kernels.compile import kernel

__all__ = ["aims", "bearing_twists", "points_seen", "twists_towards"]

Column = Any


@kernel
def aims(pose: Array, guide: Guide, look: Column, out: Array) -> None:
    """The place `look` (N, 1) [m] ahead on each robot's path, in its own frame, into `out` (N, 2) [m]."""
    for i in range(pose.shape[0]):
        x, y = pose[i, 0], pose[i, 1]
        path = guide.path[i]
        along = guide.along[i]
        leg, here = find_leg(path, along, guide.size[i], guide.leg[i], 3.0, x, y)
        guide.leg[i] = leg
        ax, ay = ahead_on(path, along, guide.size[i], leg, here + look[i, 0])
        c = math.cos(pose[i, 2])
        s = math.sin(pose[i, 2])
        out[i, 0] = c * (ax - x) + s * (ay - y)
        out[i, 1] = c * (ay - y) - s * (ax - x)


@kernel
def twists_towards(
    velocity: Array,
    speed: Column,
    turn_rate: Column,
    time: Column,
    relaxation: Array,
    limits: Array,
    dt: float,
    moving: Array,
    out: Array,
) -> None:
    """Twists by which robots that cannot move sideways follow velocities (N, 2) in their own frames, into `out` (N, 3).

    They turn to the velocity within `time` (N, 1) [s], and drive as fast ahead as it points ahead. Twists follow what
    is wanted with the time constant `relaxation` (N, 1) [s]. `moving` (N, 2) is v and w by their own reckoning;
    changed.
    """
    for i in range(velocity.shape[0]):
        fast = math.sqrt(velocity[i, 0] * velocity[i, 0] + velocity[i, 1] * velocity[i, 1])
        v = 0.0
        w = 0.0
        if fast > 0.0:
            off = math.atan2(velocity[i, 1], velocity[i, 0])
            most = min(turn_rate[i, 0], limits[i, 1])
            w = min(max(off / max(time[i, 0], dt), -most), most)
            v = min(max(velocity[i, 0], 0.0), speed[i, 0], limits[i, 0])
            if math.isfinite(limits[i, 0]) and v > 0.0:
                # The motors that turn also drive.
                v = min(v, limits[i, 0] * max(1.0 - abs(w) / limits[i, 1], 0.0))
        if relaxation[i, 0] > 0.0:
            left = math.exp(-dt / relaxation[i, 0])
            v += left * (moving[i, 0] - v)
            w += left * (moving[i, 1] - w)
        gain = limits[i, 2] * dt
        spin = limits[i, 3] * dt
        v = min(max(v, moving[i, 0] - gain), moving[i, 0] + gain)
        w = min(max(w, moving[i, 1] - spin), moving[i, 1] + spin)
        moving[i, 0] = v
        moving[i, 1] = w
        out[i, 0] = v
        out[i, 1] = 0.0
        out[i, 2] = w


@kernel
def points_seen(sight: Sight, age: Array, moving: Array, first: int, end: int, out: Array) -> None:
    """The points that robots see, in their own frames now, into `out` (N, 3, p) [m]; inf for none."""
    for i in range(first, end):
        see_points(sight.ranges[i], sight.beams[i], sight.half_angle[i, 0], out[i])
        moved_on(out[i], moving[i, 0], moving[i, 1], age[i, 0])


@kernel
def bearing_twists(
    points: Array,
    bearing: Array,
    target: Array,
    speed: Column,
    turn_rate: Column,
    time: Column,
    room: Array,
    slow: Column,
    out: Array,
) -> None:
    """Twists (v, w) that turn robots to bearings (N, 1), into `out` (N, 2); nan turns in place to the target.

    They drive slower the farther the bearing is off, and where something is nearer than `slow` (N, 1) [m] to a disc of
    radius `room` (N, 1) [m] in the half ahead, and stop within a metre's fraction of the target, (N, 2) [m].
    """
    for i in range(bearing.shape[0]):
        off = bearing[i, 0]
        drives = True
        if math.isnan(off):
            off = math.atan2(target[i, 1], target[i, 0])
            drives = False
        most = turn_rate[i, 0]
        out[i, 1] = min(max(off / time[i, 0], -most), most)
        out[i, 0] = 0.0
        ahead = math.cos(off)
        if not drives or ahead <= 0.0:
            continue
        nearest = math.inf
        for n in range(points.shape[2]):
            x = points[i, 0, n]
            y = points[i, 1, n]
            if x > 0.0 and x < math.inf and abs(y) < math.inf:
                nearest = min(nearest, math.sqrt(x * x + y * y) - room[i, 0])
        free = min(1.0, max(nearest, 0.0) / slow[i, 0])
        left = math.sqrt(target[i, 0] * target[i, 0] + target[i, 1] * target[i, 1])
        out[i, 0] = min(speed[i, 0] * ahead * ahead * max(free, 0.2), left / time[i, 0])
