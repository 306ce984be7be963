"""Sound that one transducer sends and another hears: straight across, or by way of a surface.

`amorsim.kernels.sensing.earshot` says which rays of a listener's cone may carry a sound. Once they are cast,
`first_sounds` finds the sounds that come first, `lay_lines` the straight lines that must be free for them to be heard,
and `take_free` takes the first whose line is.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from amorsim.kernels.compile import kernel, part

__all__ = [
    "DIRECT",
    "SLACK",
    "Emitters",
    "Facing",
    "Lines",
    "Listeners",
    "Sounds",
    "Surfaces",
    "first_sounds",
    "lay_lines",
    "looks_of",
    "take_free",
]

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]
Bools = npt.NDArray[np.bool_]

DIRECT = 0
"""Which of the ways from an emitter is the straight one; the others go by way of a ray's end, counted from 1."""

SLACK = 1e-6
"""Relative, on all that leaves a way out: many times the roundings on the way to it."""


class Listeners(NamedTuple):
    """Transducers that listen: k for each of N rows in turn, M in all."""

    poses: Floats
    """(M, 3), in the world."""
    listens: Floats
    """(N, k): when each begins to listen [s], from the tick on."""
    cones: Floats
    """(N, 3): half the angle of a row's cones [rad], and the least and the most that they read [m], both included."""


class Emitters(NamedTuple):
    """Transducers that fire, e for each row; as `amorsim.contracts.Emissions` has them."""

    poses: Floats
    """(N, e, 3), in the world."""
    half_angle: Floats
    """(N, e), of their cones [rad]."""
    fired: Bools
    """(N, e)."""
    own: Bools
    """(N, e): whether they are the row's own, in the order of its listeners."""
    time: Floats
    """(N, e): when they fire [s], from the tick on."""
    body: Ints
    """(N, e): the body that carries each."""


class Facing(NamedTuple):
    """Which emitters each listener can hear, and by which rays; from `amorsim.kernels.sensing.earshot.face`."""

    axes: Floats
    """(M, 3): cosine and sine of a listener's heading, and the cosine of half its cone's angle."""
    emitter_axes: Floats
    """(N, e, 4): the same of the emitters, and the sine of half the angle."""
    hears: Bools
    """(M, e): which emitters a listener may hear."""
    limit: Floats
    """(N, 1): the largest distance [m] of a surface from which a row can hear anything."""
    rays: Ints
    """(M, f): the rays of a listener's fan that may carry a sound, in order, then -1."""
    is_done: Bools
    """(M,): whether a listener has heard all there is to hear."""


class Surfaces(NamedTuple):
    """Where the rays of `Facing.rays` end, c of each look; a row has as many looks as the one that needs most."""

    poses: Floats
    """(N * l, 3): where looks are from and to."""
    bearings: Floats
    """(N * l, c): of the rays, from the look's heading [rad]."""
    ranges: Floats
    """(N * l, c) [m]; inf for nowhere."""
    owner: Ints
    """(N * l, c): the body hit, for a robot's part the body of its robot; -1 for a wall or nothing."""


class Sounds(NamedTuple):
    """Sounds that each listener hears next, b of them in order."""

    reading: Floats
    """(M, b): half the way that sound could have gone since the listener began to listen [m]; inf for no more."""
    number: Ints
    """(M, b): that of the emitter times (f + 1), plus that of the way; -1 for no more."""
    place: Floats
    """(M, b, 2): where the last straight part of the way ended [m]: the listener, or a ray's end."""


class Lines(NamedTuple):
    """Lines from where sounds came from to their emitters: p for each row in turn."""

    poses: Floats
    """(N * p, 3): where each begins; the heading is to be filled in."""
    ahead: Floats
    """(N * p, 2): from there to the emitter [m]."""
    carrier: Ints
    """(N * p,): the body that carries the emitter."""


@part
def looks_of(rays: Ints, together: int) -> int:
    """The number of looks of `together` rays that a listener takes."""
    count = 0
    while count < rays.shape[0] and rays[count] >= 0:
        count += together
    return count // together


@part
def _is_within(dx: float, dy: float, way: float, cos: float, sin: float, edge: float) -> bool:
    """Whether what lies (dx, dy) from a cone's tip, `way` off, is in the cone; the tip is."""
    return dx * cos + dy * sin >= way * edge


@part
def _could_count(reach: float, across: float, ahead: float, least: float, most: float) -> bool:
    """Whether a way by a point `reach` [m] away may be heard, where the straight one is `across` [m]."""
    slack = SLACK * (1.0 + reach + across + abs(ahead))
    shortest, longest = reach + abs(reach - across), 2.0 * reach + across
    return 0.5 * (longest + ahead) + slack >= least and 0.5 * (shortest + ahead) - slack <= most


@part
def _insert(reading: float, number: int, x: float, y: float, readings: Floats, numbers: Ints, places: Floats) -> None:
    """Put a sound where it belongs in order; of equal readings, by its number."""
    b = readings.shape[0]
    while b > 0 and reading < readings[b - 1]:
        b -= 1
    if b == readings.shape[0]:
        return
    for c in range(readings.shape[0] - 1, b, -1):
        readings[c], numbers[c] = readings[c - 1], numbers[c - 1]
        places[c, 0], places[c, 1] = places[c - 1, 0], places[c - 1, 1]
    readings[b], numbers[b] = reading, number
    places[b, 0], places[b, 1] = x, y


@kernel
def first_sounds(
    listeners: Listeners,
    emitters: Emitters,
    facing: Facing,
    surfaces: Surfaces,
    speed: float,
    after: Floats,
    after_number: Ints,
    sounds: Sounds,
) -> int:
    """Find for each listener that is not done the sounds that come first after a given one; the most of any row.

    A sound reads half the way that it could have gone since the listener began to listen. It goes straight from
    emitter to listener where each is in the other's cone, or by way of the end of one of the listener's rays that lies
    in the emitter's cone too, and not on the emitter's own robot. Whether anything is in between is not looked at here.

    Parameters
    ----------
    speed
        Of sound [m/s].
    after, after_number
        (M,): the reading [m] and number of the last sound that is known; -inf and -1 for none.
    """
    rows, k = listeners.listens.shape
    ways, batch = facing.rays.shape[1] + 1, sounds.reading.shape[1]
    together = surfaces.ranges.shape[1]
    looks = surfaces.ranges.shape[0] // rows
    ranges, owner, bearings = surfaces.ranges.reshape(-1), surfaces.owner.reshape(-1), surfaces.bearings.reshape(-1)
    ends = np.empty((ways - 1, 2))
    most_lines = 0
    for n in range(rows):
        least, most = listeners.cones[n, 1], listeners.cones[n, 2]
        found = 0
        look = n * looks
        for m in range(n * k, n * k + k):
            first = look * together
            look += looks_of(facing.rays[m], together)
            readings, numbers, places = sounds.reading[m], sounds.number[m], sounds.place[m]
            readings[:] = math.inf
            numbers[:] = -1
            if facing.is_done[m]:
                continue
            ends[:, 0] = math.nan
            x, y, heading = listeners.poses[m, 0], listeners.poses[m, 1], listeners.poses[m, 2]
            ear = facing.axes[m]
            for i in range(emitters.poses.shape[1]):
                if not facing.hears[m, i]:
                    continue
                ex, ey = emitters.poses[n, i, 0], emitters.poses[n, i, 1]
                axis = facing.emitter_axes[n, i]
                across = math.sqrt((ex - x) ** 2 + (ey - y) ** 2)
                ahead = speed * (emitters.time[n, i] - listeners.listens[n, m - n * k])
                # No way is shorter than the straight one.
                if 0.5 * (across + ahead) > min(readings[batch - 1], most):
                    continue
                for c in range(-1, ways - 1):
                    number = i * ways + DIRECT
                    way, px, py = across, x, y
                    if c < 0:
                        if not _is_within(ex - x, ey - y, across, ear[0], ear[1], ear[2]):
                            continue
                        if not _is_within(x - ex, y - ey, across, axis[0], axis[1], axis[2]):
                            continue
                    else:
                        if facing.rays[m, c] < 0:
                            break
                        reach = ranges[first + c]
                        if not math.isfinite(reach) or owner[first + c] == emitters.body[n, i]:
                            continue
                        if not _could_count(reach, across, ahead, least, min(readings[batch - 1], most)):
                            continue
                        if ends[c, 0] != ends[c, 0]:
                            angle = heading + bearings[first + c]
                            ends[c, 0] = x + reach * math.cos(angle)
                            ends[c, 1] = y + reach * math.sin(angle)
                        px, py = ends[c, 0], ends[c, 1]
                        dx, dy = px - ex, py - ey
                        last = math.sqrt(dx * dx + dy * dy)
                        if not _is_within(dx, dy, last, axis[0], axis[1], axis[2]):
                            continue
                        way = reach + last
                        number += facing.rays[m, c] + 1
                    reading = 0.5 * (way + ahead)
                    if not least <= reading <= most:
                        continue
                    if reading < after[m] or (reading == after[m] and number <= after_number[m]):
                        continue
                    _insert(reading, number, px, py, readings, numbers, places)
            for b in range(batch):
                found += 1 if numbers[b] >= 0 else 0
        most_lines = max(most_lines, found)
    return most_lines


@kernel
def lay_lines(
    listeners: Listeners, emitters: Emitters, facing: Facing, sounds: Sounds, off: float, lines: Lines
) -> None:
    """Lay the lines from where sounds came from to their emitters, each row's in order of listener and sound.

    A line begins so far `off` [m] the surface, towards the listener: one that starts within a cell that is occupied
    meets it at once. Rows with fewer sounds get lines of no length besides.
    """
    rows, k = listeners.listens.shape
    ways = facing.rays.shape[1] + 1
    each = lines.poses.shape[0] // rows
    for n in range(rows):
        at = n * each
        for m in range(n * k, n * k + k):
            x, y = listeners.poses[m, 0], listeners.poses[m, 1]
            for b in range(sounds.reading.shape[1]):
                number = sounds.number[m, b]
                if number < 0:
                    break
                i = number // ways
                px, py = sounds.place[m, b, 0], sounds.place[m, b, 1]
                back_x, back_y = x - px, y - py
                way = math.sqrt(back_x * back_x + back_y * back_y)
                part_of = min(off / (way if way > 0.0 else 1.0), 1.0)
                px, py = px + back_x * part_of, py + back_y * part_of
                lines.poses[at, 0], lines.poses[at, 1] = px, py
                lines.ahead[at, 0] = emitters.poses[n, i, 0] - px
                lines.ahead[at, 1] = emitters.poses[n, i, 1] - py
                lines.carrier[at] = emitters.body[n, i]
                at += 1
        for rest in range(at, n * each + each):
            lines.poses[rest, 0], lines.poses[rest, 1] = listeners.poses[n * k, 0], listeners.poses[n * k, 1]
            lines.ahead[rest] = 0.0
            lines.carrier[rest] = -1


@kernel
def take_free(
    sounds: Sounds,
    lines: Lines,
    reach: Floats,
    met: Ints,
    is_done: Bools,
    heard: Floats,
    after: Floats,
    after_number: Ints,
) -> bool:
    """Let each listener hear the first of its sounds whose line is free; returns whether any may have more to come.

    `reach` (N * p, 1) is how far [m] the lines are free, `met` (N * p, 1) the body that ends them, -1 for none. A line
    is free if it hits nothing, or the emitter's carrier. Bodies are compared by number, not by place: an emitter at the
    rim of its carrier is as far away as the rim, up to rounding. `heard` (N, k) [m] gets the reading. Listeners that
    heard a sound, or have none left, are done; for the others, `after` and `after_number` say where to continue.
    """
    rows, k = heard.shape
    each = lines.poses.shape[0] // rows
    batch = sounds.reading.shape[1]
    some_left = False
    for n in range(rows):
        at = n * each
        for j in range(k):
            m = n * k + j
            if is_done[m]:
                continue
            for b in range(batch):
                if sounds.number[m, b] < 0:
                    is_done[m] = True
                    break
                x, y = lines.ahead[at, 0], lines.ahead[at, 1]
                free = reach[at, 0] >= math.sqrt(x * x + y * y) or met[at, 0] == lines.carrier[at]
                at += 1
                if free and not is_done[m]:
                    heard[n, j] = sounds.reading[m, b]
                    is_done[m] = True
            if not is_done[m]:
                after[m], after_number[m] = sounds.reading[m, batch - 1], sounds.number[m, batch - 1]
                some_left = True
    return some_left
