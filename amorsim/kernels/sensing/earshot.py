"""Which rays of a listener's cone may carry a sound to it.

A sound that is heard by way of a surface comes from a point in both cones, that of the listener and that of the
emitter, and by a way neither too short nor too long for the listener. So most rays of most cones need not be cast.
What is left out is left out for certain: bounds are wider than roundings by far.
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from amorsim.kernels.compile import kernel, part
from amorsim.kernels.raycast.rays import direction
from amorsim.kernels.sensing.acoustics import SLACK, Emitters, Facing, Listeners, Surfaces, looks_of

__all__ = ["face", "lay_rays"]

Floats = npt.NDArray[np.float64]


@part
def _is_beyond(nx: float, ny: float, x: float, y: float, emitter: Floats) -> bool:
    """Whether a cone with its tip at (x, y) lies wholly on that side of a line through the origin that (nx, ny) is."""
    if nx * x + ny * y <= SLACK * (abs(x) + abs(y)):
        return False
    ahead = nx * emitter[0] + ny * emitter[1]
    aside = abs(ny * emitter[0] - nx * emitter[1])
    return min(ahead, ahead * emitter[2] - aside * emitter[3]) > SLACK


@part
def _are_apart(edges: Floats, x: float, y: float, emitter: Floats) -> bool:
    """Whether no ray of a listener's cone meets the cone of an emitter (x, y) from it; not where that is in doubt.

    It lies behind the listener, or left of its cone's left edge, or right of the right one; `edges` (3, 2) are normals.
    """
    if emitter[2] < 0.0:
        return False  # more than half a turn
    return (
        _is_beyond(edges[0, 0], edges[0, 1], x, y, emitter)
        or _is_beyond(edges[1, 0], edges[1, 1], x, y, emitter)
        or _is_beyond(edges[2, 0], edges[2, 1], x, y, emitter)
    )


@part
def _set_edges(cos: float, sin: float, cos_half: float, sin_half: float, edges: Floats) -> None:
    """Write the normals of `_are_apart`."""
    edges[0, 0], edges[0, 1] = -cos, -sin
    edges[1, 0], edges[1, 1] = -(sin * cos_half + cos * sin_half), cos * cos_half - sin * sin_half
    edges[2, 0], edges[2, 1] = sin * cos_half - cos * sin_half, -(cos * cos_half + sin * sin_half)


@part
def _crosses(
    dx: float, dy: float, x: float, y: float, shortest: float, longest: float, limit: float, emitter: Floats
) -> bool:
    """Whether a ray of direction (dx, dy) has points in the cone of an emitter (x, y) from its start, so far off.

    The way by the point, along the ray and on to the emitter, is from `shortest` to `longest`; and the point no farther
    along the ray than `limit`. Where that is in doubt, it has.
    """
    across = math.sqrt(x * x + y * y)
    low, high = 0.0, limit
    if emitter[2] >= 0.0:
        doubt = SLACK * (1.0 + across + limit)
        for side in (-1.0, 1.0):
            # An edge of the cone, and how far inside of it the ray's points are: start + speed * r.
            edge_x = emitter[0] * emitter[2] - side * emitter[1] * emitter[3]
            edge_y = emitter[1] * emitter[2] + side * emitter[0] * emitter[3]
            start = side * (edge_x * y - edge_y * x) + doubt
            speed = side * (edge_y * dx - edge_x * dy)
            if start < 0.0 and speed <= 0.0:
                return False
            if speed > 0.0:
                low = max(low, -start / speed)
            elif speed < 0.0:
                high = min(high, -start / speed)
    if low > high:
        return False
    # The way grows with the point's distance r along the ray: r + sqrt(across^2 - 2 r along + r^2) is the way.
    along = dx * x + dy * y
    if shortest > across:
        least = (shortest - across) * (shortest + across) / (2.0 * (shortest - along))
        low = max(low, least * (1.0 - SLACK) - SLACK)
    longest = max(longest, across * (1.0 + 1e-12))
    if longest > along:
        most = (longest - across) * (longest + across) / (2.0 * (longest - along))
        high = min(high, most * (1.0 + SLACK) + SLACK)
    return low <= high


@kernel
def face(listeners: Listeners, emitters: Emitters, fan: Floats, speed: float, together: int, facing: Facing) -> int:
    """Say which rays of listeners may carry a sound to them, and to whom none can come.

    A ray is left out only where no sound by way of its end could count. `fan` (f,) tells a cone's rays by parts of half
    its angle, `speed` is that of sound [m/s]. Returns how many looks of so many rays `together` any row takes at most.
    """
    rows, k = listeners.listens.shape
    count = emitters.poses.shape[1]
    most_looks = 0
    near = np.empty(count, dtype=np.int64)
    spans = np.empty((count, 2))
    edges = np.empty((3, 2))
    cosines, sines, told = np.empty(fan.shape[0]), np.empty(fan.shape[0]), math.nan
    for n in range(rows):
        half, least, most = listeners.cones[n, 0], listeners.cones[n, 1], listeners.cones[n, 2]
        cos_half, sin_half = math.cos(half), math.sin(half)
        if half != told:
            told = half
            for f in range(fan.shape[0]):
                cosines[f], sines[f] = math.cos(half * fan[f]), math.sin(half * fan[f])
        first, last = math.inf, -math.inf
        own = 0
        for j in range(k):
            last = max(last, listeners.listens[n, j])
            facing.itself[n * k + j] = -1
        for i in range(count):
            # Of the emitter that fires first, sound has come farthest.
            first = min(first, emitters.time[n, i])
            axis = facing.emitter_axes[n, i]
            axis[0], axis[1] = math.cos(emitters.poses[n, i, 2]), math.sin(emitters.poses[n, i, 2])
            axis[2], axis[3] = math.cos(emitters.half_angle[n, i]), math.sin(emitters.half_angle[n, i])
            if emitters.own[n, i] and own < k:
                facing.itself[n * k + own] = i
                own += 1
        limit = 2.0 * most + speed * max(last - first, 0.0)
        facing.limit[n, 0] = limit
        looks = 0
        for j in range(k):
            m = n * k + j
            axes = facing.axes[m]
            axes[0], axes[1] = math.cos(listeners.poses[m, 2]), math.sin(listeners.poses[m, 2])
            axes[2] = cos_half
            _set_edges(axes[0], axes[1], cos_half, sin_half, edges)
            candidates = 0
            for i in range(count):
                if not emitters.fired[n, i] or i == facing.itself[m]:
                    continue
                ahead = speed * (emitters.time[n, i] - listeners.listens[n, j])
                slack = SLACK * (1.0 + abs(ahead) + most)
                longest = 2.0 * most - ahead + slack
                if longest < 0.0:
                    continue
                x = emitters.poses[n, i, 0] - listeners.poses[m, 0]
                y = emitters.poses[n, i, 1] - listeners.poses[m, 1]
                # No way is shorter than the straight one.
                if x * x + y * y > longest * longest:
                    continue
                if _are_apart(edges, x, y, facing.emitter_axes[n, i]):
                    continue
                near[candidates] = i
                spans[candidates, 0], spans[candidates, 1] = 2.0 * least - ahead - slack, longest
                candidates += 1
            facing.is_done[m] = candidates == 0
            rays = 0
            for f in range(fan.shape[0] if candidates else 0):
                dx, dy = direction(axes[0], axes[1], cosines[f], sines[f])
                for c in range(candidates):
                    i = near[c]
                    x = emitters.poses[n, i, 0] - listeners.poses[m, 0]
                    y = emitters.poses[n, i, 1] - listeners.poses[m, 1]
                    if _crosses(dx, dy, x, y, spans[c, 0], spans[c, 1], limit, facing.emitter_axes[n, i]):
                        facing.rays[m, rays] = f
                        rays += 1
                        break
            facing.rays[m, rays:] = -1
            looks += looks_of(facing.rays[m], together)
        most_looks = max(most_looks, looks)
    return most_looks


@kernel
def lay_rays(listeners: Listeners, facing: Facing, fan: Floats, surfaces: Surfaces) -> None:
    """Write from where looks are taken, and the bearings of their rays, in order of listener and ray.

    Looks that a row has to spare are those of its first listener, and rays that a look has, along its axis.
    """
    rows, k = listeners.listens.shape
    looks, together = surfaces.bearings.shape[0] // rows, surfaces.bearings.shape[1]
    for n in range(rows):
        half = listeners.cones[n, 0]
        at = n * looks
        surfaces.poses[at : at + looks] = listeners.poses[n * k]
        surfaces.bearings[at : at + looks] = 0.0
        for m in range(n * k, n * k + k):
            for look in range(looks_of(facing.rays[m], together)):
                surfaces.poses[at] = listeners.poses[m]
                for c in range(min(together, fan.shape[0] - look * together)):
                    ray = facing.rays[m, look * together + c]
                    if ray >= 0:
                        surfaces.bearings[at, c] = half * fan[ray]
                at += 1
