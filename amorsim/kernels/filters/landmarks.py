"""Updates of a Kalman filter by landmarks: the landmark of a sighting, and its expected measurement.

Equations: S. Thrun, W. Burgard, D. Fox, "Probabilistic Robotics" (2005), 7.4.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from amorsim.array_types import Array, Bools, Ints
from amorsim.kernels.compile import kernel, part
from amorsim.kernels.filters.compatible import Search, pair_up
from amorsim.kernels.filters.unscented import LANDMARK, NEAREST, Transform, Work, expect_by_points
from amorsim.kernels.filters.updates import MATCH, USED, Gaussians, squared_of, take_pair
from amorsim.kernels.kinematics.poses import wrap

__all__ = ["BY_IDENTITY", "JOINTLY", "NEAREST_FIRST", "Marks", "fuse_landmarks"]


# Which landmark a sighting is of.
BY_IDENTITY, NEAREST_FIRST, JOINTLY = range(3)


class Marks(NamedTuple):
    """The landmarks that robots know."""

    places: Array  # (L, 2) [m]
    ids: Ints  # (L,) 0 without one


@part
def _see_by_slopes(mean: Array, mount: Array, x: float, y: float, distance: float, bearing: float, at: Work) -> bool:
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
    mean: Array,
    p: Array,
    mount: Array,
    place: Array,
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
    mean: Array,
    p: Array,
    reading: Array,
    mount: Array,
    marks: Marks,
    noise: Array,
    gate: float,
    transform: Transform,
    at: Work,
    search: Search,
    record: Array,
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
            if squared_of(p, at, noise[0], 0.0, noise[1], record) <= gate:
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
    readings: Array,
    fresh: Bools,
    mounts: Array,
    marks: Marks,
    noise: Array,
    gate: float,
    way: int,
    transform: Transform,
    at: Work,
    search: Search,
    records: Array,
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
                        squared = squared_of(p, at, noise[i, 0], 0.0, noise[i, 1], record)
                        if squared < least:
                            best = k
                            least = squared
            if best < 0 or not _see(mean, p, mounts[i], places[best], distance, bearing, transform, at):
                continue
            squared = squared_of(p, at, noise[i, 0], 0.0, noise[i, 1], record)
            record[MATCH] = best
            record[USED] = 0.0
            if squared <= gate:
                record[USED] = 1.0
                search.is_taken[best] = True
                take_pair(mean, p, at, noise[i, 0], 0.0, noise[i, 1], True)
