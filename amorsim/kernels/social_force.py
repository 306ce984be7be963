"""What pushes pedestrians away from others and from walls: the forces of D. Helbing and P. Molnár (1995)."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from amorsim.kernels.compile import kernel

__all__ = ["social_forces"]

Floats = NDArray[np.float64]

FARTHEST = 6.0
"""Who is farther away than this [m] is not heeded: a force of less than 1e-7 m/s^2."""
LEAST = 1e-6  # [m] to which semi-axes and distances are rounded up


@kernel
def social_forces(
    poses: Floats,
    twists: Floats,
    reach: Floats,
    heeded: NDArray[np.bool_],
    own: NDArray[np.int64],
    wanted: Floats,
    walls: Floats,
    bearings: Floats,
    numbers: Floats,
    out: Floats,
) -> None:
    """Accelerations [m/s^2] by which others and walls repel pedestrians.

    Parameters
    ----------
    poses, twists
        (N, B, 3) of all bodies around each: x, y [m], heading [rad], and velocities [m/s, m/s, rad/s] in their frames.
    reach
        (B,) radius [m] of each body's circle.
    heeded
        (N, B) whether a pedestrian minds it.
    own
        (N,) which of the bodies is the pedestrian.
    wanted
        (N, 2) unit vector to where he wants to go.
    walls
        (N, k) distances [m] to walls, inf for none; those that are least among their neighbours count.
    bearings
        (k, 2) cosine and sine of the direction of each, evenly around.
    numbers
        (N, 8) strength [m^2/s^2] and range [m] of the repulsion by others, how far ahead [s] their steps are seen,
        strength and range of that by walls, cosine of half the angle of sight, weight of what is out of it, and how
        much of his own step is taken from theirs (0 or 1).
    out
        (N, 2) the sums, in order of body, then of bearing.
    """
    rays = walls.shape[1]
    for n in range(poses.shape[0]):
        strength, width, ahead = numbers[n, 0], numbers[n, 1], numbers[n, 2]
        wall_strength, wall_width = numbers[n, 3], numbers[n, 4]
        x, y = poses[n, own[n], 0], poses[n, own[n], 1]
        c, s = math.cos(poses[n, own[n], 2]), math.sin(poses[n, own[n], 2])
        my_x = (c * twists[n, own[n], 0] - s * twists[n, own[n], 1]) * ahead * numbers[n, 7]
        my_y = (s * twists[n, own[n], 0] + c * twists[n, own[n], 1]) * ahead * numbers[n, 7]
        sum_x, sum_y = 0.0, 0.0
        for b in range(poses.shape[1]):
            if b == own[n] or not heeded[n, b]:
                continue
            rx, ry = x - poses[n, b, 0], y - poses[n, b, 1]
            distance = math.sqrt(rx * rx + ry * ry)
            if not distance - reach[b] < FARTHEST:
                continue
            # From his middle to the other's outline.
            share = max(distance - reach[b], LEAST) / max(distance, LEAST)
            rx, ry = rx * share, ry * share
            c, s = math.cos(poses[n, b, 2]), math.sin(poses[n, b, 2])
            step_x = (c * twists[n, b, 0] - s * twists[n, b, 1]) * ahead - my_x
            step_y = (s * twists[n, b, 0] + c * twists[n, b, 1]) * ahead - my_y
            qx, qy = rx - step_x, ry - step_y
            near = max(math.sqrt(rx * rx + ry * ry), LEAST)
            far = max(math.sqrt(qx * qx + qy * qy), LEAST)
            both = near + far
            # The semi-minor axis of the ellipse about the other's step that goes through him.
            axis = max(0.5 * math.sqrt(max(both * both - step_x * step_x - step_y * step_y, 0.0)), LEAST)
            size = strength / width * math.exp(-axis / width) * both / (4.0 * axis)
            fx, fy = size * (rx / near + qx / far), size * (ry / near + qy / far)
            seen = -(fx * wanted[n, 0] + fy * wanted[n, 1]) >= math.sqrt(fx * fx + fy * fy) * numbers[n, 5]
            weight = 1.0 if seen else numbers[n, 6]
            sum_x += weight * fx
            sum_y += weight * fy
        for k in range(rays):
            near = walls[n, k]
            if near < math.inf and near <= walls[n, k - 1] and near < walls[n, (k + 1) % rays]:
                size = wall_strength / wall_width * math.exp(-near / wall_width)
                sum_x -= size * bearings[k, 0]
                sum_y -= size * bearings[k, 1]
        out[n, 0] = sum_x
        out[n, 1] = sum_y
