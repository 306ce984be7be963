"""How far a convex part of a body is from a box of cells: the arithmetic of `amorsim.kernels.collision.clearance`."""

from __future__ import annotations

import math

from amorsim.array_types import Array
from amorsim.kernels.compile import kernel

__all__ = ["Box", "part_bounds", "part_distance", "part_separation"]

Box = tuple[float, float, float, float]


@kernel
def part_bounds(edges: Array, first: int, last: int) -> Box:
    """Least x, least y, largest x, largest y [m] of the vertices of a part."""
    low_x = math.inf
    low_y = math.inf
    high_x = -math.inf
    high_y = -math.inf
    for i in range(first, last):
        low_x = min(low_x, edges[i, 0])
        low_y = min(low_y, edges[i, 1])
        high_x = max(high_x, edges[i, 0])
        high_y = max(high_y, edges[i, 1])
    return low_x, low_y, high_x, high_y


@kernel
def part_separation(edges: Array, first: int, last: int, bounds: Box, box: Box, enough: float) -> float:
    """Separation [m] of a convex part and a box (x0, y0, x1, y1) along a side of either; negative: overlap.

    Never more than their distance, and equal to it for a part of one vertex. Stops early at `enough` or more.
    """
    low_x, low_y, high_x, high_y = bounds
    x0, y0, x1, y1 = box
    across_x = max(x0 - high_x, low_x - x1)
    across_y = max(y0 - high_y, low_y - y1)
    most = max(across_x, across_y)
    if last - first == 1:
        if across_x > 0.0 and across_y > 0.0:
            most = math.sqrt(across_x * across_x + across_y * across_y)
        return most
    for i in range(first, last):
        if most >= enough:
            break
        nx = edges[i, 2]
        ny = edges[i, 3]
        # The corner farthest inward along the normal.
        x = x0 if nx > 0.0 else x1
        y = y0 if ny > 0.0 else y1
        most = max(most, ((x - edges[i, 0]) * nx + (y - edges[i, 1]) * ny) * edges[i, 4])
    return most


@kernel
def part_distance(edges: Array, first: int, last: int, box: Box) -> tuple[float, float, float]:
    """Distance [m] between a convex part and a box that are apart, and the nearest point of the box."""
    x0, y0, x1, y1 = box
    square = math.inf
    near_x = x0
    near_y = y0
    for i in range(first, last):
        x = min(max(edges[i, 0], x0), x1)
        y = min(max(edges[i, 1], y0), y1)
        dx = x - edges[i, 0]
        dy = y - edges[i, 1]
        if dx * dx + dy * dy < square:
            square = dx * dx + dy * dy
            near_x = x
            near_y = y
    nearest = math.sqrt(square)
    if last - first > 1:
        for i in range(first, last):
            nx = edges[i, 2]
            ny = edges[i, 3]
            # Of the box's points, only the corner farthest inward along the normal can be nearest to an
            # edge's inside.
            x = x0 if nx > 0.0 else x1
            y = y0 if ny > 0.0 else y1
            dx = x - edges[i, 0]
            dy = y - edges[i, 1]
            along = dy * nx - dx * ny
            if 0.0 < along < nx * nx + ny * ny:
                away = (dx * nx + dy * ny) * edges[i, 4]
                if 0.0 <= away < nearest:
                    nearest = away
                    near_x = x
                    near_y = y
    return nearest, near_x, near_y
