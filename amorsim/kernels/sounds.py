"""Sound that one transducer sends and another hears: straight across, or by way of a surface."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from amorsim.kernels.compile import kernel

__all__ = ["DIRECT", "first_sound", "surface_points"]

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
def _is_within(x: float, y: float, heading: float, half_angle: float, to_x: float, to_y: float) -> bool:
    """Whether a point lies in the cone about a pose; its tip does."""
    dx, dy = to_x - x, to_y - y
    way = math.sqrt(dx * dx + dy * dy)
    return dx * math.cos(heading) + dy * math.sin(heading) >= way * math.cos(half_angle)


@kernel
def first_sound(
    receivers: Floats,
    half_angle: Floats,
    listens: Floats,
    itself: Ints,
    points: Floats,
    ranges: Floats,
    emitters: Floats,
    emitter_half: Floats,
    fires: Floats,
    fired: Bools,
    speed: float,
    least: Floats,
    most: Floats,
    heard: Floats,
    which: Ints,
    path: Floats,
) -> bool:
    """Find for each receiver the sound that comes first of those that come after the one in `heard` and `which`.

    A sound reads half the way that it could have gone since the receiver began to listen. It goes straight from
    emitter to receiver where each is in the other's cone, or by way of one of the receiver's `points` that lies in the
    emitter's cone too. Whether anything is in between is not looked at here.

    Parameters
    ----------
    receivers, half_angle, listens, itself
        World poses `(M, 3)`, k for each of N rows in turn, half angles of their cones `(M,)` [rad], when each begins to
        listen `(M,)` [s], and which emitter it is itself `(M,)`, -1 for none.
    points, ranges
        `(M, f, 2)` [m] where the rays in its cone end, and `(M, f)` [m] how far off.
    emitters, emitter_half, fires, fired
        Of each row: world poses `(N, e, 3)`, half angles, when each fires [s], and whether `(N, e)`.
    speed
        Of sound [m/s].
    least, most
        What a receiver can read `(M,)` [m], both included.
    heard, which
        `(M,)` [m] the reading, and emitter times (f + 1) plus way: found before, -inf and -1 for none yet; replaced by
        what comes next, inf and -1 for nothing.
    path
        `(M, 4)`: from where the sound last went in a straight line that began at the emitter: x, y, and to the
        emitter's x, y [m]; of a receiver that hears nothing, undefined.

    Returns
    -------
    Whether any receiver hears anything.
    """
    rows, count = emitters.shape[0], emitters.shape[1]
    each = receivers.shape[0] // rows
    ways = points.shape[1] + 1
    anything = False
    for m in range(receivers.shape[0]):
        n = m // each
        x, y = receivers[m, 0], receivers[m, 1]
        best, best_which = math.inf, -1
        for i in range(count):
            if not fired[n, i] or i == itself[m]:
                continue
            ex, ey = emitters[n, i, 0], emitters[n, i, 1]
            across = math.sqrt((ex - x) ** 2 + (ey - y) ** 2)
            ahead = speed * (fires[n, i] - listens[m])
            # No way is shorter than the straight one.
            if 0.5 * (across + ahead) > min(best, most[m]):
                continue
            for f in range(ways):
                if f == DIRECT:
                    if not _is_within(x, y, receivers[m, 2], half_angle[m], ex, ey):
                        continue
                    if not _is_within(ex, ey, emitters[n, i, 2], emitter_half[n, i], x, y):
                        continue
                    way = across
                else:
                    if not math.isfinite(ranges[m, f - 1]):
                        continue
                    px, py = points[m, f - 1, 0], points[m, f - 1, 1]
                    way = ranges[m, f - 1] + math.sqrt((ex - px) ** 2 + (ey - py) ** 2)
                reading = 0.5 * (way + ahead)
                if not least[m] <= reading <= most[m] or reading > best:
                    continue
                number = i * ways + f
                if reading < heard[m] or (reading == heard[m] and number <= which[m]):
                    continue
                if reading == best and number > best_which:
                    continue
                if f != DIRECT and not _is_within(ex, ey, emitters[n, i, 2], emitter_half[n, i], px, py):
                    continue
                best, best_which = reading, number
        heard[m], which[m] = best, best_which
        if best_which < 0:
            continue
        anything = True
        i, f = best_which // ways, best_which % ways
        path[m, 0], path[m, 1] = x, y
        if f != DIRECT:
            path[m, 0], path[m, 1] = points[m, f - 1, 0], points[m, f - 1, 1]
        path[m, 2], path[m, 3] = emitters[n, i, 0], emitters[n, i, 1]
    return anything
