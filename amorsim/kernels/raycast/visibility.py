"""Marks within reach of sensors, the nearest first; and discs that rays hit."""

from __future__ import annotations

import math

from amorsim.array_types import Array, Ints
from amorsim.kernels.compile import kernel, part
from amorsim.kernels.kinematics.poses import wrap
from amorsim.kernels.sorting import sort

__all__ = ["lines_to_marks", "look_at_discs", "marks_near", "take_marks"]


@part
def _bearing(dx: float, dy: float, heading: float) -> float:
    """The direction [rad], from a heading, of what is (dx, dy) away; 0 if it is here."""
    return wrap(math.atan2(dy, dx) - heading) if dx * dx + dy * dy > 0.0 else 0.0


@kernel
def marks_near(
    poses: Array,
    range_max: Array,
    half_angle: Array,
    replica: Ints,
    own: Ints,
    places: Array,
    carrier: Ints,
    first: Ints,
    mark: Ints,
    distance: Array,
    bearing: Array,
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
            if abs(_bearing(dx, dy, poses[i, 2])) > half_angle[i]:
                continue
            if found < room:
                mark[found] = f
                distance[found] = math.sqrt(square)
            found += 1
        if found <= room:
            sort(distance[first[i] : found], mark[first[i] : found])
            for q in range(first[i], found):
                dx = places[r, mark[q], 0] - poses[i, 0]
                dy = places[r, mark[q], 1] - poses[i, 1]
                bearing[q] = _bearing(dx, dy, poses[i, 2])
    first[poses.shape[0]] = found
    return found


@kernel
def lines_to_marks(
    poses: Array,
    replica: Ints,
    own: Ints,
    places: Array,
    radius: Array,
    first: Ints,
    mark: Ints,
    distance: Array,
    done: int,
    most: int,
    room: Ints,
    pair: Ints,
    looker: Ints,
    lines: Array,
    need: Array,
) -> int:
    """The lines of sight that are to be tested next, of the nearest marks not yet tested; returns their number.

    Parameters
    ----------
    poses, replica, own, places, first, mark, distance
        As `marks_near` takes and gives them.
    radius
        Of the first of the marks, which none carries [m].
    done, most
        How many pairs of each row have been tested, and how many more are.
    room
        Slots that are left in each row, (N,); a row without any is passed over.
    pair
        Gets the pair of each line, (L,).
    looker
        Gets the body that it starts from, (L,).
    lines
        Gets where it starts, and its direction, (L, 3).
    need
        Gets how far it must be free [m], (L,): a mark on a wall is in sight if the line reaches its disc.
    """
    count = 0
    for i in range(poses.shape[0]):
        if room[i] <= 0:
            continue
        for q in range(first[i] + done, min(first[i] + done + most, first[i + 1])):
            f = mark[q]
            place = places[replica[i], f]
            pair[count] = q
            looker[count] = own[i]
            lines[count, 0] = poses[i, 0]
            lines[count, 1] = poses[i, 1]
            lines[count, 2] = math.atan2(place[1] - poses[i, 1], place[0] - poses[i, 0])
            need[count] = distance[q] - radius[f] if f < radius.shape[0] else distance[q]
            count += 1
    return count


@kernel
def take_marks(
    first: Ints,
    mark: Ints,
    distance: Array,
    bearing: Array,
    replica: Ints,
    carrier: Ints,
    ids: Ints,
    pair: Ints,
    need: Array,
    free: Array,
    met: Ints,
    room: Ints,
    range_out: Array,
    bearing_out: Array,
    id_out: Ints,
) -> None:
    """Put marks whose lines of sight are free into the slots that are left.

    Parameters
    ----------
    first, mark, distance, bearing, replica, carrier
        As `marks_near` takes and gives them.
    ids
        Of the marks.
    pair, need, room
        As `lines_to_marks` gives them.
    free, met
        How far each line is free [m], and the body that it meets or -1, (L, 1).
    range_out, bearing_out, id_out
        The slots of each row, (N, m).
    """
    i = 0
    slots = range_out.shape[1]
    for k in range(pair.shape[0]):
        q = pair[k]
        while q >= first[i + 1]:
            i += 1
        body = carrier[replica[i], mark[q]]
        if room[i] > 0 and (free[k, 0] >= need[k] or (body >= 0 and met[k, 0] == body)):
            slot = slots - room[i]
            range_out[i, slot] = distance[q]
            bearing_out[i, slot] = bearing[q]
            id_out[i, slot] = ids[mark[q]]
            room[i] -= 1


@kernel
def look_at_discs(
    poses: Array,
    cos_b: Array,
    sin_b: Array,
    range_max: Array,
    places: Array,
    radius: Array,
    first: int,
    ranges: Array,
    things: Ints,
) -> None:
    """Lower the ranges of rays to the discs that they meet sooner, and write which.

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
