"""A Kalman filter of a pose and a gyro's bias, over rows: prediction, and updates by places, headings and turns.

How what is expected depends on the state is found by slopes (the extended filter) or by points (the unscented one,
`amorsim.kernels.filters.unscented`); all else is the same. The state of a row is x, y, heading and the gyro's bias.
Updates by landmarks are in `amorsim.kernels.filters.landmarks`. Equations: S. Thrun, W. Burgard, D. Fox,
"Probabilistic Robotics" (2005), 3.3.
"""

from __future__ import annotations

import math

import numpy as np

from amorsim.array_types import Array, Bools
from amorsim.kernels.compile import kernel, part
from amorsim.kernels.filters.unscented import PLACE, Transform, Work, expect_by_points, predict_by_points
from amorsim.kernels.filters.updates import NIS, USED, Gaussians, bend, squared_of, swing, take, take_pair
from amorsim.kernels.kinematics.poses import wrap

__all__ = ["fuse_headings", "fuse_places", "fuse_turns", "keep_valid", "predict", "report"]


@kernel
def predict(belief: Gaussians, after: Array, noise: Array, growth: Array, transform: Transform, at: Work) -> None:
    """Move the means to poses `after` (N, 3), and propagate and widen the covariances.

    `noise` (N, 3, 3) is the covariance of the motion in the world; `growth` (N, 1) is added to the variance of the
    bias.
    """
    for i in range(after.shape[0]):
        mean = belief.mean[i]
        p = belief.covariance[i]
        if transform.by_points:
            predict_by_points(mean, p, after[i], noise[i], growth[i, 0], transform, at)
            continue
        swing(p, after[i, 0] - mean[0], after[i, 1] - mean[1])
        for j in range(3):
            mean[j] = after[i, j]
            for k in range(3):
                p[j, k] += noise[i, j, k]
        p[3, 3] += growth[i, 0]


@kernel
def report(belief: Gaussians, by_arcs: bool, poses: Array, covariances: Array) -> None:
    """Write the poses (N, 3) and the covariances (N, 3, 3) of x, y and heading.

    After updates `by_arcs` what arcs lead aside is added: a doubtful heading bends the region of places.
    """
    bent = np.zeros(3)
    for i in range(poses.shape[0]):
        p = belief.covariance[i]
        for j in range(3):
            poses[i, j] = belief.mean[i, j]
            for k in range(3):
                covariances[i, j, k] = p[j, k]
        if by_arcs:
            bend(p, bent)
        covariances[i, 0, 0] += bent[0]
        covariances[i, 0, 1] += bent[1]
        covariances[i, 1, 0] += bent[1]
        covariances[i, 1, 1] += bent[2]


@kernel
def keep_valid(belief: Gaussians, before: Gaussians, far: float, stays: bool, failed: Bools) -> None:
    """Restore rows whose numbers have become invalid to what they were `before`, and write into `failed` (N,) which.

    Invalid are numbers that are not finite or beyond `far`, or its square, and negative variances. If it `stays`, a row
    that has failed before counts as invalid.
    """
    for i in range(failed.shape[0]):
        fine = not (stays and failed[i])
        for j in range(4):
            fine &= abs(belief.mean[i, j]) < far  # nan compares as false
            fine &= belief.covariance[i, j, j] >= 0.0
            for k in range(4):
                fine &= abs(belief.covariance[i, j, k]) < far * far
        failed[i] = not fine
        if not fine:
            belief.mean[i] = before.mean[i]
            belief.covariance[i] = before.covariance[i]


@kernel
def fuse_places(
    belief: Gaussians,
    readings: Array,
    fresh: Bools,
    mounts: Array,
    variance: Array,
    correlation: Array,
    gate: float,
    transform: Transform,
    at: Work,
    records: Array,
) -> None:
    """Update by places (N, 2 and more) of mounts (N, 3); both coordinates have this `variance` (N, 1)."""
    for i in range(readings.shape[0]):
        x = readings[i, 0]
        y = readings[i, 1]
        if not (fresh[i, 0] and math.isfinite(x) and math.isfinite(y)):
            continue
        mean = belief.mean[i]
        p = belief.covariance[i]
        if transform.by_points:
            expect_by_points(PLACE, mean, p, mounts[i], 0.0, 0.0, x, y, transform, at)
        else:
            c = math.cos(mean[2])
            s = math.sin(mean[2])
            aside_x = c * mounts[i, 0] - s * mounts[i, 1]
            aside_y = s * mounts[i, 0] + c * mounts[i, 1]
            at.slopes[:] = 0.0
            at.slopes[0, 0] = 1.0
            at.slopes[0, 2] = -aside_y
            at.slopes[1, 1] = 1.0
            at.slopes[1, 2] = aside_x
            at.residual[0] = x - (mean[0] + aside_x)
            at.residual[1] = y - (mean[1] + aside_y)
            at.extra[:] = 0.0
        shared = correlation[i, 0] * variance[i, 0]
        record = records[i, 0]
        squared = squared_of(p, at, variance[i, 0], shared, variance[i, 0], record)
        record[USED] = 0.0
        if squared <= gate:
            record[USED] = 1.0
            take_pair(mean, p, at, variance[i, 0], shared, variance[i, 0], False)


@part
def _fuse_one(
    mean: Array, p: Array, spread: Array, residual: float, variance: float, gate: float, record: Array
) -> None:
    """Update by one number, if the gate lets it pass."""
    record[0] = residual
    record[2] = variance
    record[NIS] = residual * residual / variance
    record[USED] = 0.0
    if record[NIS] <= gate:
        record[USED] = 1.0
        take(mean, p, spread, residual, variance)


@kernel
def fuse_headings(
    belief: Gaussians,
    readings: Array,
    fresh: Bools,
    mounts: Array,
    variance: Array,
    gate: float,
    at: Work,
    records: Array,
) -> None:
    """Update by headings (N, 1) of mounts (N, 3), with this `variance` (N, 1)."""
    for i in range(readings.shape[0]):
        if not (fresh[i, 0] and math.isfinite(readings[i, 0])):
            continue
        mean = belief.mean[i]
        p = belief.covariance[i]
        spread = at.spreads[0]
        for j in range(4):
            spread[j] = p[j, 2]
        residual = wrap(readings[i, 0] - wrap(mean[2] + mounts[i, 2]))
        _fuse_one(mean, p, spread, residual, p[2, 2] + variance[i, 0], gate, records[i, 0])


@kernel
def fuse_turns(
    belief: Gaussians,
    readings: Array,
    fresh: Bools,
    turns: Array,
    noise: Array,
    elapsed: Array,
    variance: Array,
    gate: float,
    at: Work,
    records: Array,
) -> None:
    """Update by mean rates of turn (N, 1) over the step that was just predicted.

    The error of that step's `turns` (N, 1) is in the state already, so it is correlated with the state: by the step's
    `noise` (N, 3, 3), as `predict` took it. `elapsed` (N, 1) is the length of the step; nothing is done where it is 0.
    """
    for i in range(readings.shape[0]):
        dt = elapsed[i, 0]
        if not (fresh[i, 0] and dt > 0.0 and math.isfinite(readings[i, 0])):
            continue
        mean = belief.mean[i]
        p = belief.covariance[i]
        spread = at.spreads[0]
        for j in range(3):
            spread[j] = p[j, 3] + noise[i, j, 2] / dt
        spread[3] = p[3, 3]
        residual = readings[i, 0] - (turns[i, 0] / dt + mean[3])
        expected = p[3, 3] + noise[i, 2, 2] / dt / dt + variance[i, 0]
        _fuse_one(mean, p, spread, residual, expected, gate, records[i, 0])
