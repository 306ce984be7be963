"""A path that a robot is led along: where it is on it, where it looks ahead, and how far a place is from its end."""

from __future__ import annotations

import math
from typing import NamedTuple

from amorsim.array_types import Array, Ints
from amorsim.kernels.compile import part

__all__ = ["Guide", "ahead_on", "find_leg", "to_go"]


class Guide(NamedTuple):
    """The paths of N robots, of P points at most."""

    path: Array
    """(N, P, 2) [m] the corners of each in the world, one at least; the last is the goal."""
    along: Array
    """(N, P) [m] their distances along the path."""
    size: Ints
    """(N,) how many points each has."""
    leg: Ints
    """(N,) the leg that each robot is on, by the number of the point that it begins at; changed."""


@part
def _on_leg(path: Array, along: Array, leg: int, x: float, y: float) -> tuple[float, float]:
    """How far along the path [m] the place of a leg nearest to (x, y) is, and the distance [m] to it."""
    ux = path[leg + 1, 0] - path[leg, 0]
    uy = path[leg + 1, 1] - path[leg, 1]
    length = along[leg + 1] - along[leg]
    t = 0.0
    if length > 0.0:
        t = min(max(((x - path[leg, 0]) * ux + (y - path[leg, 1]) * uy) / length, 0.0), length)
        ux /= length
        uy /= length
    dx = path[leg, 0] + t * ux - x
    dy = path[leg, 1] + t * uy - y
    return along[leg] + t, math.sqrt(dx * dx + dy * dy)


@part
def find_leg(path: Array, along: Array, count: int, leg: int, far: float, x: float, y: float) -> tuple[int, float]:
    """The leg nearest to (x, y), from `leg` on and `far` [m] beyond at most, and how far along the path [m] that is."""
    best = math.inf
    found = min(max(leg, 0), max(count - 2, 0))
    where = along[found]
    limit = math.inf
    for j in range(found, count - 1):
        if along[j] > limit:
            break
        s, away = _on_leg(path, along, j, x, y)
        if limit == math.inf:
            limit = s + far
        if away < best:
            best = away
            found = j
            where = s
    return found, where


@part
def ahead_on(path: Array, along: Array, count: int, leg: int, s: float) -> tuple[float, float]:
    """The place `s` [m] along the path, on `leg` or later; its end beyond that."""
    for j in range(leg, count - 1):
        if along[j + 1] >= s and along[j + 1] > along[j]:
            t = (s - along[j]) / (along[j + 1] - along[j])
            return path[j, 0] + t * (path[j + 1, 0] - path[j, 0]), path[j, 1] + t * (path[j + 1, 1] - path[j, 1])
    return path[count - 1, 0], path[count - 1, 1]


@part
def to_go(path: Array, along: Array, count: int, leg: int, until: float, pull: float, x: float, y: float) -> float:
    """The way [m] from (x, y) to the end: to the path, weighted by `pull`, and along it.

    Legs from `leg` on are looked at that begin before `until` [m] along the path.
    """
    if count == 1:
        dx = path[0, 0] - x
        dy = path[0, 1] - y
        return math.sqrt(dx * dx + dy * dy)
    end = along[count - 1]
    best = math.inf
    for j in range(leg, count - 1):
        if j > leg and along[j] > until:
            break
        s, away = _on_leg(path, along, j, x, y)
        best = min(best, end - s + pull * away)
    return best
