"""The forces that push pedestrians away from others and from walls, by D. Helbing and P. Molnár (1995)."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from amorsim.array_types import Array, Bools, Ints
from amorsim.kernels import elementary
from amorsim.kernels.compile import kernel, part

__all__ = ["NEGLIGIBLE", "Passers", "Walls", "range_of", "social_forces"]


NEGLIGIBLE = 1e-7
"""Forces [m/s^2] from about here on down count as none."""
LEAST = 1e-6  # [m] to which semi-axes and distances are rounded up
SLACK = 1e-6  # [m] more than any rounding of a distance


def range_of(strength: Array, width: Array, ahead: Array, relative: Array, later: Array, pace: Array) -> Array:
    """The distance [m] within which others have forces on a pedestrian that are not negligible; elementwise.

    Others come nearer for `ahead` + `later` [s]; `social_forces` leaves out bodies that are farther away. `pace` is the
    pedestrian's speed [m/s]; the rest are columns of `social_forces`' `numbers`.
    """
    push = width * elementary.log(np.maximum(strength / width / NEGLIGIBLE, 1.0))
    return np.asarray(push + pace * (later + ahead * relative) + SLACK)


class Passers(NamedTuple):
    """The bodies that the pedestrians may meet; of all replicas, T of them."""

    poses: Array
    """(T, 3) x, y [m], heading [rad]."""
    twists: Array
    """(T, 3) [m/s, m/s, rad/s], each in its body's frame."""
    reach: Array
    """(T,) radius [m] of each body's circle."""
    is_robot: Bools
    """(T,)"""


class Walls(NamedTuple):
    """The walls around each pedestrian."""

    distances: Array
    """(N, k) [m], inf for none; those that are least among their neighbours count."""
    bearings: Array
    """(k, 2) cosine and sine of the direction of each, evenly around."""


@part
def _pull(rx: float, ry: float, reach: float, step_x: float, step_y: float) -> tuple[float, float, float, float]:
    """Twice the mean direction to the foci of the ellipse around another's step, and the distances [m] to them.

    `rx`, `ry` [m] is the way from the other's middle, `reach` [m] the radius of its circle.
    """
    distance = math.sqrt(rx * rx + ry * ry)
    # From the pedestrian's centre to the other's outline.
    share = max(distance - reach, LEAST) / max(distance, LEAST)
    rx, ry = rx * share, ry * share
    qx, qy = rx - step_x, ry - step_y
    near = max(math.sqrt(rx * rx + ry * ry), LEAST)
    far = max(math.sqrt(qx * qx + qy * qy), LEAST)
    return rx / near + qx / far, ry / near + qy / far, near, far


@part
def _in_sight(px: float, py: float, wanted_x: float, wanted_y: float, cosine: float) -> float:
    """Not negative if a thing that pushes along (px, py) is in sight; 0 at the edge of the sight."""
    return -(px * wanted_x + py * wanted_y) - math.sqrt(px * px + py * py) * cosine


@part
def _share(before: float, after: float) -> float:
    """The share of a step during which a number is not negative, if it changes linearly from one value to another."""
    if before >= 0.0:
        return 1.0 if after >= 0.0 else before / (before - after)
    return after / (after - before) if after > 0.0 else 0.0


@kernel
def social_forces(
    passers: Passers,
    own: Ints,
    first: Ints,
    body: Ints,
    velocity: Array,
    wanted: Array,
    walls: Walls,
    numbers: Array,
    begin: int,
    end: int,
    out: Array,
) -> None:
    """Accelerations [m/s^2] by which others and walls repel pedestrians, after some time at constant velocities.

    That time is the middle of a step. Somebody who comes into sight or goes out of it within the step has the mean of
    both weights.

    At a distance d from another whose step has the length s, b is at least sqrt(d (d - s)): if that makes a force
    negligible, it is left out.

    Parameters
    ----------
    passers
        All bodies.
    own
        (N,) which of the bodies is the pedestrian.
    first, body
        The bodies that pedestrian n looks at are ``body[first[n]:first[n + 1]]``. They must be in order, without
        the pedestrian's own, and include all that are within `range_of` of the pedestrian in its time ahead.
    velocity
        (N, 2) of the pedestrians over the ground [m/s].
    wanted
        (N, 4) unit vectors towards the pedestrian's goal, at the beginning and at the end of the step.
    walls
        The walls around.
    numbers
        (N, 10) strength [m^2/s^2] and range [m] of the repulsion by others, how far ahead [s] their steps are seen,
        strength and range of that by walls, cosine of half the angle of sight, weight of what is out of it, how
        much of the own step is subtracted from theirs (0 or 1), how far ahead [s] the forces are asked for, and whether
        robots count (0 or 1).
    begin, end
        The pedestrians that are worked on.
    out
        (N, 2) the sums, in order of body, then of bearing.
    """
    poses, twists, reach = passers.poses, passers.twists, passers.reach
    bearings = walls.bearings
    rays = bearings.shape[0]
    # Velocities over the ground and speeds, each computed when it is first needed.
    over_ground = np.empty((reach.shape[0], 3))
    known = np.zeros(reach.shape[0], dtype=np.bool_)
    for n in range(begin, end):
        strength, width, ahead = numbers[n, 0], numbers[n, 1], numbers[n, 2]
        wall_strength, wall_width = numbers[n, 3], numbers[n, 4]
        later = numbers[n, 8]
        vx, vy = velocity[n, 0], velocity[n, 1]
        now_x, now_y = poses[own[n], 0], poses[own[n], 1]
        my_x, my_y = vx * ahead * numbers[n, 7], vy * ahead * numbers[n, 7]
        pace = math.sqrt(vx * vx + vy * vy)
        relevant = width * math.log(max(strength / width / NEGLIGIBLE, 1.0))
        relevant *= relevant
        sum_x, sum_y = 0.0, 0.0
        for k in range(first[n], first[n + 1]):
            b = body[k]
            if passers.is_robot[b] and numbers[n, 9] == 0.0:
                continue
            if not known[b]:
                known[b] = True
                c, s = math.cos(poses[b, 2]), math.sin(poses[b, 2])
                over_ground[b, 0] = c * twists[b, 0] - s * twists[b, 1]
                over_ground[b, 1] = s * twists[b, 0] + c * twists[b, 1]
                over_ground[b, 2] = math.sqrt(twists[b, 0] * twists[b, 0] + twists[b, 1] * twists[b, 1])
            its_x, its_y, fast = over_ground[b, 0], over_ground[b, 1], over_ground[b, 2]
            # Now, and if both went for each other.
            rx, ry = now_x - poses[b, 0], now_y - poses[b, 1]
            gap = math.sqrt(rx * rx + ry * ry) - reach[b] - (fast + pace) * later
            beyond = gap - (fast + pace * numbers[n, 7]) * ahead
            if beyond > 0.0 and gap * beyond > relevant:
                continue
            step_x, step_y = its_x * ahead - my_x, its_y * ahead - my_y
            to_x, to_y = (vx - its_x) * later, (vy - its_y) * later
            px, py, _, _ = _pull(rx, ry, reach[b], step_x, step_y)
            before = _in_sight(px, py, wanted[n, 0], wanted[n, 1], numbers[n, 5])
            px, py, _, _ = _pull(rx + 2.0 * to_x, ry + 2.0 * to_y, reach[b], step_x, step_y)
            after = _in_sight(px, py, wanted[n, 2], wanted[n, 3], numbers[n, 5])
            seen = _share(before, after)
            px, py, near, far = _pull(rx + to_x, ry + to_y, reach[b], step_x, step_y)
            both = near + far
            # The semi-minor axis of the ellipse around the other's step through the pedestrian.
            axis = max(0.5 * math.sqrt(max(both * both - step_x * step_x - step_y * step_y, 0.0)), LEAST)
            size = strength / width * math.exp(-axis / width) * both / (4.0 * axis)
            weight = seen + (1.0 - seen) * numbers[n, 6]
            sum_x += weight * (size * px)
            sum_y += weight * (size * py)
        for k in range(rays):
            near = walls.distances[n, k]
            if near < math.inf and near <= walls.distances[n, k - 1] and near < walls.distances[n, (k + 1) % rays]:
                near = max(near - (vx * bearings[k, 0] + vy * bearings[k, 1]) * later, 0.0)
                size = wall_strength / wall_width * math.exp(-near / wall_width)
                sum_x -= size * bearings[k, 0]
                sum_y -= size * bearings[k, 1]
        out[n, 0] = sum_x
        out[n, 1] = sum_y
