"""Sound from one transducer to another: directly, or by reflection on a surface.

`amorsim.kernels.sensing.earshot` says which cones may carry a sound. Once their rays are cast, `sounds_in_order` finds
the sounds, the first to arrive first, `lay_lines` the straight lines that must be free for them to be heard, and
`take_free` takes the first whose line is.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from amorsim.array_types import Array, Bools, Ints
from amorsim.kernels.compile import kernel, part
from amorsim.kernels.sorting import sort

__all__ = [
    "DIRECT",
    "SLACK",
    "Emitters",
    "Facing",
    "Lines",
    "Listeners",
    "Sounds",
    "Surfaces",
    "lay_lines",
    "lines_wanted",
    "sounds_in_order",
    "take_free",
]


DIRECT = 0
"""Which of the ways from an emitter is the straight one; the others go by way of a ray's end, counted from 1."""

SLACK = 1e-6
"""Relative, on all that leaves a way out: many times the roundings on the way to it."""


class Listeners(NamedTuple):
    """Transducers that listen: k for each of N rows in turn, M in all."""

    poses: Array
    """(M, 3), in the world."""
    listens: Array
    """(N, k): when each begins to listen [s], from the tick on."""
    cones: Array
    """(N, 3): half the angle of a row's cones [rad], and the least and the most that they read [m], both included."""


class Emitters(NamedTuple):
    """Transducers that fire, e for each row; as `amorsim.contracts.Emissions` has them."""

    poses: Array
    """(N, e, 3), in the world."""
    half_angle: Array
    """(N, e), of their cones [rad]."""
    fired: Bools
    """(N, e)."""
    own: Bools
    """(N, e): whether they are the row's own, in the order of its listeners."""
    time: Array
    """(N, e): when they fire [s], from the tick on."""
    body: Ints
    """(N, e): the body that carries each."""


class Facing(NamedTuple):
    """The emitters that each listener can hear, and their distances; from `amorsim.kernels.sensing.earshot.face`."""

    axes: Array
    """(M, 3): cosine and sine of a listener's heading, and the cosine of half its cone's angle."""
    emitter_axes: Array
    """(N, e, 4): the same of the emitters, and the sine of half the angle."""
    hears: Bools
    """(M, e): which emitters a listener may hear."""
    nearest: Array
    """(M, f): along each ray of a cone, the least distance [m] of a surface that counts; inf if none does."""
    limit: Array
    """(M,): the largest such distance; below 0 of a cone without surfaces that count."""
    is_done: Bools
    """(M,): whether a listener has heard all there is to hear."""


class Surfaces(NamedTuple):
    """Where the rays of the listeners' cones end, f of each; of no use where ``Facing.limit`` is below 0."""

    bearings: Array
    """(1 or M, f): of the rays, from the listener's heading [rad]."""
    ranges: Array
    """(M, f) [m]; inf for nowhere."""
    thing: Ints
    """(M, f): the body hit; -1 for a wall or nothing."""
    owner: Ints
    """(B,): of each body, the body of the robot that it is a part of, or itself."""


class Sounds(NamedTuple):
    """The sounds that may reach listeners; those of listener m are from ``first[m]`` to ``first[m + 1]``, in order."""

    first: Ints
    """(M + 1,)"""
    reading: Array
    """(S,): half the way that sound could have gone since the listener began to listen [m]."""
    number: Ints
    """(S,): that of the emitter times (f + 1), plus that of the way."""


class Lines(NamedTuple):
    """P lines from where sounds came from to their emitters, in order of listener."""

    row: Ints
    """(P,): the row that hears it."""
    poses: Array
    """(P, 3): where each begins, looking along it."""
    ahead: Array
    """(P, 2): from there to the emitter [m]."""
    carrier: Ints
    """(P,): the body that carries the emitter."""


@part
def _is_within(dx: float, dy: float, way: float, cos: float, sin: float, edge: float) -> bool:
    """Whether the point (dx, dy) from a cone's tip, `way` away, is in the cone; the tip is."""
    return dx * cos + dy * sin >= way * edge


@part
def _end_of(listeners: Listeners, surfaces: Surfaces, m: int, f: int) -> tuple[float, float]:
    """Where ray f of a listener's cone ends."""
    reach = surfaces.ranges[m, f]
    angle = listeners.poses[m, 2] + surfaces.bearings[m if surfaces.bearings.shape[0] > 1 else 0, f]
    return listeners.poses[m, 0] + reach * math.cos(angle), listeners.poses[m, 1] + reach * math.sin(angle)


@kernel
def sounds_in_order(
    listeners: Listeners, emitters: Emitters, facing: Facing, surfaces: Surfaces, speed: float, sounds: Sounds
) -> int:
    """Find for each listener the sounds that may reach it, in order of arrival; returns their number S.

    A sound reads half the way that it could have gone since the listener began to listen. It goes straight from
    emitter to listener where each is in the other's cone, or by way of the end of one of the listener's rays that lies
    in the emitter's cone too, and not on the emitter's own robot. Whether anything is in between is not looked at here.
    If there is no room for all sounds, their number is right and nothing else is. `speed` is that of sound [m/s].
    """
    k = listeners.listens.shape[1]
    rays = surfaces.ranges.shape[1]
    room = sounds.reading.shape[0]
    end_x, end_y = np.empty(rays), np.empty(rays)
    readings = np.empty(rays)
    found = 0
    for m in range(listeners.poses.shape[0]):
        n = m // k
        sounds.first[m] = found
        if facing.is_done[m]:
            continue
        least, most = listeners.cones[n, 1], listeners.cones[n, 2]
        x, y = listeners.poses[m, 0], listeners.poses[m, 1]
        ear, looks = facing.axes[m], facing.limit[m] >= 0.0
        for f in range(rays if looks else 0):
            end_x[f], end_y[f] = math.nan, math.nan
            if facing.nearest[m, f] <= surfaces.ranges[m, f] < math.inf:
                end_x[f], end_y[f] = _end_of(listeners, surfaces, m, f)
        for i in range(emitters.poses.shape[1]):
            if not facing.hears[m, i]:
                continue
            ex, ey = emitters.poses[n, i, 0], emitters.poses[n, i, 1]
            axis = facing.emitter_axes[n, i]
            cos, sin, edge = axis[0], axis[1], axis[2]
            ahead = speed * (emitters.time[n, i] - listeners.listens[n, m - n * k])
            number = i * (rays + 1)
            across = math.sqrt((ex - x) ** 2 + (ey - y) ** 2)
            reading = 0.5 * (across + ahead)
            # No way is shorter than the straight one.
            if reading > most:
                continue
            if reading >= least:
                is_heard = _is_within(ex - x, ey - y, across, ear[0], ear[1], ear[2])
                if is_heard and _is_within(x - ex, y - ey, across, cos, sin, edge):
                    if found < room:
                        sounds.reading[found], sounds.number[found] = reading, number + DIRECT
                    found += 1
            if not looks:
                continue
            # All rays at once, in a loop without a branch.
            reach = surfaces.ranges[m]
            for f in range(rays):
                dx, dy = end_x[f] - ex, end_y[f] - ey
                last = math.sqrt(dx * dx + dy * dy)
                reading = 0.5 * (reach[f] + last + ahead)
                # As `_is_within` has it.
                counts = (dx * cos + dy * sin >= last * edge) & (reading >= least) & (reading <= most)
                readings[f] = reading if counts else math.inf
            for f in range(rays):
                if readings[f] < math.inf:
                    thing = surfaces.thing[m, f]
                    if thing >= 0 and surfaces.owner[thing] == emitters.body[n, i]:
                        continue
                    if found < room:
                        sounds.reading[found], sounds.number[found] = readings[f], number + f + 1
                    found += 1
        if found <= room:
            sort(sounds.reading[sounds.first[m] : found], sounds.number[sounds.first[m] : found])
    sounds.first[listeners.poses.shape[0]] = found
    return found


@kernel
def lines_wanted(sounds: Sounds, begin: Ints, batch: int, is_done: Bools) -> int:
    """The number P of lines for the next `batch` sounds of those that are not done.

    `begin` (M,) is the first of these sounds. Listeners that have none left are done from now on.
    """
    count = 0
    for m in range(begin.shape[0]):
        left = sounds.first[m + 1] - begin[m]
        if left <= 0:
            is_done[m] = True
        if not is_done[m]:
            count += min(left, batch)
    return count


@kernel
def lay_lines(
    listeners: Listeners,
    emitters: Emitters,
    facing: Facing,
    surfaces: Surfaces,
    sounds: Sounds,
    begin: Ints,
    batch: int,
    off: float,
    lines: Lines,
) -> None:
    """Lay the lines from where sounds came from to their emitters, in order of listener and sound.

    They are the next `batch` sounds of each listener that is not done, from number `begin` (M,) on. A line begins so
    far `off` [m] the surface, towards the listener: one that starts within a cell that is occupied meets it at once.
    """
    k = listeners.listens.shape[1]
    ways = surfaces.ranges.shape[1] + 1
    at = 0
    for m in range(listeners.poses.shape[0]):
        if facing.is_done[m]:
            continue
        n = m // k
        x, y = listeners.poses[m, 0], listeners.poses[m, 1]
        for s in range(begin[m], min(begin[m] + batch, sounds.first[m + 1])):
            i, way_of = divmod(sounds.number[s], ways)
            px, py = x, y
            if way_of != DIRECT:
                px, py = _end_of(listeners, surfaces, m, way_of - 1)
            back_x, back_y = x - px, y - py
            way = math.sqrt(back_x * back_x + back_y * back_y)
            part_of = min(off / (way if way > 0.0 else 1.0), 1.0)
            px, py = px + back_x * part_of, py + back_y * part_of
            lines.row[at] = n
            ahead_x, ahead_y = emitters.poses[n, i, 0] - px, emitters.poses[n, i, 1] - py
            lines.poses[at, 0], lines.poses[at, 1], lines.poses[at, 2] = px, py, math.atan2(ahead_y, ahead_x)
            lines.ahead[at, 0], lines.ahead[at, 1] = ahead_x, ahead_y
            lines.carrier[at] = emitters.body[n, i]
            at += 1


@kernel
def take_free(sounds: Sounds, begin: Ints, batch: int, is_free: Bools, is_done: Bools, heard: Array) -> None:
    """Let each listener hear the first of its next `batch` sounds whose line is free; count them in `begin` (M,).

    `is_free` (P,) says which lines are. `heard` (N, k) [m] gets the reading. Listeners that heard a sound are done.
    """
    k = heard.shape[1]
    at = 0
    for m in range(begin.shape[0]):
        if is_done[m]:
            continue
        end = min(begin[m] + batch, sounds.first[m + 1])
        for s in range(begin[m], end):
            if is_free[at] and not is_done[m]:
                heard[m // k, m % k] = sounds.reading[s]
                is_done[m] = True
            at += 1
        begin[m] = end
