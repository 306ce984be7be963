"""The normals of bodies' surfaces where rays enter them."""

from __future__ import annotations

import math

import numpy as np

from amorsim.array_types import Array, Ints
from amorsim.kernels.collision.footprints import Bodies, place_body
from amorsim.kernels.compile import kernel

__all__ = ["normals_of"]


# What is held of the surface found so far: how far off it is [m], and its normal.
_FAR, _NX, _NY = range(3)


@kernel
def _enter_polygon(edges: Array, first: int, last: int, dx: float, dy: float, best: Array) -> None:
    """Note the edge by which a ray from the origin enters a convex polygon, where that is nearer than `best`."""
    enters, leaves, edge = -math.inf, math.inf, -1
    for i in range(first, last):
        nx, ny = edges[i, 2], edges[i, 3]
        outside = edges[i, 0] * nx + edges[i, 1] * ny
        speed = dx * nx + dy * ny
        if speed < 0.0:
            if outside / speed > enters:
                enters, edge = outside / speed, i
        elif speed > 0.0:
            leaves = min(leaves, outside / speed)
        elif outside < 0.0:
            return
    if edge >= 0 and 0.0 <= enters <= leaves and enters < best[_FAR]:
        best[_FAR], best[_NX], best[_NY] = enters, edges[edge, 2], edges[edge, 3]


@kernel
def _enter_disc(x: float, y: float, radius: float, dx: float, dy: float, best: Array) -> None:
    """Note where a ray from the origin enters a disc about (x, y), where that is nearer than `best`."""
    away = math.sqrt(x * x + y * y)
    along = dx * x + dy * y
    across = abs(dx * y - dy * x)
    if away <= radius or along <= 0.0 or across > radius:
        return
    half_chord = math.sqrt((radius - across) * (radius + across))
    distance = (away - radius) * (away + radius) / (along + half_chord)
    if distance < best[_FAR]:
        best[_FAR], best[_NX], best[_NY] = distance, distance * dx - x, distance * dy - y


@kernel
def _enter_rounded(edges: Array, first: int, last: int, radius: float, dx: float, dy: float, best: Array) -> None:
    """Note where a ray from the origin enters a convex part rounded by `radius`, where that is nearer than `best`."""
    for i in range(first, last):
        x, y = edges[i, 0], edges[i, 1]
        _enter_disc(x, y, radius, dx, dy, best)
        nx, ny = edges[i, 2] * edges[i, 4], edges[i, 3] * edges[i, 4]
        core = x * nx + y * ny
        speed = dx * nx + dy * ny
        if core + radius >= 0.0 or speed >= 0.0:
            continue
        distance = (core + radius) / speed
        along = x * ny - y * nx + distance * (dy * nx - dx * ny)
        if along >= 0.0 and along * edges[i, 4] <= 1.0 and distance < best[_FAR]:
            best[_FAR], best[_NX], best[_NY] = distance, nx, ny


@kernel
def normals_of(
    bodies: Bodies, poses: Array, edge_rows: int, origins: Array, bearings: Array, which: Ints, out: Array
) -> None:
    """Write the directions [rad] of the outward normals where rays enter bodies into `out` (N, k).

    nan where `which` (N, k) is -1, where a ray starts in the body, and where it misses it. Of equally near surfaces of
    one body the first counts.

    Parameters
    ----------
    bodies, poses
        The footprints, and where they stand: x [m], y [m], heading [rad], (M, 3).
    edge_rows
        Vertices of the largest body.
    origins
        Where the rays of each row start, (N, 3), like `poses`.
    bearings
        Of the rays [rad], from the origins' headings, (N, k).
    which
        The body that each ray enters, int64 (N, k).
    """
    edges = np.empty((edge_rows, 5))
    best = np.empty(3)
    for i in range(which.shape[0]):
        cos_h, sin_h = math.cos(origins[i, 2]), math.sin(origins[i, 2])
        for j in range(which.shape[1]):
            out[i, j] = math.nan
            body = which[i, j]
            if body < 0:
                continue
            # As the rays were cast, to the bit: one that grazed the body grazes it here too.
            cos_b, sin_b = math.cos(bearings[i, j]), math.sin(bearings[i, j])
            dx, dy = cos_h * cos_b - sin_h * sin_b, sin_h * cos_b + cos_h * sin_b
            x, y = poses[body, 0] - origins[i, 0], poses[body, 1] - origins[i, 1]
            place_body(bodies, body, x, y, math.cos(poses[body, 2]), math.sin(poses[body, 2]), edges)
            radius = bodies.radius[body]
            first_part, last_part = bodies.part_first[body], bodies.part_first[body + 1]
            base = bodies.vertex_first[first_part]
            best[_FAR] = math.inf
            for piece in range(first_part, last_part):
                first, last = bodies.vertex_first[piece] - base, bodies.vertex_first[piece + 1] - base
                if radius == 0.0:
                    _enter_polygon(edges, first, last, dx, dy, best)
                else:
                    _enter_rounded(edges, first, last, radius, dx, dy, best)
            if best[_FAR] < math.inf:
                out[i, j] = math.atan2(best[_NY], best[_NX])
