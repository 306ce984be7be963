"""What pushes pedestrians away from others and from walls: the forces of D. Helbing and P. Molnár (1995)."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from amorsim.kernels.compile import kernel

__all__ = ["NEGLIGIBLE", "social_forces"]

Floats = NDArray[np.float64]

NEGLIGIBLE = 1e-7
"""Forces [m/s^2] from about here on down count as none."""
LEAST = 1e-6  # [m] to which semi-axes and distances are rounded up


@kernel
def social_forces(
    poses: Floats,
    twists: Floats,
    reach: Floats,
    heeded: NDArray[np.bool_],
    own: NDArray[np.int64],
    velocity: Floats,
    wanted: Floats,
    walls: Floats,
    bearings: Floats,
    numbers: Floats,
    out: Floats,
) -> None:
    """Accelerations [m/s^2] by which others and walls repel pedestrians, some time ahead, as all go on as they do.

    At a distance d from another whose step has the length s, b is at least sqrt(d (d - s)): where that makes a force
    negligible, it is left out.

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
    velocity
        (N, 2) of the pedestrians over the ground [m/s].
    wanted
        (N, 2) unit vector to where he wants to go.
    walls
        (N, k) distances [m] to walls, inf for none; those that are least among their neighbours count.
    bearings
        (k, 2) cosine and sine of the direction of each, evenly around.
    numbers
        (N, 9) strength [m^2/s^2] and range [m] of the repulsion by others, how far ahead [s] their steps are seen,
        strength and range of that by walls, cosine of half the angle of sight, weight of what is out of it, how
        much of his own step is taken from theirs (0 or 1), and how far ahead [s] the forces are asked for.
    out
        (N, 2) the sums, in order of body, then of bearing.
    """
    rays = walls.shape[1]
    for n in range(poses.shape[0]):
        strength, width, ahead = numbers[n, 0], numbers[n, 1], numbers[n, 2]
        wall_strength, wall_width = numbers[n, 3], numbers[n, 4]
        later = numbers[n, 8]
        vx, vy = velocity[n, 0], velocity[n, 1]
        x, y = poses[n, own[n], 0] + vx * later, poses[n, own[n], 1] + vy * later
        my_x, my_y = vx * ahead * numbers[n, 7], vy * ahead * numbers[n, 7]
        pace = math.sqrt(vx * vx + vy * vy)
        relevant = width * math.log(max(strength / width / NEGLIGIBLE, 1.0))
        relevant *= relevant
        sum_x, sum_y = 0.0, 0.0
        for b in range(poses.shape[1]):
            if b == own[n] or not heeded[n, b]:
                continue
            # Now, and if both went for each other.
            rx, ry = poses[n, own[n], 0] - poses[n, b, 0], poses[n, own[n], 1] - poses[n, b, 1]
            fast = math.sqrt(twists[n, b, 0] * twists[n, b, 0] + twists[n, b, 1] * twists[n, b, 1])
            gap = math.sqrt(rx * rx + ry * ry) - reach[b] - (fast + pace) * later
            beyond = gap - (fast + pace * numbers[n, 7]) * ahead
            if beyond > 0.0 and gap * beyond > relevant:
                continue
            c, s = math.cos(poses[n, b, 2]), math.sin(poses[n, b, 2])
            its_x, its_y = c * twists[n, b, 0] - s * twists[n, b, 1], s * twists[n, b, 0] + c * twists[n, b, 1]
            step_x, step_y = its_x * ahead - my_x, its_y * ahead - my_y
            rx, ry = x - (poses[n, b, 0] + its_x * later), y - (poses[n, b, 1] + its_y * later)
            distance = math.sqrt(rx * rx + ry * ry)
            gap = distance - reach[b]
            # From his middle to the other's outline.
            share = max(gap, LEAST) / max(distance, LEAST)
            rx, ry = rx * share, ry * share
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
                near = max(near - (vx * bearings[k, 0] + vy * bearings[k, 1]) * later, 0.0)
                size = wall_strength / wall_width * math.exp(-near / wall_width)
                sum_x -= size * bearings[k, 0]
                sum_y -= size * bearings[k, 1]
        out[n, 0] = sum_x
        out[n, 1] = sum_y
