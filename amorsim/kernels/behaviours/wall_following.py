"""Keeping a wall at one side, by the nearest point of it."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from amorsim.array_types import Array
from amorsim.kernels.behaviours.free_space import Sight, free_way, see_points
from amorsim.kernels.compile import kernel

__all__ = ["follow_wall"]

# A component's parameter over rows, (N, 1) float64; declared as the number that it is for one row.
Column = Any

_FROM = math.radians(-40.0)  # bearings among which the wall is looked for, of one on the left
_TO = math.radians(150.0)
_NEAR = 3.0  # times the distance to keep, within which a wall is one to follow
_TIME_TO_STOP = 0.8  # [s] the way ahead is never driven faster than in this time
_SHUT = 0.6  # of the distance to keep: with less room ahead it turns away in place


@kernel
def follow_wall(
    sight: Sight,
    half_width: float,
    side: float,
    distance: Column,
    speed: Column,
    turn_rate: Column,
    limits: Array,
    curvature_max: Array,
    memory: Array,
    out: Array,
) -> None:
    """Twists that keep a wall at `distance` (N, 1) [m] from the base point, into `out` (N, 3).

    `side` is 1 for a wall on the left, -1 on the right; `memory` (N, 1) is 1 once a wall was met, and changed. The
    curvature is the error of distance over the square of half the distance to keep, and twice the wall's error of
    bearing over that half: critically damped, within about that length.
    """
    points = np.empty((3, sight.ranges.shape[1] * sight.samples))
    for i in range(sight.ranges.shape[0]):
        see_points(sight.ranges[i], sight.beams[i], sight.half_angle[i, 0], points)
        keep = distance[i, 0]
        nearest = math.inf
        bearing = 0.0
        for j in range(points.shape[1]):
            if not math.isfinite(points[0, j]):
                continue
            b = math.atan2(side * points[1, j], points[0, j])
            d = math.sqrt(points[0, j] ** 2 + points[1, j] ** 2)
            if _FROM <= b <= _TO and d < nearest:
                nearest = d
                bearing = b
        fastest = min(speed[i, 0], limits[i, 0])
        turn_fastest = min(turn_rate[i, 0], limits[i, 1])
        ahead = free_way(points, 0.0, half_width, 0.0)
        if nearest < _NEAR * keep:
            memory[i, 0] = 1.0
            half = 0.5 * keep
            bend = (nearest - keep) / (half * half) + 2.0 * (bearing - 0.5 * math.pi) / half
        else:
            bend = 1.0 / keep if memory[i, 0] == 1.0 else 0.0  # round the end of the wall, or on until there is one
        sharpest = min(curvature_max[i, 0], 2.0 / keep)
        bend = min(max(bend, -sharpest), sharpest)
        if ahead + half_width < keep + 1.0 / sharpest:
            bend = -sharpest  # a quarter of the sharpest circle ends at the distance to keep from what is ahead
        v = min(fastest, max(ahead, 0.0) / _TIME_TO_STOP)
        if math.isfinite(limits[i, 2]):
            v = min(v, math.sqrt(limits[i, 2] * max(ahead, 0.0)))
        v = min(v, turn_fastest / max(abs(bend), 1e-9))
        w = v * bend
        if math.isinf(curvature_max[i, 0]) and ahead < _SHUT * keep:
            v = 0.0
            w = -turn_fastest
        out[i, 0] = v
        out[i, 1] = 0.0
        out[i, 2] = side * w
