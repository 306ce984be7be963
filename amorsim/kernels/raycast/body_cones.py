"""The nearest body in a cone: the least that `body_rays.cast_bodies` gives for its beams, sooner.

A convex part is nearest in one direction. The farther a beam is from it, to either side, the farther it goes until it
meets the part, if it does. So the least of a cone's beams is one of the two beside that direction, or an outermost one
where the cone does not hold it. Which one that is, is left to the same computation as for all beams: its bits count.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from amorsim.array_types import Array, Ints
from amorsim.kernels.collision.body_hash import BodyHash, run_of_bodies, window
from amorsim.kernels.collision.footprints import Bodies, rounding_slack
from amorsim.kernels.compile import kernel, part
from amorsim.kernels.raycast.meet_body import BEAM_ROWS, DX, DY, FOUND, meet_part, place_to_meet

__all__ = ["nearest_bodies"]


_CLOSE = 1e-6  # [m] so near the direction to a corner means nothing


class _Cone(NamedTuple):
    """Where a cone looks from and to: its tip [m], its axis, half its angle [rad]."""

    x: float
    y: float
    cos: float
    sin: float
    half: float


@part
def _extent(axis: float, aside: float, cos_w: float, sin_w: float, reach: float) -> tuple[float, float]:
    """From where to where along a line a cone extends from its tip [m], as far as `reach` [m].

    `axis` is how much of the cone's axis is along the line, `aside` of what is a quarter turn from the axis.
    """
    edge, other = axis * cos_w + aside * sin_w, axis * cos_w - aside * sin_w
    low = -1.0 if -axis >= cos_w else min(0.0, edge, other)
    high = 1.0 if axis >= cos_w else max(0.0, edge, other)
    return reach * low, reach * high


@part
def _nearest_way(edges: Array, first: int, last: int) -> tuple[float, float, float]:
    """The direction (x, y) and distance [m] of the nearest point of vertices first..last-1 and their edges.

    0 from within: then any direction will do.
    """
    x, y, square = 0.0, 0.0, math.inf
    for i in range(first, last):
        its = edges[i, 0] * edges[i, 0] + edges[i, 1] * edges[i, 1]
        if its < square:
            x, y, square = edges[i, 0], edges[i, 1], its
    away = math.sqrt(square)
    within = last - first > 2
    for i in range(first, last):
        nx = edges[i, 2]
        ny = edges[i, 3]
        outside = -(edges[i, 0] * nx + edges[i, 1] * ny) * edges[i, 4]
        abreast = edges[i, 0] * ny - edges[i, 1] * nx
        if 0.0 < outside <= away and 0.0 <= abreast <= nx * nx + ny * ny:
            x, y, away = -nx, -ny, outside
        within &= outside <= 0.0
    return x, y, 0.0 if within else away


@part
def _least_of_beams(
    edges: Array,
    first: int,
    last: int,
    radius: float,
    cone: _Cone,
    cos_b: Array,
    sin_b: Array,
    start: int,
    stop: int,
    beams: Array,
) -> float:
    """The least distance [m] at which beams start..stop-1 meet a part."""
    for b in range(start, stop):
        beams[DX, b] = cone.cos * cos_b[0, b] - cone.sin * sin_b[0, b]
        beams[DY, b] = cone.sin * cos_b[0, b] + cone.cos * sin_b[0, b]
        beams[FOUND, b] = math.inf
    meet_part(edges, first, last, radius, beams, start, stop)
    least = math.inf
    for b in range(start, stop):
        least = min(least, beams[FOUND, b])
    return least


@part
def _least_of_part(
    edges: Array,
    first: int,
    last: int,
    radius: float,
    cone: _Cone,
    cos_b: Array,
    sin_b: Array,
    reach: float,
    beams: Array,
) -> float:
    """The least distance [m] at which a cone's beams meet a part; inf if that is more than `reach` [m]."""
    count = cos_b.shape[1]
    x, y, away = _nearest_way(edges, first, last)
    if (away - radius) * (1.0 - 1e-9) > reach:
        return math.inf
    if away < _CLOSE or count < 3:
        return _least_of_beams(edges, first, last, radius, cone, cos_b, sin_b, 0, count, beams)
    # Between which beams the direction lies.
    angle = math.atan2(cone.cos * y - cone.sin * x, cone.cos * x + cone.sin * y)
    place = (angle + cone.half) / (2.0 * cone.half) * (count - 1)
    if 0.0 <= place <= count - 1:
        # One more to either side, as the place is rounded.
        start, stop = max(int(place) - 1, 0), min(int(place) + 3, count)
        return _least_of_beams(edges, first, last, radius, cone, cos_b, sin_b, start, stop, beams)
    return min(
        _least_of_beams(edges, first, last, radius, cone, cos_b, sin_b, 0, 1, beams),
        _least_of_beams(edges, first, last, radius, cone, cos_b, sin_b, count - 1, count, beams),
    )


@kernel
def nearest_bodies(
    bodies: Bodies,
    body_pose: Array,
    edge_rows: int,
    table: BodyHash,
    widest: float,
    replica: Ints,
    own: Ints,
    origins: Array,
    half_angle: float,
    cos_b: Array,
    sin_b: Array,
    range_max: Array,
    out: Array,
) -> None:
    """Lower the range of each cone to where the nearest of its beams meets another body of the same replica.

    Arguments are those of `body_rays.cast_bodies`, but for these.

    Parameters
    ----------
    origins
        The tips of the cones [m], and where they look [rad], (N, 3).
    half_angle
        Of all cones, from the axis to the edge [rad].
    cos_b, sin_b
        Of the beams' bearings, (1, k), evenly spread from one edge to the other.
    range_max
        Beyond which nothing is seen [m], (N,).
    out
        In: ranges so far [m], inf for none; out: the lower ones, (N,).
    """
    edges = np.empty((edge_rows, 5))
    beams = np.empty((BEAM_ROWS, cos_b.shape[1]))
    cos_w, sin_w = math.cos(half_angle), math.sin(half_angle)
    for i in range(out.shape[0]):
        cone = _Cone(origins[i, 0], origins[i, 1], math.cos(origins[i, 2]), math.sin(origins[i, 2]), half_angle)
        slack = rounding_slack(abs(cone.x) + abs(cone.y))
        reach = min(range_max[i], out[i])
        around = widest * (1.0 + 1e-9) + slack
        x0, x1 = _extent(cone.cos, cone.sin, cos_w, sin_w, reach)
        y0, y1 = _extent(cone.sin, cone.cos, cos_w, sin_w, reach)
        row0, rows = window(cone.y + 0.5 * (y0 + y1), 0.5 * (y1 - y0) + around, table.side, table.rows)
        col0, cols = window(cone.x + 0.5 * (x0 + x1), 0.5 * (x1 - x0) + around, table.side, table.cols)
        for run in range(2 * rows if col0 + cols > table.cols else rows):
            place, end = run_of_bodies(table, replica[i], row0, rows, col0, cols, run)
            for n in range(place, end):
                x = table.disc[n, 0] - cone.x
                y = table.disc[n, 1] - cone.y
                # A circle around the body, larger than it needs to be by far more than rounding can matter.
                circle = (table.disc[n, 2] + slack) * (1.0 + 1e-8) + 1e-8 * (abs(x) + abs(y))
                far = reach + circle
                if table.owner[n] == own[i] or not x * x + y * y <= far * far:
                    continue
                # How far the centre is beyond the nearer edge, if that is known to be less than a quarter turn aside.
                ahead = cone.cos * x + cone.sin * y
                aside = abs(cone.cos * y - cone.sin * x)
                if cos_w > 0.0 and aside * cos_w - ahead * sin_w > circle:
                    continue
                body = table.body[n]
                place_to_meet(bodies, body, body_pose[body], x, y, edges)
                base = bodies.vertex_first[bodies.part_first[body]]
                for piece in range(bodies.part_first[body], bodies.part_first[body + 1]):
                    found = _least_of_part(
                        edges,
                        bodies.vertex_first[piece] - base,
                        bodies.vertex_first[piece + 1] - base,
                        bodies.radius[body],
                        cone,
                        cos_b,
                        sin_b,
                        reach,
                        beams,
                    )
                    if found <= reach:
                        out[i] = reach = found
