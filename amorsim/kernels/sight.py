"""Which marks lie within reach of those who look for them, the nearest first; whether they are hidden is not asked."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from amorsim.kernels.compile import kernel
from amorsim.kernels.poses import wrap

__all__ = ["marks_near"]

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


@kernel
def marks_near(
    poses: Floats,
    range_max: Floats,
    half_angle: Floats,
    replica: Ints,
    own: Ints,
    places: Floats,
    carrier: Ints,
    first: Ints,
    mark: Ints,
    distance: Floats,
    bearing: Floats,
) -> int:
    """How many pairs there are of one who looks and a mark within his reach.

    Parameters
    ----------
    poses
        From where each row looks, (N, 3) x [m], y [m], heading [rad] in the world.
    range_max, half_angle
        How far [m], and how far to either side [rad], (N,).
    replica, own
        Of each row, and the body that it sits on, int64 (N,).
    places
        Of the marks in each replica [m], (R, F, 2).
    carrier
        The body that carries each mark in each replica, -1 for none, int64 (R, F).
    first
        Gets where the pairs of each row begin, and their number, int64 (N + 1,).
    mark, distance, bearing
        Get the pairs of row i as ``first[i]:first[i + 1]``, the nearest first and of equally near ones the first,
        as far as there is room: which mark, how far off [m], and in what direction from the heading [rad], (Q,).
    """
    found = 0
    room = mark.shape[0]
    for i in range(poses.shape[0]):
        first[i] = found
        r = replica[i]
        limit = range_max[i] * range_max[i]
        for f in range(places.shape[1]):
            if carrier[r, f] == own[i]:
                continue
            dx = places[r, f, 0] - poses[i, 0]
            dy = places[r, f, 1] - poses[i, 1]
            square = dx * dx + dy * dy
            if not square <= limit:
                continue
            angle = wrap(math.atan2(dy, dx) - poses[i, 2]) if square > 0.0 else 0.0
            if abs(angle) > half_angle[i]:
                continue
            if found < room:
                away = math.sqrt(square)
                place = found
                while place > first[i] and distance[place - 1] > away:
                    mark[place] = mark[place - 1]
                    distance[place] = distance[place - 1]
                    bearing[place] = bearing[place - 1]
                    place -= 1
                mark[place] = f
                distance[place] = away
                bearing[place] = angle
            found += 1
    first[poses.shape[0]] = found
    return found
