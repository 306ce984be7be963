"""The directions of beams as kernels take them, and the rays of cones."""

from __future__ import annotations

import functools
import math

import numpy as np

from amorsim.array_types import Array
from amorsim.kernels.kinematics import poses

__all__ = ["Table", "cone_bearings", "cone_directions", "directions_of"]

Table = tuple[Array, Array]
"""Cosines and sines of beams, (1, k) or one row for each origin."""

CONE_STEP = math.radians(0.05)  # the definition of a sonar's reading: rays at most this far apart


def directions_of(bearings: Array) -> Table:
    """Cosines and sines of bearings [rad]."""
    cos_b, sin_b = np.empty(bearings.shape), np.empty(bearings.shape)
    poses.directions(np.ascontiguousarray(bearings), cos_b, sin_b)
    return cos_b, sin_b


@functools.lru_cache(maxsize=64)
def cone_bearings(half_angle: float) -> Array:
    """The rays of a cone `(1, k)`: both edges, and between them at most 0.05 degrees apart."""
    count = max(2, math.ceil(2.0 * half_angle / CONE_STEP - 1e-9) + 1)
    return np.linspace(-half_angle, half_angle, count)[None, :]


@functools.lru_cache(maxsize=64)
def cone_directions(half_angle: float) -> Table:
    """Cosines and sines of a cone's rays."""
    return directions_of(cone_bearings(half_angle))
