"""The unscented transform: a Gaussian of four numbers carried through a function by sigma points.

An update by two numbers needs slopes of what is expected, and the spread that slopes leave out. Both follow from the
points, by statistical linear regression: the update itself is that of the extended filter then. Sources: S. J. Julier,
J. K. Uhlmann, "Unscented filtering and nonlinear estimation", Proc. IEEE 92 (2004); T. Lefebvre, H. Bruyninckx,
J. De Schutter, "Comment on 'A new method for the nonlinear transformation of means and covariances'", IEEE Trans.
Automatic Control 47 (2002), for the regression.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from amorsim.array_types import Array
from amorsim.kernels.compile import kernel
from amorsim.kernels.filters.gaussians import root
from amorsim.kernels.kinematics.poses import arc, wrap

__all__ = ["LANDMARK", "PLACE", "Transform", "Work", "expect_by_points", "expected", "predict_by_points", "work"]


# What two numbers are of: a landmark's range and bearing, or a mount's place.
LANDMARK, PLACE = 0, 1
NEAREST = 1e-9  # [m] a landmark has no bearing from its own place


class Transform(NamedTuple):
    """How expected measurements follow from a mean and a covariance."""

    by_points: bool  # or by slopes at the mean
    reach: float  # of the points, in standard deviations
    middle: float  # weight of the mean itself in the spread
    each: float  # weight of each other point


class Work(NamedTuple):
    """Room for one update of two numbers."""

    slopes: Array  # (2, 4) of the expected numbers by the state
    spreads: Array  # (2, 4) covariance of the state with them
    residual: Array  # (2,)
    extra: Array  # (3,) covariance 11, 12, 22 of the expected numbers that slopes leave out
    root: Array  # (4, 4) of the covariance
    ends: Array  # (8, 4) the points, or what is expected at them


def work() -> Work:
    """Work arrays for the updates of one call."""
    return Work(np.empty((2, 4)), np.empty((2, 4)), np.empty(2), np.zeros(3), np.zeros((4, 4)), np.empty((8, 4)))


@kernel
def expected(kind: int, x: float, y: float, heading: float, mount: Array, u: float, v: float) -> tuple[float, float]:
    """The two numbers expected from a pose: range and bearing of a landmark at (u, v), or the mount's place."""
    c = math.cos(heading)
    s = math.sin(heading)
    at_x = x + (c * mount[0] - s * mount[1])
    at_y = y + (s * mount[0] + c * mount[1])
    if kind == PLACE:
        return at_x, at_y
    dx = u - at_x
    dy = v - at_y
    return math.sqrt(dx * dx + dy * dy), wrap(math.atan2(dy, dx) - heading - mount[2])


@kernel
def expect_by_points(
    kind: int,
    mean: Array,
    p: Array,
    mount: Array,
    u: float,
    v: float,
    first: float,
    second: float,
    transform: Transform,
    at: Work,
) -> bool:
    """Compare two numbers with those expected at the points, into `at`; False where a landmark has no bearing."""
    middle_0, middle_1 = expected(kind, mean[0], mean[1], mean[2], mount, u, v)
    if kind == LANDMARK and not middle_0 > NEAREST:
        return False
    root(p, at.root)
    offset_0 = 0.0
    offset_1 = 0.0
    for i in range(4):
        for side in range(2):
            reach = transform.reach if side == 0 else -transform.reach
            if kind == LANDMARK:  # along arcs, as an update by it moves the mean
                x, y, turn = arc(at.root[0, i], at.root[1, i], at.root[2, i], reach)
            else:
                x, y, turn = reach * at.root[0, i], reach * at.root[1, i], reach * at.root[2, i]
            one, other = expected(kind, mean[0] + x, mean[1] + y, mean[2] + turn, mount, u, v)
            # Differences from what the mean expects, so that bearings are averaged on one side of the circle.
            k = 2 * i + side
            at.ends[k, 0] = one - middle_0
            at.ends[k, 1] = wrap(other - middle_1) if kind == LANDMARK else other - middle_1
            offset_0 += transform.each * at.ends[k, 0]
            offset_1 += transform.each * at.ends[k, 1]
    r11 = transform.middle * offset_0 * offset_0
    r12 = transform.middle * offset_0 * offset_1
    r22 = transform.middle * offset_1 * offset_1
    for k in range(8):
        d0 = at.ends[k, 0] - offset_0
        d1 = at.ends[k, 1] - offset_1
        r11 += transform.each * d0 * d0
        r12 += transform.each * d0 * d1
        r22 += transform.each * d1 * d1
    # Slopes H with H L = G, where G is how the numbers change along each column of the root L.
    for i in range(3, -1, -1):
        g0 = (at.ends[2 * i, 0] - at.ends[2 * i + 1, 0]) / (2.0 * transform.reach)
        g1 = (at.ends[2 * i, 1] - at.ends[2 * i + 1, 1]) / (2.0 * transform.reach)
        r11 -= g0 * g0
        r12 -= g0 * g1
        r22 -= g1 * g1
        for k in range(i + 1, 4):
            g0 -= at.slopes[0, k] * at.root[k, i]
            g1 -= at.slopes[1, k] * at.root[k, i]
        pivot = at.root[i, i]
        at.slopes[0, i] = g0 / pivot if pivot > 0.0 else 0.0
        at.slopes[1, i] = g1 / pivot if pivot > 0.0 else 0.0
    at.extra[0] = max(r11, 0.0)
    at.extra[1] = r12 if r11 > 0.0 and r22 > 0.0 else 0.0
    at.extra[2] = max(r22, 0.0)
    at.residual[0] = first - (middle_0 + offset_0)
    at.residual[1] = second - (middle_1 + offset_1)
    if kind == LANDMARK:
        at.residual[1] = wrap(second - wrap(middle_1 + offset_1))
    return True


@kernel
def predict_by_points(
    mean: Array, p: Array, after: Array, noise: Array, growth: float, transform: Transform, at: Work
) -> None:
    """Move one row's mean and covariance by sigma points, as `amorsim.kernels.filters.ekf.predict` does by slopes."""
    root(p, at.root)
    ahead_x = after[0] - mean[0]
    ahead_y = after[1] - mean[1]
    offset_x = 0.0
    offset_y = 0.0
    for i in range(4):
        for side in range(2):
            reach = transform.reach if side == 0 else -transform.reach
            turn = reach * at.root[2, i]
            c = math.cos(turn)
            s = math.sin(turn)
            # Each point from where the mean comes to: its way is turned by the error of its heading.
            k = 2 * i + side
            at.ends[k, 0] = reach * at.root[0, i] + (c - 1.0) * ahead_x - s * ahead_y
            at.ends[k, 1] = reach * at.root[1, i] + s * ahead_x + (c - 1.0) * ahead_y
            at.ends[k, 2] = turn
            at.ends[k, 3] = reach * at.root[3, i]
            offset_x += transform.each * at.ends[k, 0]
            offset_y += transform.each * at.ends[k, 1]
    for j in range(4):
        for k in range(j, 4):
            a = offset_x if j == 0 else offset_y if j == 1 else 0.0
            b = offset_x if k == 0 else offset_y if k == 1 else 0.0
            total = transform.middle * a * b
            for n in range(8):
                total += transform.each * (at.ends[n, j] - a) * (at.ends[n, k] - b)
            if j < 3 and k < 3:
                total += noise[j, k]
            elif j == 3 and k == 3:
                total += growth
            p[j, k] = total
            p[k, j] = total
    mean[0] = after[0] + offset_x
    mean[1] = after[1] + offset_y
    mean[2] = after[2]
