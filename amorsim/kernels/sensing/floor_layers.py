"""The topmost of several shapes on the floor at given places."""

from __future__ import annotations

import math

from amorsim.array_types import Array, Ints
from amorsim.kernels.collision.footprints import Bodies
from amorsim.kernels.compile import kernel

__all__ = ["topmost"]


@kernel
def _gap(ax: float, ay: float, bx: float, by: float, x: float, y: float) -> float:
    """Distance [m] from (x, y) to the line from a to b, which may be one point."""
    dx, dy = bx - ax, by - ay
    square = dx * dx + dy * dy
    along = ((x - ax) * dx + (y - ay) * dy) / square if square > 0.0 else 0.0
    along = min(max(along, 0.0), 1.0)
    away_x, away_y = x - (ax + along * dx), y - (ay + along * dy)
    return math.sqrt(away_x * away_x + away_y * away_y)


@kernel
def _covers(bodies: Bodies, part: int, radius: float, x: float, y: float) -> bool:
    """Whether a convex part, rounded by `radius`, holds a point of its frame, its border included."""
    first, last = bodies.vertex_first[part], bodies.vertex_first[part + 1]
    inside = last - first > 2
    nearest = math.inf
    for i in range(first, last):
        j = i + 1 if i + 1 < last else first
        ax, ay, bx, by = bodies.vertices[i, 0], bodies.vertices[i, 1], bodies.vertices[j, 0], bodies.vertices[j, 1]
        if (bx - ax) * (y - ay) - (by - ay) * (x - ax) < 0.0:
            inside = False
        nearest = min(nearest, _gap(ax, ay, bx, by, x, y))
    return inside or nearest <= radius


@kernel
def topmost(shapes: Bodies, poses: Array, places: Array, out: Ints) -> None:
    """Write the number of the last of `shapes` that covers each of `places` (Q, 2) [m] into `out` (Q,), -1 for none.

    `poses` (B, 3) are where the shapes lie: x [m], y [m], heading [rad].
    """
    for q in range(places.shape[0]):
        out[q] = -1
        for body in range(poses.shape[0] - 1, -1, -1):
            dx, dy = places[q, 0] - poses[body, 0], places[q, 1] - poses[body, 1]
            if dx * dx + dy * dy > (1.0 + 1e-9) * shapes.reach[body] * shapes.reach[body]:
                continue
            c, s = math.cos(poses[body, 2]), math.sin(poses[body, 2])
            x, y = c * dx + s * dy, c * dy - s * dx
            for part in range(shapes.part_first[body], shapes.part_first[body + 1]):
                if _covers(shapes, part, shapes.radius[body], x, y):
                    out[q] = body
                    break
            if out[q] >= 0:
                break
