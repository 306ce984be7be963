"""Shared by sensors and their noise: the poses of a ring's elements, and values with noise on them."""

from __future__ import annotations

import math
from typing import Any

from amorsim.array_types import Array, Ints
from amorsim.kernels.compile import kernel
from amorsim.kernels.kinematics.poses import wrap

__all__ = [
    "add_responses",
    "blank_near",
    "count_turns",
    "place_ring",
    "range_and_bearing",
    "response",
    "scatter",
    "shares_of_range",
    "specific_force",
    "wrap_headings",
]

# A component's parameter over rows, (N, 1) float64; declared as the number that it is for one row.
Column = Any

_TURN = 2.0 * math.pi


@kernel
def place_ring(poses: Array, x: Any, y: Any, heading: Any, out: Array) -> None:
    """World poses of the elements of rings, into `out` (N * k, 3): those of row 0 first.

    `poses` (N, 3) are the mounts in the world; `x`, `y` [m] and `heading` [rad] (N, k) the elements on their
    mount.
    """
    k = x.shape[1]
    for i in range(poses.shape[0]):
        c = math.cos(poses[i, 2])
        s = math.sin(poses[i, 2])
        for j in range(k):
            out[i * k + j, 0] = poses[i, 0] + (c * x[i, j] - s * y[i, j])
            out[i * k + j, 1] = poses[i, 1] + (s * x[i, j] + c * y[i, j])
            out[i * k + j, 2] = wrap(poses[i, 2] + heading[i, j])


@kernel
def count_turns(joints: Array, counts: Column, out: Array) -> None:
    """Write the counts of encoders on joints (N, j) [rad] into `out`; `counts` of a full turn, (N, 1) or (N, j)."""
    for i in range(out.shape[0]):
        for j in range(out.shape[1]):
            out[i, j] = joints[i, j] / _TURN * counts[i, j if counts.shape[1] > 1 else 0]


@kernel
def response(distance: float, distances: Array, values: Array) -> float:
    """Response of a table (m,) to a distance: linear between points, the first value nearer, 0 farther away."""
    if distance <= distances[0]:
        return float(values[0])
    for i in range(distances.shape[0] - 1):
        if distances[i] < distance <= distances[i + 1]:
            # At either end the result is the table's own number, to the bit.
            part = (distances[i + 1] - distance) / (distances[i + 1] - distances[i])
            return float(values[i + 1] + (values[i] - values[i + 1]) * part)
    return 0.0


@kernel
def add_responses(
    ranges: Array,
    distances: Column,
    values: Column,
    side_distances: Column,
    side_values: Column,
    most: Column,
    out: Array,
) -> None:
    """Add up the light that returns to elements along three rays, `ranges` (N * k, 3) [m], into `out` (N, k).

    The middle ray has a table (N, m), those beside it another; the sum is limited to `most` (N, 1).
    """
    k = out.shape[1]
    for i in range(out.shape[0]):
        for j in range(k):
            rays = ranges[i * k + j]
            total = response(rays[1], distances[i], values[i])
            total += response(rays[0], side_distances[i], side_values[i])
            total += response(rays[2], side_distances[i], side_values[i])
            out[i, j] = min(total, most[i, 0])


@kernel
def wrap_headings(poses: Array, out: Array) -> None:
    """Headings of `poses` (N, 3) in [-pi, pi], into `out` (N, 1) [rad]."""
    for i in range(poses.shape[0]):
        out[i, 0] = wrap(poses[i, 2])


@kernel
def blank_near(ranges: Array, range_min: Column, out: Array) -> None:
    """Write `ranges` (N, k) [m] into `out`, -inf, "too close to measure", for those below `range_min` (N, 1)."""
    for i in range(ranges.shape[0]):
        for j in range(ranges.shape[1]):
            out[i, j] = -math.inf if ranges[i, j] < range_min[i, 0] else ranges[i, j]


@kernel
def shares_of_range(ranges: Array, range_max: Column, first: int, out: Array) -> None:
    """Write `ranges` (N, k) [m] as shares of `range_max`, (N, 1) or (1, 1), into the columns of `out` from `first` on.

    They are from 0 to 1; 1 also where there is no return, or nan.
    """
    for i in range(ranges.shape[0]):
        most = range_max[i if range_max.shape[0] > 1 else 0, 0]
        for j in range(ranges.shape[1]):
            share = ranges[i, j] / most
            share = share if share < 1.0 else 1.0
            out[i, first + j] = share if share > 0.0 else 0.0


@kernel
def range_and_bearing(poses: Array, places: Array, farthest: float, out: Array) -> None:
    """Write how far `places` (N, 2) are from `poses` (N, 3), and cosine and sine of the bearing, into `out` (N, 3+).

    A distance is `farthest` [m] at most.
    """
    for i in range(poses.shape[0]):
        east = places[i, 0] - poses[i, 0]
        north = places[i, 1] - poses[i, 1]
        bearing = math.atan2(north, east) - poses[i, 2]
        out[i, 0] = min(math.hypot(east, north), farthest)
        out[i, 1] = math.cos(bearing)
        out[i, 2] = math.sin(bearing)


@kernel
def scatter(values: Array, amounts: Array, std: Column, proportional: Column, noise: Array) -> None:
    """Turn standard normal `noise` (N, k), in place, into `values` (N, k) with noise on them.

    The standard deviation is `std` (N, 1) and `proportional` (N, 1) times the size of `amounts` (N, k)
    together. A value that is not finite (no return), or has no deviation, keeps its bits.
    """
    for i in range(values.shape[0]):
        for j in range(values.shape[1]):
            value = values[i, j]
            if math.isfinite(value):
                deviation = std[i, 0] + proportional[i, 0] * abs(amounts[i, j])
                noise[i, j] = value + deviation * noise[i, j] if deviation > 0.0 else value
            else:
                noise[i, j] = value


@kernel
def specific_force(
    twists: Array,
    mounts: Array,
    before: Array,
    tick_before: Ints,
    tick: Ints,
    dt: float,
    velocity: Array,
    out: Array,
) -> None:
    """Acceleration of points on bodies, in the points' own frames, and rates of turn, into `out` (N, 3).

    Parameters
    ----------
    twists
        Mean velocities over the last step in the bodies' frames, (N, 3) [m/s, m/s, rad/s].
    mounts
        The points and where they look, in the bodies' frames, (N, 3).
    before, tick_before
        Velocities of the points in the bodies' frames at an earlier tick (N, 2) [m/s], int64 (N, 1), -1 for none.
    tick, dt
        The present tick, int64 (N, 1), and the step [s].
    velocity
        Gets the velocities of the points now, in the bodies' frames, (N, 2) [m/s].
    """
    for i in range(twists.shape[0]):
        turn = twists[i, 2]
        ahead = twists[i, 0] - turn * mounts[i, 1]
        left = twists[i, 1] + turn * mounts[i, 0]
        velocity[i, 0] = ahead
        velocity[i, 1] = left
        x = -turn * left
        y = turn * ahead
        passed = (tick[i, 0] - tick_before[i, 0]) * dt
        if tick_before[i, 0] >= 0 and passed > 0.0:
            x += (ahead - before[i, 0]) / passed
            y += (left - before[i, 1]) / passed
        c = math.cos(mounts[i, 2])
        s = math.sin(mounts[i, 2])
        out[i, 0] = c * x + s * y
        out[i, 1] = c * y - s * x
        out[i, 2] = turn
