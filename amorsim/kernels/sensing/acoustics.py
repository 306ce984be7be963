"""Sound that one transducer sends and another hears: straight across, or by way of a surface."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from amorsim.kernels.compile import kernel

__all__ = ["DIRECT", "axes", "first_sounds", "surface_points"]

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]
Bools = npt.NDArray[np.bool_]

DIRECT = 0
"""Which of the ways from an emitter is the straight one; the others go by way of a ray's end, counted from 1."""


@kernel
def surface_points(origins: Floats, half_angle: Floats, fan: Floats, ranges: Floats, out: Floats) -> None:
    """Where rays of cones end, into `out` (M, f, 2) [m]; inf where they do not.

    `origins` (M, 3) are world poses; the rays of each look at `fan` (f,) times its `half_angle` (M,) [rad] and go
    `ranges` (M, f) [m].
    """
    for m in range(origins.shape[0]):
        for f in range(fan.shape[0]):
            if math.isfinite(ranges[m, f]):
                angle = origins[m, 2] + half_angle[m] * fan[f]
                out[m, f, 0] = origins[m, 0] + ranges[m, f] * math.cos(angle)
                out[m, f, 1] = origins[m, 1] + ranges[m, f] * math.sin(angle)
            else:
                out[m, f, 0] = out[m, f, 1] = math.inf


@kernel
def axes(poses: Floats, half_angle: Floats, out: Floats) -> None:
    """Of each of M cones the cosine and sine of where it looks, and the cosine of its half angle, into `out` (M, 3)."""
    for m in range(poses.shape[0]):
        out[m, 0] = math.cos(poses[m, 2])
        out[m, 1] = math.sin(poses[m, 2])
        out[m, 2] = math.cos(half_angle[m])


@kernel
def _is_within(dx: float, dy: float, way: float, cos: float, sin: float, edge: float) -> bool:
    """Whether what lies (dx, dy) from a cone's tip, `way` off, is in the cone; the tip is."""
    return dx * cos + dy * sin >= way * edge


@kernel
def first_sounds(
    receivers: Floats,
    receiver_axes: Floats,
    listens: Floats,
    itself: Ints,
    points: Floats,
    ranges: Floats,
    surface: Ints,
    emitters: Floats,
    emitter_axes: Floats,
    carrier: Ints,
    fires: Floats,
    fired: Bools,
    speed: float,
    least: Floats,
    most: Floats,
    after: Floats,
    after_which: Ints,
    heard: Floats,
    which: Ints,
    path: Floats,
) -> None:
    """Find for each receiver the sounds that come first after a given one, in order.

    A sound reads half the way that it could have gone since the receiver began to listen. It goes straight from
    emitter to receiver where each is in the other's cone, or by way of one of the receiver's `points` that lies in the
    emitter's cone too, and not on the emitter's own robot. Whether anything is in between is not looked at here.

    Parameters
    ----------
    receivers, receiver_axes, listens, itself
        World poses `(M, 3)`, k for each of N rows in turn, what `axes` says of their cones `(M, 3)`, when each begins
        to listen `(M,)` [s], and which emitter it is itself `(M,)`, -1 for none.
    points, ranges, surface
        `(M, f, 2)` [m] where the rays in its cone end, `(M, f)` [m] how far off, and on whose surface: the body that a
        robot's parts belong to, -1 for a wall or nothing.
    emitters, emitter_axes, carrier, fires, fired
        Of each row: world poses and axes `(N, e, 3)`, the body that carries each, when each fires [s], and whether
        `(N, e)`.
    speed
        Of sound [m/s].
    least, most
        What a receiver can read `(M,)` [m], both included.
    after, after_which
        `(M,)` the reading [m] and number of the last sound that is known; -inf and -1 for none. The number is that of
        the emitter times (f + 1), plus that of the way.
    heard, which
        `(M, b)` the readings and numbers that come next, in order; inf and -1 where there are no more.
    path
        `(M, b, 4)`: where the last straight part of the way ended, and the emitter: x, y, x, y [m].
    """
    rows, count = emitters.shape[0], emitters.shape[1]
    each = receivers.shape[0] // rows
    ways, batch = points.shape[1] + 1, heard.shape[1]
    for m in range(receivers.shape[0]):
        n = m // each
        x, y = receivers[m, 0], receivers[m, 1]
        heard[m, :] = math.inf
        which[m, :] = -1
        for i in range(count):
            if not fired[n, i] or i == itself[m]:
                continue
            ex, ey = emitters[n, i, 0], emitters[n, i, 1]
            cos, sin, edge = emitter_axes[n, i, 0], emitter_axes[n, i, 1], emitter_axes[n, i, 2]
            across = math.sqrt((ex - x) ** 2 + (ey - y) ** 2)
            ahead = speed * (fires[n, i] - listens[m])
            # No way is shorter than the straight one.
            if 0.5 * (across + ahead) > min(heard[m, batch - 1], most[m]):
                continue
            for f in range(ways):
                if f == DIRECT:
                    if not _is_within(
                        ex - x, ey - y, across, receiver_axes[m, 0], receiver_axes[m, 1], receiver_axes[m, 2]
                    ):
                        continue
                    if not _is_within(x - ex, y - ey, across, cos, sin, edge):
                        continue
                    way = across
                else:
                    if not math.isfinite(ranges[m, f - 1]) or surface[m, f - 1] == carrier[n, i]:
                        continue
                    dx, dy = points[m, f - 1, 0] - ex, points[m, f - 1, 1] - ey
                    last = math.sqrt(dx * dx + dy * dy)
                    if not _is_within(dx, dy, last, cos, sin, edge):
                        continue
                    way = ranges[m, f - 1] + last
                reading = 0.5 * (way + ahead)
                number = i * ways + f
                if not least[m] <= reading <= most[m]:
                    continue
                if reading < after[m] or (reading == after[m] and number <= after_which[m]):
                    continue
                # Those of equal readings are met in order of their numbers, so that the new one comes behind them.
                b = batch
                while b > 0 and reading < heard[m, b - 1]:
                    b -= 1
                if b == batch:
                    continue
                for c in range(batch - 1, b, -1):
                    heard[m, c], which[m, c] = heard[m, c - 1], which[m, c - 1]
                heard[m, b], which[m, b] = reading, number
        for b in range(batch):
            number = which[m, b]
            path[m, b, 0] = path[m, b, 2] = x
            path[m, b, 1] = path[m, b, 3] = y
            if number >= 0:
                i, f = number // ways, number % ways
                if f != DIRECT:
                    path[m, b, 0], path[m, b, 1] = points[m, f - 1, 0], points[m, f - 1, 1]
                path[m, b, 2], path[m, b, 3] = emitters[n, i, 0], emitters[n, i, 1]
