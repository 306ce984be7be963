"""The listeners whose cones a sound may reach.

A sound that is heard by way of a surface comes from a point in both cones, that of the listener and that of the
emitter, and by a way neither too short nor too long for the listener. So the rays of many cones need not be cast.
What is left out is left out for certain: bounds are wider than roundings by far.
"""

from __future__ import annotations

import math

import numpy as np

from amorsim.array_types import Array
from amorsim.kernels.compile import kernel, part
from amorsim.kernels.raycast.rays import direction
from amorsim.kernels.sensing.acoustics import SLACK, Emitters, Facing, Listeners

__all__ = ["face"]


# What is held of an emitter that a listener may hear: where it is from there, how far off [m], the ways by which it can
# be heard [m], and of both edges of its cone the direction, x and y, and how far the listener is inside of it.
_X, _Y, _ACROSS, _SHORTEST, _LONGEST, _EDGES = range(6)
_COLUMNS = _EDGES + 6


_FEW = 2  # emitters up to which the distances that count are found for each ray of a cone


@part
def _is_beyond(nx: float, ny: float, x: float, y: float, emitter: Array) -> bool:
    """Whether a cone with its tip at (x, y) is wholly on the side (nx, ny) of a line through the origin."""
    if nx * x + ny * y <= SLACK * (abs(x) + abs(y)):
        return False
    ahead = nx * emitter[0] + ny * emitter[1]
    aside = abs(ny * emitter[0] - nx * emitter[1])
    return bool(min(ahead, ahead * emitter[2] - aside * emitter[3]) > SLACK)


@part
def _are_apart(edges: Array, x: float, y: float, emitter: Array) -> bool:
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
def _set_edges(cos: float, sin: float, cos_half: float, sin_half: float, edges: Array) -> None:
    """Write the normals of `_are_apart`."""
    edges[0, 0], edges[0, 1] = -cos, -sin
    edges[1, 0], edges[1, 1] = -(sin * cos_half + cos * sin_half), cos * cos_half - sin * sin_half
    edges[2, 0], edges[2, 1] = sin * cos_half - cos * sin_half, -(cos * cos_half + sin * sin_half)


@part
def _set_candidate(x: float, y: float, shortest: float, longest: float, limit: float, axis: Array, to: Array) -> None:
    """Write the input of `_meets_at` for an emitter (x, y) from a listener, with a path from `shortest` to `longest`.

    `limit` [m] is how far the listener's rays go, `axis` of `Facing.emitter_axes`.
    """
    across = math.sqrt(x * x + y * y)
    doubt = SLACK * (1.0 + across + limit)
    for side in range(2):
        # An edge of the cone, right and left, turned so that its inside is on the left; and how far inside we are.
        sign = 2.0 * side - 1.0
        edge_x = sign * (axis[0] * axis[2] - sign * axis[1] * axis[3])
        edge_y = sign * (axis[1] * axis[2] + sign * axis[0] * axis[3])
        to[_EDGES + 3 * side] = edge_x
        to[_EDGES + 3 * side + 1] = edge_y
        # All is within a cone of more than half a turn, as far as is looked at here.
        to[_EDGES + 3 * side + 2] = edge_x * y - edge_y * x + doubt if axis[2] >= 0.0 else math.inf
    to[_X], to[_Y], to[_ACROSS] = x, y, across
    to[_SHORTEST], to[_LONGEST] = shortest, max(longest, across * (1.0 + 1e-12))


@part
def _meets_at(dx: float, dy: float, limit: float, of: Array) -> float:
    """How far along a listener's ray of direction (dx, dy) its points begin to be in an emitter's cone [m].

    Only points that sound could come by, and that are no farther than `limit` [m]; inf if there are none. It is never
    more than the true distance.
    """
    low, high = 0.0, limit
    for at in range(_EDGES, _EDGES + 6, 3):
        # How far inside of an edge the ray's points are: start + speed * r.
        start = of[at + 2]
        speed = of[at + 1] * dx - of[at] * dy
        if start < 0.0 and speed <= 0.0:
            return math.inf
        if speed > 0.0:
            low = max(low, -start / speed)
        elif speed < 0.0:
            high = min(high, -start / speed)
    if low > high:
        return math.inf
    # The way grows with the point's distance r along the ray: r + sqrt(across^2 - 2 r along + r^2) is the way.
    along = dx * of[_X] + dy * of[_Y]
    across, shortest, longest = of[_ACROSS], of[_SHORTEST], of[_LONGEST]
    if shortest > across:
        least = (shortest - across) * (shortest + across) / (2.0 * (shortest - along))
        low = max(low, least * (1.0 - SLACK) - SLACK)
    if longest > along:
        most = (longest - across) * (longest + across) / (2.0 * (longest - along))
        high = min(high, most * (1.0 + SLACK) + SLACK)
    return low if low <= high else math.inf


@kernel
def face(listeners: Listeners, emitters: Emitters, fan: Array, speed: float, facing: Facing) -> None:
    """Find the emitters that listeners may hear, the cones that may carry a sound, and the listeners that hear none.

    A cone is left out only if no sound via the end of any of its rays could count. `fan` (f,) gives a cone's rays in
    fractions of half its angle, `speed` is that of sound [m/s].
    """
    rows, k = listeners.listens.shape
    count = emitters.poses.shape[1]
    near = np.empty((count, _COLUMNS))
    edges = np.empty((3, 2))
    itself = np.empty(k, dtype=np.int64)  # which emitter each listener of a row is
    cosines, sines, known = np.empty(fan.shape[0]), np.empty(fan.shape[0]), math.nan
    for n in range(rows):
        half, least, most = listeners.cones[n, 0], listeners.cones[n, 1], listeners.cones[n, 2]
        cos_half, sin_half = math.cos(half), math.sin(half)
        if half != known:
            known = half
            for f in range(fan.shape[0]):
                cosines[f], sines[f] = math.cos(half * fan[f]), math.sin(half * fan[f])
        own = 0
        for j in range(k):
            itself[j] = -1
        for i in range(count):
            axis = facing.emitter_axes[n, i]
            axis[0], axis[1] = math.cos(emitters.poses[n, i, 2]), math.sin(emitters.poses[n, i, 2])
            axis[2], axis[3] = math.cos(emitters.half_angle[n, i]), math.sin(emitters.half_angle[n, i])
            if emitters.own[n, i] and own < k:
                itself[own] = i
                own += 1
        for j in range(k):
            m = n * k + j
            axes = facing.axes[m]
            axes[0], axes[1] = math.cos(listeners.poses[m, 2]), math.sin(listeners.poses[m, 2])
            axes[2] = cos_half
            _set_edges(axes[0], axes[1], cos_half, sin_half, edges)
            candidates = 0
            limit = 0.0
            for i in range(count):
                facing.hears[m, i] = False
                if not emitters.fired[n, i] or i == itself[j]:
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
                shortest = 2.0 * least - ahead - slack
                # A way by a surface is twice as long as that is far, give or take what is across.
                across = math.sqrt(x * x + y * y)
                farthest = 0.5 * (longest + across) * (1.0 + SLACK) + SLACK
                _set_candidate(x, y, shortest, longest, farthest, facing.emitter_axes[n, i], near[candidates])
                limit = max(limit, farthest)
                facing.hears[m, i] = True
                candidates += 1
            facing.is_done[m], facing.limit[m] = candidates == 0, -1.0
            # Of many emitters some sound may come by nearly every ray: then only whether any does is found out.
            is_by_ray = candidates <= _FEW
            for f in range(fan.shape[0] if candidates else 0):
                facing.nearest[m, f] = 0.0
                if not is_by_ray and facing.limit[m] >= 0.0:
                    continue
                dx, dy = direction(axes[0], axes[1], cosines[f], sines[f])
                first = math.inf
                for c in range(candidates):
                    first = min(first, _meets_at(dx, dy, limit, near[c]))
                    if not is_by_ray and first < math.inf:
                        break
                if first < math.inf:
                    facing.limit[m] = limit
                if is_by_ray:
                    facing.nearest[m, f] = first
