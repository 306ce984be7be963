"""The footprints of moving bodies as arrays, and the gap between two of them.

A body is a union of convex parts, each rounded by the body's radius (its Minkowski sum with a disc). Two
parts are apart if an edge of either has all vertices of the other on its outer side; else their interiors
overlap. That test, evaluated in double precision as written here, is what overlap *means*. The distance never
contradicts it: it is never taken below the separation along an edge's normal.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from amorsim.array_types import Array, Ints
from amorsim.kernels.compile import kernel

__all__ = ["Bodies", "body_gap", "body_gaps", "most_vertices", "place_body", "rounding_slack"]


class Bodies(NamedTuple):
    """Footprints in their own frames [m]; made by `amorsim.core.shapes.pack`.

    Part p has the vertices ``vertex_first[p]:vertex_first[p + 1]``, anticlockwise; body b has the parts
    ``part_first[b]:part_first[b + 1]``. Each part is rounded by ``radius[b]``; no point of body b is farther
    than ``reach[b]`` from its origin.
    """

    vertices: Array
    vertex_first: Ints
    part_first: Ints
    radius: Array
    reach: Array


@kernel
def rounding_slack(extent: float) -> float:
    """Bound of the rounding error of a distance [m] computed from coordinates that add up to `extent` [m]."""
    return 1.8e-15 * extent


@kernel
def most_vertices(bodies: Bodies, chosen: Ints) -> int:
    """Vertices of the largest body among `chosen` (Q,): the rows that a scratch array needs."""
    most = 0
    for q in range(chosen.shape[0]):
        first = bodies.part_first[chosen[q]]
        last = bodies.part_first[chosen[q] + 1]
        most = max(most, bodies.vertex_first[last] - bodies.vertex_first[first])
    return most


@kernel
def place_body(bodies: Bodies, body: int, x: float, y: float, cos: float, sin: float, edges: Array) -> None:
    """Write the vertices of `body`, turned by (cos, sin) and moved to (x, y), and the edges that begin there.

    A row of `edges` (V, 5): the vertex, the outward normal of its edge (as long as the edge), and the inverse
    of that length; the normal and the inverse of a lone vertex are 0.
    """
    base = bodies.vertex_first[bodies.part_first[body]]
    for part in range(bodies.part_first[body], bodies.part_first[body + 1]):
        first = bodies.vertex_first[part] - base
        last = bodies.vertex_first[part + 1] - base
        for i in range(first, last):
            vx = bodies.vertices[base + i, 0]
            vy = bodies.vertices[base + i, 1]
            edges[i, 0] = x + (cos * vx - sin * vy)
            edges[i, 1] = y + (sin * vx + cos * vy)
        for i in range(first, last):
            j = i + 1 if i + 1 < last else first
            nx = edges[j, 1] - edges[i, 1]
            ny = edges[i, 0] - edges[j, 0]
            length = math.sqrt(nx * nx + ny * ny)
            edges[i, 2] = nx
            edges[i, 3] = ny
            edges[i, 4] = 1.0 / length if length > 0.0 else 0.0


@kernel
def _separation(edges: Array, first: int, last: int, others: Array, other_first: int, other_last: int) -> float:
    """The largest distance [m] by which all of the other part is outside one edge; negative if outside none."""
    most = -math.inf
    if last - first < 2:
        return most
    for i in range(first, last):
        least = math.inf
        for j in range(other_first, other_last):
            side = (others[j, 0] - edges[i, 0]) * edges[i, 2] + (others[j, 1] - edges[i, 1]) * edges[i, 3]
            least = min(least, side)
        most = max(most, least * edges[i, 4])
    return most


@kernel
def _nearest_edge(edges: Array, first: int, last: int, x: float, y: float) -> float:
    """The distance [m] from a point to the nearest edge that it is abreast of; inf if it is abreast of none."""
    nearest = math.inf
    for i in range(first, last):
        dx = x - edges[i, 0]
        dy = y - edges[i, 1]
        nx = edges[i, 2]
        ny = edges[i, 3]
        along = dy * nx - dx * ny
        if 0.0 < along < nx * nx + ny * ny:
            nearest = min(nearest, abs(dx * nx + dy * ny) * edges[i, 4])
    return nearest


@kernel
def _distance(edges: Array, first: int, last: int, others: Array, other_first: int, other_last: int) -> float:
    """Distance [m] between two convex parts that are apart."""
    nearest = math.inf
    square = math.inf
    for j in range(other_first, other_last):
        x = others[j, 0]
        y = others[j, 1]
        nearest = min(nearest, _nearest_edge(edges, first, last, x, y))
        for i in range(first, last):
            dx = x - edges[i, 0]
            dy = y - edges[i, 1]
            square = min(square, dx * dx + dy * dy)
    for i in range(first, last):
        nearest = min(nearest, _nearest_edge(others, other_first, other_last, edges[i, 0], edges[i, 1]))
    return min(nearest, math.sqrt(square))


@kernel
def body_gap(
    bodies: Bodies,
    a: int,
    pose_a: Array,
    b: int,
    pose_b: Array,
    cap: float,
    edges_a: Array,
    edges_b: Array,
) -> float:
    """Signed gap [m] between body `a` at `pose_a` (3,) and `b` at `pose_b`, as in `body_gaps`.

    `edges_a` and `edges_b` are scratch, (rows, 5) with `most_vertices` rows at least.
    """
    dx = pose_a[0] - pose_b[0]
    dy = pose_a[1] - pose_b[1]
    extent_a = abs(pose_a[0]) + abs(pose_a[1]) + bodies.reach[a]
    extent_b = abs(pose_b[0]) + abs(pose_b[1]) + bodies.reach[b]
    slack = rounding_slack(extent_a + extent_b)
    if math.sqrt(dx * dx + dy * dy) - (bodies.reach[a] + bodies.reach[b]) - slack >= cap:
        return cap

    place_body(bodies, a, pose_a[0], pose_a[1], math.cos(pose_a[2]), math.sin(pose_a[2]), edges_a)
    place_body(bodies, b, pose_b[0], pose_b[1], math.cos(pose_b[2]), math.sin(pose_b[2]), edges_b)
    base_a = bodies.vertex_first[bodies.part_first[a]]
    base_b = bodies.vertex_first[bodies.part_first[b]]
    radius = bodies.radius[a] + bodies.radius[b]
    # The order of the parts does not change the result: a pair is left out only if it cannot lower the minimum.
    limit = cap + slack
    gap = limit
    for part_a in range(bodies.part_first[a], bodies.part_first[a + 1]):
        first_a = bodies.vertex_first[part_a] - base_a
        last_a = bodies.vertex_first[part_a + 1] - base_a
        for part_b in range(bodies.part_first[b], bodies.part_first[b + 1]):
            first_b = bodies.vertex_first[part_b] - base_b
            last_b = bodies.vertex_first[part_b + 1] - base_b
            apart = max(
                _separation(edges_a, first_a, last_a, edges_b, first_b, last_b),
                _separation(edges_b, first_b, last_b, edges_a, first_a, last_a),
            )
            if last_a - first_a == 1 and last_b - first_b == 1:
                apart = 0.0  # two points: no edge that separates them, no interiors that overlap
            if apart - radius >= gap:
                continue
            if apart >= 0.0:
                apart = max(apart, _distance(edges_a, first_a, last_a, edges_b, first_b, last_b))
            gap = min(gap, apart - radius)
    if gap < 0.0:
        return gap
    return cap if gap == limit else max(0.0, min(cap, gap - slack))


@kernel
def body_gaps(bodies: Bodies, a: Ints, poses_a: Array, b: Ints, poses_b: Array, cap: Array, out: Array) -> None:
    """Write the signed gap [m] of each pair of bodies, no more than `cap`.

    A gap of 0 or more: the interiors are disjoint, and the gap is their Euclidean distance less what rounding
    may have added to it (about 2e-15 of the coordinates), so a body may move so far without overlap. A
    negative gap: the interiors overlap; its size is no measure of how much. Touching gives 0. Swapping the
    bodies gives the same bits.

    Parameters
    ----------
    bodies
        The footprints.
    a, b
        Which bodies, int64 (Q,).
    poses_a, poses_b
        Their poses: x [m], y [m], heading [rad], (Q, 3), both in one frame.
    cap
        Larger gaps are not distinguished [m], 0 or more, (Q,).
    out
        The gaps [m], (Q,).
    """
    edges_a = np.empty((most_vertices(bodies, a), 5))
    edges_b = np.empty((most_vertices(bodies, b), 5))
    for q in range(out.shape[0]):
        out[q] = body_gap(bodies, a[q], poses_a[q], b[q], poses_b[q], cap[q], edges_a, edges_b)
