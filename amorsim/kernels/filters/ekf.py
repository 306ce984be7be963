"""An extended Kalman filter of a pose and a gyro's bias, over rows: one prediction, and updates one number at a time.

The state of a row is x, y, heading and the gyro's bias. An update of two numbers takes them one after the other, which
is exact once their noise is independent: a correlated pair is decorrelated first. So no matrix is inverted, and a row
depends on nothing but itself. Equations: S. Thrun, W. Burgard, D. Fox, "Probabilistic Robotics" (2005), 3.3 and 7.4;
sequential updates: Y. Bar-Shalom, X. R. Li, T. Kirubarajan, "Estimation with Applications to Tracking and Navigation"
(2001), 5.2 and 8.3.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from amorsim.kernels.compile import kernel, part
from amorsim.kernels.kinematics.poses import wrap

__all__ = [
    "MATCH",
    "NIS",
    "RECORD",
    "USED",
    "Gaussians",
    "Work",
    "fuse_headings",
    "fuse_landmarks",
    "fuse_places",
    "fuse_turns",
    "predict",
    "work",
]

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]
Bools = npt.NDArray[np.bool_]

# What is kept of an update: two innovations, their covariance (11, 12, 22), and these.
NIS = 5  # the innovation's square in units of its covariance
USED = 6  # 1 if it was used, 0 if the gate refused it
MATCH = 7  # the landmark, by its place among those that the robot knows
RECORD = 8

_NEAREST = 1e-9  # [m] a landmark has no bearing from its own place


class Gaussians(NamedTuple):
    """What N rows believe."""

    mean: Floats  # (N, 4): x, y [m], heading [rad], bias of the gyro [rad/s]
    covariance: Floats  # (N, 4, 4)


class Work(NamedTuple):
    """Room for one update of two numbers."""

    slopes: Floats  # (2, 4) of the expected numbers by the state
    spreads: Floats  # (2, 4) covariance of the state with them
    residual: Floats  # (2,)


def work() -> Work:
    """Room for the updates of one call."""
    return Work(np.empty((2, 4)), np.empty((2, 4)), np.empty(2))


@kernel
def predict(belief: Gaussians, after: Floats, noise: Floats, growth: Floats) -> None:
    """Move the means to poses `after` (N, 3), and carry and widen the covariances.

    `noise` (N, 3, 3) is the covariance of the motion in the world; `growth` (N, 1) is added to the variance of the
    bias.
    """
    for i in range(after.shape[0]):
        mean = belief.mean[i]
        p = belief.covariance[i]
        # An error e of the heading before moves the end by e * (swing_x, swing_y).
        swing_x = mean[1] - after[i, 1]
        swing_y = after[i, 0] - mean[0]
        xh = p[0, 2]
        yh = p[1, 2]
        hh = p[2, 2]
        hb = p[2, 3]
        p[0, 0] += swing_x * (2.0 * xh + swing_x * hh) + noise[i, 0, 0]
        p[0, 1] += swing_y * xh + swing_x * yh + swing_x * swing_y * hh + noise[i, 0, 1]
        p[1, 1] += swing_y * (2.0 * yh + swing_y * hh) + noise[i, 1, 1]
        p[0, 2] += swing_x * hh + noise[i, 0, 2]
        p[1, 2] += swing_y * hh + noise[i, 1, 2]
        p[2, 2] += noise[i, 2, 2]
        p[0, 3] += swing_x * hb
        p[1, 3] += swing_y * hb
        p[3, 3] += growth[i, 0]
        for j in range(4):
            for k in range(j):
                p[j, k] = p[k, j]
        for j in range(3):
            mean[j] = after[i, j]


@part
def _spread(p: Floats, slope: Floats, out: Floats) -> None:
    """The covariance of the state with a number of this `slope`, into `out` (4,)."""
    for j in range(4):
        out[j] = p[j, 0] * slope[0] + p[j, 1] * slope[1] + p[j, 2] * slope[2] + p[j, 3] * slope[3]


@part
def _along(a: Floats, b: Floats) -> float:
    return float(a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3])


@part
def _take(mean: Floats, p: Floats, spread: Floats, residual: float, variance: float) -> None:
    """Update by one number, whose residual has this `variance` and this covariance with the state (`spread`)."""
    for j in range(4):
        gain = spread[j] / variance
        mean[j] += gain * residual
        for k in range(j, 4):
            p[j, k] -= gain * spread[k]
            p[k, j] = p[j, k]
    mean[2] = wrap(mean[2])


@part
def _squared(p: Floats, at: Work, r11: float, r12: float, r22: float, record: Floats) -> float:
    """Compare two numbers with what is expected (`at`), into `record`; returns the normalised innovation squared."""
    _spread(p, at.slopes[0], at.spreads[0])
    _spread(p, at.slopes[1], at.spreads[1])
    s11 = _along(at.slopes[0], at.spreads[0]) + r11
    s12 = _along(at.slopes[1], at.spreads[0]) + r12
    s22 = _along(at.slopes[1], at.spreads[1]) + r22
    first = at.residual[0]
    rest = at.residual[1] - s12 / s11 * first
    squared = first * first / s11 + rest * rest / (s22 - s12 / s11 * s12)
    record[0] = first
    record[1] = at.residual[1]
    record[2] = s11
    record[3] = s12
    record[4] = s22
    record[NIS] = squared
    return float(squared)


@part
def _take_pair(mean: Floats, p: Floats, at: Work, r11: float, r12: float, r22: float) -> None:
    """Update by two numbers, one after the other, both linearised where the mean was before."""
    # The second less its part that the first tells: its noise is independent of the first one's.
    share = r12 / r11
    residual = at.residual[1] - share * at.residual[0]
    for j in range(4):
        at.slopes[1, j] -= share * at.slopes[0, j]
    variance = _along(at.slopes[0], at.spreads[0]) + r11
    residual -= _along(at.slopes[1], at.spreads[0]) * at.residual[0] / variance
    _take(mean, p, at.spreads[0], at.residual[0], variance)
    _spread(p, at.slopes[1], at.spreads[1])
    _take(mean, p, at.spreads[1], residual, _along(at.slopes[1], at.spreads[1]) + r22 - share * r12)


@part
def _see(mean: Floats, mount: Floats, x: float, y: float, distance: float, bearing: float, at: Work) -> bool:
    """Compare a range and a bearing with those of a landmark, into `at`; False where it has no bearing."""
    c = math.cos(mean[2])
    s = math.sin(mean[2])
    aside_x = c * mount[0] - s * mount[1]
    aside_y = s * mount[0] + c * mount[1]
    dx = x - (mean[0] + aside_x)
    dy = y - (mean[1] + aside_y)
    square = dx * dx + dy * dy
    away = math.sqrt(square)
    if not away > _NEAREST:
        return False
    at.slopes[0, 0] = -dx / away
    at.slopes[0, 1] = -dy / away
    at.slopes[0, 2] = (dx * aside_y - dy * aside_x) / away
    at.slopes[0, 3] = 0.0
    at.slopes[1, 0] = dy / square
    at.slopes[1, 1] = -dx / square
    at.slopes[1, 2] = -(dx * aside_x + dy * aside_y) / square - 1.0
    at.slopes[1, 3] = 0.0
    at.residual[0] = distance - away
    at.residual[1] = wrap(bearing - wrap(math.atan2(dy, dx) - mean[2] - mount[2]))
    return True


@kernel
def fuse_landmarks(
    belief: Gaussians,
    readings: Floats,
    fresh: Bools,
    mounts: Floats,
    places: Floats,
    ids: Ints,
    noise: Floats,
    gate: float,
    by_identity: bool,
    at: Work,
    is_taken: Bools,
    records: Floats,
) -> None:
    """Update by the landmarks of readings (N, 3 m): range, bearing, identity in each slot.

    Parameters
    ----------
    mounts
        Of the sensors on their robots, (N, 3).
    places, ids
        Of the landmarks that the robots know, (L, 2) and (L,).
    noise
        Variances of range and bearing, (N, 2).
    gate
        The largest normalised innovation squared that is used.
    by_identity
        Whether a sighting is of the landmark with its identity; else of the one with the smallest normalised
        innovation squared that no slot before it has taken.
    is_taken
        Room for L flags.
    records
        What was compared, (N, m, 8), nan in empty slots.
    """
    for i in range(readings.shape[0]):
        if not fresh[i, 0]:
            continue
        mean = belief.mean[i]
        p = belief.covariance[i]
        is_taken[:] = False
        for slot in range(records.shape[1]):
            distance = readings[i, 3 * slot]
            bearing = readings[i, 3 * slot + 1]
            identity = readings[i, 3 * slot + 2]
            if not (math.isfinite(distance) and math.isfinite(bearing)):
                continue
            record = records[i, slot]
            best = -1
            least = math.inf
            for k in range(places.shape[0]):
                if by_identity:
                    if ids[k] > 0 and float(ids[k]) == identity:
                        best = k
                elif not is_taken[k] and _see(mean, mounts[i], places[k, 0], places[k, 1], distance, bearing, at):
                    squared = _squared(p, at, noise[i, 0], 0.0, noise[i, 1], record)
                    if squared < least:
                        best = k
                        least = squared
            if best < 0 or not _see(mean, mounts[i], places[best, 0], places[best, 1], distance, bearing, at):
                continue
            squared = _squared(p, at, noise[i, 0], 0.0, noise[i, 1], record)
            record[MATCH] = best
            record[USED] = 0.0
            if squared <= gate:
                record[USED] = 1.0
                is_taken[best] = True
                _take_pair(mean, p, at, noise[i, 0], 0.0, noise[i, 1])


@kernel
def fuse_places(
    belief: Gaussians,
    readings: Floats,
    fresh: Bools,
    mounts: Floats,
    variance: Floats,
    correlation: Floats,
    gate: float,
    at: Work,
    records: Floats,
) -> None:
    """Update by places (N, 2 and more) of mounts (N, 3); both coordinates have this `variance` (N, 1)."""
    for i in range(readings.shape[0]):
        x = readings[i, 0]
        y = readings[i, 1]
        if not (fresh[i, 0] and math.isfinite(x) and math.isfinite(y)):
            continue
        mean = belief.mean[i]
        p = belief.covariance[i]
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
        shared = correlation[i, 0] * variance[i, 0]
        record = records[i, 0]
        squared = _squared(p, at, variance[i, 0], shared, variance[i, 0], record)
        record[USED] = 0.0
        if squared <= gate:
            record[USED] = 1.0
            _take_pair(mean, p, at, variance[i, 0], shared, variance[i, 0])


@part
def _fuse_one(
    mean: Floats, p: Floats, spread: Floats, residual: float, variance: float, gate: float, record: Floats
) -> None:
    """Update by one number, if the gate lets it pass."""
    record[0] = residual
    record[2] = variance
    record[NIS] = residual * residual / variance
    record[USED] = 0.0
    if record[NIS] <= gate:
        record[USED] = 1.0
        _take(mean, p, spread, residual, variance)


@kernel
def fuse_headings(
    belief: Gaussians,
    readings: Floats,
    fresh: Bools,
    mounts: Floats,
    variance: Floats,
    gate: float,
    at: Work,
    records: Floats,
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
    readings: Floats,
    fresh: Bools,
    turns: Floats,
    noise: Floats,
    elapsed: Floats,
    variance: Floats,
    gate: float,
    at: Work,
    records: Floats,
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
