"""Marks within reach of sensors, the nearest first; and discs that rays hit."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from amorsim.kernels.compile import kernel, part
from amorsim.kernels.kinematics.poses import wrap

__all__ = ["look_at_discs", "marks_near"]

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


@part
def _comes_after(a: int, b: int, mark: Ints, distance: Floats) -> bool:
    """Whether entry a is farther off than entry b, or as far and of a later mark."""
    farther: bool = distance[a] > distance[b]
    as_far_and_later: bool = distance[a] == distance[b] and mark[a] > mark[b]
    return farther or as_far_and_later


@part
def _swap(a: int, b: int, mark: Ints, distance: Floats, bearing: Floats) -> None:
    mark[a], mark[b] = mark[b], mark[a]
    distance[a], distance[b] = distance[b], distance[a]
    bearing[a], bearing[b] = bearing[b], bearing[a]


@part
def _sort(mark: Ints, distance: Floats, bearing: Floats) -> None:
    """Sort entries by distance, equally near ones by mark: a heap's sort, for in a crowd there are hundreds."""
    count = len(mark)
    begin = count // 2
    end = count
    while end > 1:
        if begin > 0:
            begin -= 1  # the heap is being made
        else:
            end -= 1
            _swap(0, end, mark, distance, bearing)
        top = begin
        while 2 * top + 1 < end:
            child = 2 * top + 1
            if child + 1 < end and _comes_after(child + 1, child, mark, distance):
                child += 1
            if not _comes_after(child, top, mark, distance):
                break
            _swap(child, top, mark, distance, bearing)
            top = child


@kernel
def marks_near(
    poses: Floats,
    range_max: Floats,
    half_angle: Floats,
    replica: Ints,
    own: Ints,
    places: Floats,
    carrier: Ints,
    first: Ints,
    mark: Ints,
    distance: Floats,
    bearing: Floats,
) -> int:
    """The number of pairs of a row and a mark within its reach.

    Parameters
    ----------
    poses
        The pose that each row looks from, (N, 3) x [m], y [m], heading [rad] in the world.
    range_max, half_angle
        How far [m], and how far to either side [rad], (N,).
    replica, own
        Of each row, and the body that it sits on, int64 (N,).
    places
        Of the marks in each replica [m], (R, F, 2).
    carrier
        The body that carries each mark in each replica, -1 for none, int64 (R, F).
    first
        Gets where the pairs of each row begin, and their number, int64 (N + 1,).
    mark, distance, bearing
        Get the pairs of row i as ``first[i]:first[i + 1]``, the nearest first and of equally near ones the first,
        if there is room for all: which mark, how far off [m], and in what direction from the heading [rad], (Q,).
    """
    found = 0
    room = mark.shape[0]
    for i in range(poses.shape[0]):
        first[i] = found
        r = replica[i]
        limit = range_max[i] * range_max[i]
        for f in range(places.shape[1]):
            if carrier[r, f] == own[i]:
                continue
            dx = places[r, f, 0] - poses[i, 0]
            dy = places[r, f, 1] - poses[i, 1]
            square = dx * dx + dy * dy
            if not square <= limit:
                continue
            angle = wrap(math.atan2(dy, dx) - poses[i, 2]) if square > 0.0 else 0.0
            if abs(angle) > half_angle[i]:
                continue
            if found < room:
                mark[found] = f
                distance[found] = math.sqrt(square)
                bearing[found] = angle
            found += 1
        if found <= room:
            _sort(mark[first[i] : found], distance[first[i] : found], bearing[first[i] : found])
    first[poses.shape[0]] = found
    return found


@kernel
def look_at_discs(
    poses: Floats,
    cos_b: Floats,
    sin_b: Floats,
    range_max: Floats,
    places: Floats,
    radius: Floats,
    first: int,
    ranges: Floats,
    things: Ints,
) -> None:
    """Lower the ranges of rays to where they meet discs, where these are nearer, and say which.

    Parameters
    ----------
    poses
        From where the rays of each row start, (N, 3); bearings are from their headings.
    cos_b, sin_b
        Of the beams' bearings, (N, k).
    range_max
        Beyond which nothing is seen [m], (N,).
    places, radius
        Of the discs [m], (F, 2) and (F,).
    first
        What is written for disc f is first + f.
    ranges, things
        In: what was met so far [m], inf for nothing; out: the nearer, (N, k).
    """
    for i in range(ranges.shape[0]):
        c = math.cos(poses[i, 2])
        s = math.sin(poses[i, 2])
        for f in range(radius.shape[0]):
            x = places[f, 0] - poses[i, 0]
            y = places[f, 1] - poses[i, 1]
            away = math.sqrt(x * x + y * y)
            if radius[f] <= 0.0 or away - radius[f] > range_max[i]:
                continue
            for j in range(ranges.shape[1]):
                dx = c * cos_b[i, j] - s * sin_b[i, j]
                dy = s * cos_b[i, j] + c * sin_b[i, j]
                along = dx * x + dy * y
                across = abs(dx * y - dy * x)
                distance = 0.0
                if away > radius[f]:
                    if along <= 0.0 or across > radius[f]:
                        continue
                    half_chord = math.sqrt((radius[f] - across) * (radius[f] + across))
                    distance = (away - radius[f]) * (away + radius[f]) / (along + half_chord)
                if distance <= range_max[i] and distance < ranges[i, j]:
                    ranges[i, j] = distance
                    things[i, j] = first + f
