"""Rays against the outlines of bodies: robots and obstacles as sensors see them.

Every body is first turned and moved so that the ray starts at the origin. Circles around bodies, and a scan's
order by angle, only ever leave out what cannot be hit, so neither changes a bit of the result.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from amorsim.kernels.bodies import Bodies, place_body, rounding_slack
from amorsim.kernels.compile import kernel

__all__ = ["cast_bodies"]

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


@kernel
def _turn(cos: float, sin: float) -> float:
    """A number in [0, 4] that grows with the angle of (cos, sin) over [0, 2 pi): cheap, for ordering only."""
    along = cos / (abs(cos) + abs(sin))
    return 1.0 - along if sin >= 0.0 else 3.0 + along


@kernel
def _turns(cos_b: Floats, sin_b: Floats, row: int, turns: Floats) -> bool:
    """Write how far each beam is turned from the first; whether the beams are in that order."""
    in_order = True
    c = cos_b[row, 0]
    s = sin_b[row, 0]
    for j in range(cos_b.shape[1]):
        cos = c * cos_b[row, j] + s * sin_b[row, j]
        sin = c * sin_b[row, j] - s * cos_b[row, j]
        turns[j] = _turn(cos, sin)
        if j > 0 and not turns[j] >= turns[j - 1]:
            in_order = False
    return in_order


@kernel
def _beams_before(turns: Floats, limit: float, inclusive: bool) -> int:
    """How many beams are turned less than `limit`, or at most that far."""
    low = 0
    high = turns.shape[0]
    while low < high:
        middle = (low + high) // 2
        if turns[middle] < limit or (inclusive and turns[middle] == limit):
            low = middle + 1
        else:
            high = middle
    return low


@kernel
def _disc_range(x: float, y: float, radius: float, dx: float, dy: float) -> float:
    """Where a ray from the origin along (dx, dy) enters a disc [m]; 0 from inside, inf if it misses."""
    away = math.sqrt(x * x + y * y)
    if away <= radius:
        return 0.0
    along = dx * x + dy * y
    across = abs(dx * y - dy * x)
    if along <= 0.0 or across > radius:
        return math.inf
    # The smaller root as a quotient: the difference would cancel close to the disc.
    half_chord = math.sqrt((radius - across) * (radius + across))
    return (away - radius) * (away + radius) / (along + half_chord)


@kernel
def _polygon_range(edges: Floats, first: int, last: int, dx: float, dy: float) -> float:
    """Where a ray from the origin enters a convex polygon [m]; 0 from inside, inf if it misses."""
    enters = 0.0
    leaves = math.inf
    for i in range(first, last):
        outside = edges[i, 0] * edges[i, 2] + edges[i, 1] * edges[i, 3]  # negative if the origin is outside
        speed = dx * edges[i, 2] + dy * edges[i, 3]
        if speed < 0.0:
            enters = max(enters, outside / speed)
        elif speed > 0.0:
            leaves = min(leaves, outside / speed)
        elif outside < 0.0:
            return math.inf
    return enters if enters <= leaves else math.inf


@kernel
def _rounded_range(edges: Floats, first: int, last: int, radius: float, dx: float, dy: float) -> float:
    """Where a ray from the origin enters a convex part rounded by `radius` [m]; else as `_polygon_range`."""
    nearest = math.inf
    inside = last - first > 2
    for i in range(first, last):
        x = edges[i, 0]
        y = edges[i, 1]
        nearest = min(nearest, _disc_range(x, y, radius, dx, dy))
        length = math.sqrt(edges[i, 2] * edges[i, 2] + edges[i, 3] * edges[i, 3])
        nx = edges[i, 2] * edges[i, 4]
        ny = edges[i, 3] * edges[i, 4]
        core = x * nx + y * ny
        if core < 0.0:
            inside = False
        abreast = x * ny - y * nx  # of the origin, along the edge from its first vertex
        if core + radius >= 0.0:
            if core <= 0.0 and 0.0 <= abreast <= length:
                return 0.0
            continue
        speed = dx * nx + dy * ny
        if speed < 0.0:
            distance = (core + radius) / speed
            if 0.0 <= abreast + distance * (dy * nx - dx * ny) <= length:
                nearest = min(nearest, distance)
    return 0.0 if inside else nearest


@kernel
def _body_range(bodies: Bodies, body: int, edges: Floats, dx: float, dy: float) -> float:
    """Where a ray from the origin meets a body placed in `edges` [m]; 0 from inside, inf if it misses."""
    nearest = math.inf
    radius = bodies.radius[body]
    base = bodies.vertex_first[bodies.part_first[body]]
    for part in range(bodies.part_first[body], bodies.part_first[body + 1]):
        first = bodies.vertex_first[part] - base
        last = bodies.vertex_first[part + 1] - base
        if radius == 0.0:
            distance = _polygon_range(edges, first, last, dx, dy)
        elif last - first == 1:
            distance = _disc_range(edges[first, 0], edges[first, 1], radius, dx, dy)
        else:
            distance = _rounded_range(edges, first, last, radius, dx, dy)
        nearest = min(nearest, distance)
    return nearest


@kernel
def cast_bodies(
    bodies: Bodies,
    body_pose: Floats,
    body_replica_first: Ints,
    replica: Ints,
    own: Ints,
    origins: Floats,
    cos_b: Floats,
    sin_b: Floats,
    range_max: Floats,
    out: Floats,
    hit: Ints,
) -> None:
    """Lower each range to where its ray meets another body of the same replica, where that is nearer.

    A ray that starts in a body, or on its border, reads 0. Of bodies equally far the lowest index counts; a
    body as far as what `out` already holds does not.

    Parameters
    ----------
    bodies
        The footprints, of bodies 0 to M - 1.
    body_pose
        Their poses: x [m], y [m], heading [rad], (M, 3).
    body_replica_first
        Bodies of replica r are ``body_replica_first[r]:body_replica_first[r + 1]``, int64 (R + 1,).
    replica
        Of each row, int64 (N,).
    own
        The body that carries the sensor and is not seen, -1 for none, int64 (N,).
    origins
        Where the rays of each row start, and what their bearings are measured from, (N, 3), like `body_pose`.
    cos_b, sin_b
        Of the beams' bearings b; the direction for heading h is (cos h cos b - sin h sin b, sin h cos b + cos
        h sin b). One row for all, or one each, (1 or N, k). Anticlockwise order within one turn is the
        fastest.
    range_max
        Beyond which nothing is seen [m], (1 or N,).
    out
        In: ranges so far [m], inf for none; out: the lower ones, (N, k).
    hit
        Gets the body's index where it lowered a range, and is left alone elsewhere, int64 (N, k).
    """
    rows = out.shape[0]
    beams = out.shape[1]
    if beams == 0:
        return
    most = 0
    for j in range(body_pose.shape[0]):
        last_part = bodies.part_first[j + 1]
        most = max(most, bodies.vertex_first[last_part] - bodies.vertex_first[bodies.part_first[j]])
    edges = np.empty((most, 5))
    turns = np.empty(beams)
    in_order = False
    for i in range(rows):
        table = min(i, cos_b.shape[0] - 1)
        if table == i:
            in_order = _turns(cos_b, sin_b, table, turns)
        limit = range_max[min(i, range_max.shape[0] - 1)]
        cos_h = math.cos(origins[i, 2])
        sin_h = math.sin(origins[i, 2])
        for j in range(body_replica_first[replica[i]], body_replica_first[replica[i] + 1]):
            if j == own[i]:
                continue
            x = body_pose[j, 0] - origins[i, 0]
            y = body_pose[j, 1] - origins[i, 1]
            square = x * x + y * y
            # A circle around the body, larger than it needs to be by far more than rounding can matter.
            circle = bodies.reach[j] * (1.0 + 1e-9) + rounding_slack(abs(origins[i, 0]) + abs(origins[i, 1]))
            if square > (limit + circle) * (limit + circle) * (1.0 + 1e-9):
                continue
            away = math.sqrt(square)
            circle += 1e-9 * away
            # Beams start:stop and, where the circle lies across the first beam, those from `resume` on.
            start = 0
            stop = beams
            resume = beams
            if in_order and circle < away:
                sin_a = circle / away
                cos_a = math.sqrt((1.0 - sin_a) * (1.0 + sin_a))
                # The circle's centre as seen from the first beam, then both its tangents.
                cos_0 = cos_h * cos_b[table, 0] - sin_h * sin_b[table, 0]
                sin_0 = sin_h * cos_b[table, 0] + cos_h * sin_b[table, 0]
                cos_c = cos_0 * x + sin_0 * y
                sin_c = cos_0 * y - sin_0 * x
                right = _turn(cos_c * cos_a + sin_c * sin_a, sin_c * cos_a - cos_c * sin_a)
                left = _turn(cos_c * cos_a - sin_c * sin_a, sin_c * cos_a + cos_c * sin_a)
                start = _beams_before(turns, right, False)
                stop = _beams_before(turns, left, True)
                if right > left:
                    resume = start
                    start = 0
                if start >= stop and resume >= beams:
                    continue
            placed = False
            b = start
            while True:
                if b >= stop:
                    b = max(b, resume)
                    stop = beams
                    resume = beams
                    if b >= beams:
                        break
                dx = cos_h * cos_b[table, b] - sin_h * sin_b[table, b]
                dy = sin_h * cos_b[table, b] + cos_h * sin_b[table, b]
                in_circle = abs(dx * y - dy * x) <= circle and dx * x + dy * y >= -circle
                if in_circle and out[i, b] > away - circle:
                    if not placed:
                        place_body(bodies, j, x, y, math.cos(body_pose[j, 2]), math.sin(body_pose[j, 2]), edges)
                        placed = True
                    distance = _body_range(bodies, j, edges, dx, dy)
                    if distance <= limit and distance < out[i, b]:
                        out[i, b] = distance
                        hit[i, b] = j
                b += 1
