"""A Kalman filter of a pose and a gyro's bias, over rows: one prediction, and updates one number at a time.

How what is expected depends on the state is found by slopes (the extended filter) or by points (the unscented one,
`amorsim.kernels.filters.points`); all else is the same.

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
from amorsim.kernels.filters.compatible import Search, pair_up
from amorsim.kernels.filters.points import (
    LANDMARK,
    NEAREST,
    PLACE,
    Transform,
    Work,
    expect_by_points,
    predict_by_points,
    work,
)
from amorsim.kernels.kinematics.poses import wrap

__all__ = [
    "BY_IDENTITY",
    "JOINTLY",
    "MATCH",
    "NEAREST_FIRST",
    "NIS",
    "RECORD",
    "USED",
    "Gaussians",
    "Marks",
    "Transform",
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


# Which landmark a sighting is of.
BY_IDENTITY, NEAREST_FIRST, JOINTLY = range(3)


class Marks(NamedTuple):
    """The landmarks that robots know."""

    places: Floats  # (L, 2) [m]
    ids: Ints  # (L,) 0 without one


class Gaussians(NamedTuple):
    """What N rows believe."""

    mean: Floats  # (N, 4): x, y [m], heading [rad], bias of the gyro [rad/s]
    covariance: Floats  # (N, 4, 4)


@kernel
def predict(belief: Gaussians, after: Floats, noise: Floats, growth: Floats, transform: Transform, at: Work) -> None:
    """Move the means to poses `after` (N, 3), and carry and widen the covariances.

    `noise` (N, 3, 3) is the covariance of the motion in the world; `growth` (N, 1) is added to the variance of the
    bias.
    """
    for i in range(after.shape[0]):
        mean = belief.mean[i]
        p = belief.covariance[i]
        if transform.by_points:
            predict_by_points(mean, p, after[i], noise[i], growth[i, 0], transform, at)
            continue
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
    s11 = _along(at.slopes[0], at.spreads[0]) + (r11 + at.extra[0])
    s12 = _along(at.slopes[1], at.spreads[0]) + (r12 + at.extra[1])
    s22 = _along(at.slopes[1], at.spreads[1]) + (r22 + at.extra[2])
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
    r11 += at.extra[0]
    r12 += at.extra[1]
    r22 += at.extra[2]
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
def _see_by_slopes(mean: Floats, mount: Floats, x: float, y: float, distance: float, bearing: float, at: Work) -> bool:
    """Compare a range and a bearing with those of a landmark, into `at`; False where it has no bearing."""
    c = math.cos(mean[2])
    s = math.sin(mean[2])
    aside_x = c * mount[0] - s * mount[1]
    aside_y = s * mount[0] + c * mount[1]
    dx = x - (mean[0] + aside_x)
    dy = y - (mean[1] + aside_y)
    square = dx * dx + dy * dy
    away = math.sqrt(square)
    if not away > NEAREST:
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
    at.extra[:] = 0.0
    return True


@kernel
def _see(
    mean: Floats,
    p: Floats,
    mount: Floats,
    place: Floats,
    distance: float,
    bearing: float,
    transform: Transform,
    at: Work,
) -> bool:
    """Compare a range and a bearing with those of a landmark, by slopes or by points."""
    if transform.by_points:
        return expect_by_points(LANDMARK, mean, p, mount, place[0], place[1], distance, bearing, transform, at)
    return _see_by_slopes(mean, mount, place[0], place[1], distance, bearing, at)


@kernel
def _associate(
    mean: Floats,
    p: Floats,
    reading: Floats,
    mount: Floats,
    marks: Marks,
    noise: Floats,
    gate: float,
    transform: Transform,
    at: Work,
    search: Search,
    record: Floats,
) -> None:
    """Pair sightings with landmarks jointly, into ``search.best``: the landmark of each slot, or -1."""
    slots = search.best.shape[0]
    marks_ = marks.places.shape[0]
    for slot in range(slots):
        distance = reading[3 * slot]
        bearing = reading[3 * slot + 1]
        for k in range(marks_):
            search.fits[slot, k] = False
            if not (math.isfinite(distance) and math.isfinite(bearing)):
                continue
            if not _see(mean, p, mount, marks.places[k], distance, bearing, transform, at):
                continue
            if _squared(p, at, noise[0], 0.0, noise[1], record) <= gate:
                search.fits[slot, k] = True
                search.slopes[slot, k] = at.slopes
                search.residuals[slot, k] = at.residual
                search.noise[slot, k, 0] = noise[0] + at.extra[0]
                search.noise[slot, k, 1] = at.extra[1]
                search.noise[slot, k, 2] = noise[1] + at.extra[2]
    record[:] = np.nan
    pair_up(p, search)


@kernel
def fuse_landmarks(
    belief: Gaussians,
    readings: Floats,
    fresh: Bools,
    mounts: Floats,
    marks: Marks,
    noise: Floats,
    gate: float,
    way: int,
    transform: Transform,
    at: Work,
    search: Search,
    records: Floats,
) -> None:
    """Update by the landmarks of readings (N, 3 m): range, bearing, identity in each slot.

    Parameters
    ----------
    mounts
        Of the sensors on their robots, (N, 3).
    marks
        The landmarks that the robots know.
    noise
        Variances of range and bearing, (N, 2).
    gate
        The largest normalised innovation squared that is used.
    way
        `BY_IDENTITY`: a sighting is of the landmark with its identity; `NEAREST_FIRST`: of the one with the smallest
        normalised innovation squared that no slot before it has taken; `JOINTLY`: as `pair_up` finds for all slots.
    search
        Room for the pairs.
    records
        What was compared, (N, m, 8), nan in empty slots.
    """
    places, ids = marks.places, marks.ids
    for i in range(readings.shape[0]):
        if not fresh[i, 0]:
            continue
        mean = belief.mean[i]
        p = belief.covariance[i]
        search.is_taken[:] = False
        if way == JOINTLY:
            _associate(mean, p, readings[i], mounts[i], marks, noise[i], gate, transform, at, search, records[i, 0])
        for slot in range(records.shape[1]):
            distance = readings[i, 3 * slot]
            bearing = readings[i, 3 * slot + 1]
            identity = readings[i, 3 * slot + 2]
            if not (math.isfinite(distance) and math.isfinite(bearing)):
                continue
            record = records[i, slot]
            best = -1
            least = math.inf
            if way == JOINTLY:
                best = search.best[slot]
            else:
                for k in range(places.shape[0]):
                    if way == BY_IDENTITY:
                        if ids[k] > 0 and float(ids[k]) == identity:
                            best = k
                    elif not search.is_taken[k] and _see(
                        mean, p, mounts[i], places[k], distance, bearing, transform, at
                    ):
                        squared = _squared(p, at, noise[i, 0], 0.0, noise[i, 1], record)
                        if squared < least:
                            best = k
                            least = squared
            if best < 0 or not _see(mean, p, mounts[i], places[best], distance, bearing, transform, at):
                continue
            squared = _squared(p, at, noise[i, 0], 0.0, noise[i, 1], record)
            record[MATCH] = best
            record[USED] = 0.0
            if squared <= gate:
                record[USED] = 1.0
                search.is_taken[best] = True
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
    transform: Transform,
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
