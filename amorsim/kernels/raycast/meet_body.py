"""Hits of rays from one place on one body: a disc, a convex polygon, a rounded one, or several of them.

The rays start at the origin, and a scan's beams go together, in loops without a branch, which compilers make several
beams wide.
"""

from __future__ import annotations

import math

from amorsim.array_types import Array
from amorsim.kernels.collision.footprints import Bodies, place_body
from amorsim.kernels.compile import part

__all__ = ["BEAM_ROWS", "DX", "DY", "FOUND", "meet_body", "meet_part", "place_to_meet"]


# Rows of what is held of a scan's beams: which way they go, where they meet a body [m], and where they enter and leave
# a polygon.
DX, DY, FOUND, _ENTERS, _LEAVES = range(5)
BEAM_ROWS = 5


@part
def _meet_disc(x: float, y: float, radius: float, dx: Array, dy: Array, found: Array) -> None:
    """Lower `found` to where rays from the origin enter a disc [m]; 0 from inside."""
    away = math.sqrt(x * x + y * y)
    if away <= radius:
        for b in range(found.shape[0]):
            found[b] = 0.0
        return
    power = (away - radius) * (away + radius)
    for b in range(dx.shape[0]):
        along = dx[b] * x + dy[b] * y
        across = abs(dx[b] * y - dy[b] * x)
        # The smaller root as a quotient: the difference would cancel close to the disc. What misses has no root.
        half_chord = math.sqrt((radius - across) * (radius + across))
        distance = power / (along + half_chord)
        met = (along > 0.0) & (across <= radius) & (distance < found[b])
        found[b] = distance if met else found[b]


@part
def _meet_polygon(
    edges: Array, first: int, last: int, dx: Array, dy: Array, enters: Array, leaves: Array, found: Array
) -> None:
    """Lower `found` to where rays from the origin enter a convex polygon [m]; 0 from inside.

    Edge by edge for all rays at once, and the cases chosen, not branched to: so several rays go side by side.
    """
    for b in range(dx.shape[0]):
        enters[b] = 0.0
        leaves[b] = math.inf
    for i in range(first, last):
        nx = edges[i, 2]
        ny = edges[i, 3]
        outside = edges[i, 0] * nx + edges[i, 1] * ny  # negative if the origin is outside
        along = -math.inf if outside < 0.0 else math.inf  # where a ray along the edge leaves
        for b in range(dx.shape[0]):
            speed = dx[b] * nx + dy[b] * ny
            at = outside / speed
            enters[b] = max(enters[b], at if speed < 0.0 else -math.inf)
            leaves[b] = min(leaves[b], at if speed > 0.0 else (along if speed == 0.0 else math.inf))
    for b in range(dx.shape[0]):
        # Where a ray misses, it leaves before it would have entered.
        found[b] = min(found[b], enters[b] if enters[b] <= leaves[b] else math.inf)


@part
def _meet_rounded(edges: Array, first: int, last: int, radius: float, dx: Array, dy: Array, found: Array) -> None:
    """Lower `found` to where rays from the origin enter a convex part rounded by `radius` [m]; 0 from inside."""
    inside = last - first > 2
    for i in range(first, last):
        x = edges[i, 0]
        y = edges[i, 1]
        _meet_disc(x, y, radius, dx, dy, found)
        length = math.sqrt(edges[i, 2] * edges[i, 2] + edges[i, 3] * edges[i, 3])
        nx = edges[i, 2] * edges[i, 4]
        ny = edges[i, 3] * edges[i, 4]
        core = x * nx + y * ny
        if core < 0.0:
            inside = False
        abreast = x * ny - y * nx  # of the origin, along the edge from its first vertex
        if core + radius >= 0.0:
            if core <= 0.0 and 0.0 <= abreast <= length:
                for b in range(found.shape[0]):
                    found[b] = 0.0
            continue
        for b in range(dx.shape[0]):
            speed = dx[b] * nx + dy[b] * ny
            distance = (core + radius) / speed
            along = abreast + distance * (dy[b] * nx - dx[b] * ny)
            met = (speed < 0.0) & (along >= 0.0) & (along <= length) & (distance < found[b])
            found[b] = distance if met else found[b]
    if inside:
        for b in range(found.shape[0]):
            found[b] = 0.0


@part
def meet_part(edges: Array, first: int, last: int, radius: float, beams: Array, start: int, stop: int) -> None:
    """Lower the ranges of beams start..stop-1 to where they meet a convex part, rounded by `radius` [m], of a body.

    Vertices first..last-1 of the body are the part's; `edges` as `place_body` writes them.
    """
    dx = beams[DX, start:stop]
    dy = beams[DY, start:stop]
    found = beams[FOUND, start:stop]
    if radius == 0.0:
        _meet_polygon(edges, first, last, dx, dy, beams[_ENTERS, start:stop], beams[_LEAVES, start:stop], found)
    elif last - first == 1:
        _meet_disc(edges[first, 0], edges[first, 1], radius, dx, dy, found)
    else:
        _meet_rounded(edges, first, last, radius, dx, dy, found)


@part
def place_to_meet(bodies: Bodies, body: int, pose: Array, x: float, y: float, edges: Array) -> None:
    """Write the `edges` of a body at (x, y) [m], as `place_body` does; a disc about its base is turned by nothing."""
    first, last = bodies.part_first[body], bodies.part_first[body + 1]
    base = bodies.vertex_first[first]
    if bodies.vertex_first[last] == base + 1 and bodies.vertices[base, 0] == 0.0 == bodies.vertices[base, 1]:
        edges[0] = 0.0
        edges[0, 0], edges[0, 1] = x, y
    else:
        place_body(bodies, body, x, y, math.cos(pose[2]), math.sin(pose[2]), edges)


@part
def meet_body(
    bodies: Bodies, body: int, pose: Array, x: float, y: float, edges: Array, beams: Array, start: int, stop: int
) -> None:
    """Write where beams start..stop-1 from the origin meet a body at (x, y) [m]; inf if they miss."""
    for b in range(start, stop):
        beams[FOUND, b] = math.inf
    place_to_meet(bodies, body, pose, x, y, edges)
    base = bodies.vertex_first[bodies.part_first[body]]
    for piece in range(bodies.part_first[body], bodies.part_first[body + 1]):
        first = bodies.vertex_first[piece] - base
        last = bodies.vertex_first[piece + 1] - base
        meet_part(edges, first, last, bodies.radius[body], beams, start, stop)
