"""Line segments and shapes: the part of a segment that lies within a shape."""

from __future__ import annotations

import numpy as np

from amorsim.array_types import Array, Bools
from amorsim.core.shapes import Shape

__all__ = ["contains", "crossings", "share_rolled", "share_within"]


def contains(shape: Shape, points: Array) -> Bools:
    """Whether points `(M, 2)` [m] of its frame lie in a circle or a polygon without rounding, its border included."""
    inside = np.zeros(len(points), dtype=bool)
    for part in shape.parts:
        if len(part) == 1:
            inside |= _beyond(part[0], shape.radius, points) <= 0.0
        else:
            inside |= np.all([left >= 0.0 for left in _left_of(part, points)], axis=0)
    return inside


def share_within(shape: Shape, start: Array, end: Array) -> Array:
    """The share `(M,)` of each segment from `start` to `end` `(M, 2)` [m] that is in the shape.

    The shape is a circle, or a polygon without rounding, and its convex parts do not overlap; the points are in its
    frame. The share of a segment of length 0 is 1 if it lies in the shape.
    """
    share = np.zeros(len(start))
    for enters, leaves in crossings(shape, start, end):
        share = share + np.maximum(leaves - enters, 0.0)
    return np.minimum(share, 1.0)  # a segment along the cut between two parts lies in both


def share_rolled(shape: Shape, start: Array, end: Array, ratio: Array) -> Array:
    """The share `(M,)` of a wheel's rolling within the shape, where it travels `ratio` `(M,)` of what it rolls.

    It travels along the line from `start`, and would end at `end` `(M, 2)` [m] without the shape. A wheel that
    travels less within the shape leaves it later, or not at all.
    """
    # A wheel that travels more than it rolls goes beyond `end`.
    stretch = np.maximum(ratio, 1.0)
    found = crossings(shape, start, start + (end - start) * stretch[:, None])
    enters = np.stack([np.where(leaves > enters, enters, np.inf) for enters, leaves in found]) * stretch
    leaves = np.stack([leaves for _, leaves in found]) * stretch
    order = np.argsort(enters, axis=0, kind="stable")
    enters, leaves = np.take_along_axis(enters, order, axis=0), np.take_along_axis(leaves, order, axis=0)
    place, left, share = np.zeros(len(start)), np.ones(len(start)), np.zeros(len(start))
    for first, last in zip(enters, leaves, strict=True):
        left = np.maximum(left - np.maximum(first - place, 0.0), 0.0)
        length = np.where(last > first, last - np.maximum(first, place), 0.0)
        needs = np.where(ratio > 0.0, length / np.where(ratio > 0.0, ratio, 1.0), np.where(length > 0.0, np.inf, 0.0))
        # A wheel that does not reach the border stays within to the end.
        rolled = np.where(last >= stretch, left, np.minimum(np.maximum(needs, 0.0), left))
        rolled = np.where(last > first, rolled, 0.0)
        share, left = share + rolled, left - rolled
        place = np.where(last > first, np.maximum(place, last), place)
    return share


def crossings(shape: Shape, start: Array, end: Array) -> list[tuple[Array, Array]]:
    """For each convex part, the fractions `(M,)` of a segment at entry and exit; the exit comes first if it misses."""
    found = []
    for part in shape.parts:
        enters, leaves = np.zeros(len(start)), np.ones(len(start))
        if len(part) == 1:
            ahead, off = end - start, start - part[0]
            a = ahead[:, 0] ** 2 + ahead[:, 1] ** 2
            b = ahead[:, 0] * off[:, 0] + ahead[:, 1] * off[:, 1]
            c = _beyond(part[0], shape.radius, start)
            moves, meets = a > 0.0, b * b - a * c
            root = np.sqrt(np.maximum(meets, 0.0))
            over = np.where(moves, a, 1.0)
            enters = np.where(moves, np.maximum((-b - root) / over, 0.0), enters)
            leaves = np.where(moves, np.minimum((-b + root) / over, 1.0), leaves)
            leaves = np.where(moves & (meets > 0.0) | ~moves & (c <= 0.0), leaves, -1.0)
        else:
            for before, after in zip(_left_of(part, start), _left_of(part, end), strict=True):
                crossed = before / np.where(before == after, 1.0, before - after)
                enters = np.where((before < 0.0) & (after >= 0.0), np.maximum(enters, crossed), enters)
                leaves = np.where((before >= 0.0) & (after < 0.0), np.minimum(leaves, crossed), leaves)
                leaves = np.where((before < 0.0) & (after < 0.0), -1.0, leaves)
        found.append((enters, leaves))
    return found


def _beyond(centre: Array, radius: float, points: Array) -> Array:
    """Squared distances from the centre minus the squared radius [m^2]."""
    return np.asarray((points[:, 0] - centre[0]) ** 2 + (points[:, 1] - centre[1]) ** 2 - radius**2)


def _left_of(corners: Array, points: Array) -> list[Array]:
    """For each edge of a convex polygon, the side that points lie on: above 0 inside."""
    found = []
    for (x0, y0), (x1, y1) in zip(corners, np.roll(corners, -1, axis=0), strict=True):
        found.append((x1 - x0) * (points[:, 1] - y0) - (y1 - y0) * (points[:, 0] - x0))
    return found
