"""An artificial potential: the goal attracts, and obstacles repel."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from amorsim.array_types import Array
from amorsim.kernels.compile import kernel

__all__ = ["push_away"]

Column = Any

_LEAST = 0.02  # [m] to which distances are rounded up
_SECTORS = 64  # in each, the nearest point repels
_NO_FORCE = 0.05  # of the attraction: less is none


@kernel
def push_away(
    points: Array, room: Array, target: Array, strength: Column, far: Column, force: Array, bearing: Array
) -> None:
    """Directions of the force, into `bearing` (N, 1) [rad], nan where it is about 0, and forces, into `force` (N, 2).

    The attraction has the size 1. In each of 64 sectors the nearest of the points (N, 2, p) repels, by its distance
    from a disc of radius `room` (N, 1) [m], up to `far` (N, 1) [m].
    """
    nearest = np.empty(_SECTORS)
    for i in range(target.shape[0]):
        nearest[:] = math.inf
        for n in range(points.shape[2]):
            x = points[i, 0, n]
            y = points[i, 1, n]
            if abs(x) < math.inf and abs(y) < math.inf:
                sector = int((math.atan2(y, x) + math.pi) / (2.0 * math.pi) * _SECTORS) % _SECTORS
                nearest[sector] = min(nearest[sector], math.sqrt(x * x + y * y) - room[i, 0])
        away = math.sqrt(target[i, 0] * target[i, 0] + target[i, 1] * target[i, 1])
        fx = target[i, 0] / away if away > 0.0 else 0.0
        fy = target[i, 1] / away if away > 0.0 else 0.0
        for sector in range(_SECTORS):
            if nearest[sector] < far[i, 0]:
                angle = (sector + 0.5) * 2.0 * math.pi / _SECTORS - math.pi
                size = strength[i, 0] * (1.0 / max(nearest[sector], _LEAST) - 1.0 / far[i, 0]) * 8.0 / _SECTORS
                fx -= size * math.cos(angle)
                fy -= size * math.sin(angle)
        force[i, 0] = fx
        force[i, 1] = fy
        bearing[i, 0] = math.atan2(fy, fx) if fx * fx + fy * fy > _NO_FORCE * _NO_FORCE else math.nan
