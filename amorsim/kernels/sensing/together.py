"""A step of sensing for devices of the common kinds: where they look from, and what their noise makes of what they see.

All devices of a group are done one after the other, and what they read lies in one array: device by device, and of each
the values of row 0 first. The arithmetic is that of the components by themselves, in the same order, so the bits are
the same (`amorsim.simulation.sensing.plan` tells which components have a twin here).
"""

from __future__ import annotations

import itertools
import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from amorsim.kernels.compile import kernel, part
from amorsim.kernels.grid.grid import Grid
from amorsim.kernels.grid.segments import SegmentIndex
from amorsim.kernels.kinematics.poses import displaced, wrap
from amorsim.kernels.random.normals import normals
from amorsim.kernels.random.philox import pairs
from amorsim.kernels.raycast.cone_walls import AT_ONCE, ROOM
from amorsim.kernels.raycast.cones import hear
from amorsim.kernels.raycast.rays import to_frame
from amorsim.kernels.raycast.scans import FINE, ROOM_F, ROOM_Q, ROOM_RINGS, cast_scan

__all__ = [
    "BIAS",
    "COMPASS",
    "ENCODER",
    "FLOOR",
    "GAUSSIAN",
    "GYRO",
    "LASER",
    "LIMITS",
    "NEAREST",
    "SCALE",
    "SECTORS",
    "SIZES",
    "SONAR",
    "TABLE_COLUMNS",
    "Layout",
    "Plan",
    "lay",
    "sense",
]

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

# Kinds of devices.
ENCODER, COMPASS, GYRO, LASER, SONAR = range(5)
# Kinds of elements of a chain: Gaussian noise, a constant, a factor, whole steps.
GAUSSIAN, BIAS, SCALE, NEAREST, FLOOR = range(5)

# Columns of the table of devices: its kind; how many values it has; how many there are of the devices before it, how
# many elements of rings, and how many places that are looked from; its first element in the chains, and one past its
# last; where its beams begin, how many they are, filled up to whole lanes, and where their sectors begin.
_KIND, _SIZE, _VALUES, _RING, _PLACES, _FIRST, _LAST, _BEAMS, _RAYS, _SECTORS = range(10)
TABLE_COLUMNS = 10
SECTORS = int(4.0 * FINE)

# Where in the head of a laid plan it says where each part of it begins, and after it that it ends.
_TABLE, _ORDER, _STARTS, _CHAINS, _KEYS, SIZES = range(6)
_MOUNTS, _NUMBERS, _RINGS, LIMITS, _HALF_ANGLES, _EDGES, _COSINES, _SINES, _PARAMETERS = range(7, 16)
_HEAD = 17

# Where in the room of a scan or a ring of cones its parts begin: those of `scans`, of `cone_walls`, and then what is as
# long as there are walls; a scan needs less than one of these for its blocks.
_ROOM_Q_AT = ROOM_F
_ROOM_NEAR_AT = _ROOM_Q_AT + ROOM_Q
_ROOM_RINGS_AT = _ROOM_NEAR_AT + ROOM
_ROOM_WALLS_AT = _ROOM_RINGS_AT + ROOM_RINGS

_TURN = 2.0 * math.pi


class Plan(NamedTuple):
    """What is known of a group's devices before they read."""

    table: Ints
    """(D, TABLE_COLUMNS), of the devices."""
    order: Ints
    """Of the finders' beams, as `starts`, `cosines` and `sines`: one device after another, a scanner's sorted as
    `scans.sorted_beams` does."""
    starts: Ints
    """Of each scanner `SECTORS` and one."""
    chains: Ints
    """(C,): the kinds of the elements of all chains."""
    keys: NDArray[np.uint64]
    """(C, N): the keys of their draws."""
    sizes: Ints
    """(D,): how many values each device has."""
    mounts: Floats
    """(D, N, 3): where each sits on its body."""
    numbers: Floats
    """(D, N, m): counts in a turn of each joint of an encoder, and first the least range of a sonar."""
    rings: Floats
    """(E * N, 3): where the elements of rings sit on their mounts."""
    limits: Floats
    """(L * N,): the longest range seen from each place."""
    half_angles: Floats
    """(D,): of a sonar's cones."""
    edges: Floats
    """(D, 2): the cosine and sine of that."""
    cosines: Floats
    sines: Floats
    parameters: Floats
    """(C, N, 2): of the elements of all chains."""


class Layout(NamedTuple):
    """What lasts from step to step: the map, and a plan of devices."""

    grid: Grid
    segment_index: SegmentIndex
    origin_x: float
    """Where the grid lies in the world, with `origin_y` [m] and `yaw` [rad]."""
    origin_y: float
    yaw: float
    ints: Ints
    """The plan, with `floats`, as `lay` lays it."""
    floats: Floats
    places: Floats
    """(L * N, 3): where range finders look from, poses in the world; written in each step."""


def lay(plan: Plan) -> tuple[Ints, Floats]:
    """A plan in two arrays, which are handed over sooner than fifteen: its whole numbers, and the others.

    A part of it is ``ints[ints[PART] : ints[PART + 1]]``, or the same of the others.
    """
    whole: list[Any] = [*plan[:_KEYS], plan.keys.view(np.int64), plan.sizes]
    others: tuple[Any, ...] = plan[SIZES + 1 :]
    ends = [
        *itertools.accumulate((each.size for each in whole), initial=_HEAD),
        *itertools.accumulate((each.size for each in others), initial=0),
    ]
    head = np.array(ends, dtype=np.int64)
    return np.concatenate([head, *map(np.ravel, whole)]), np.concatenate([np.ravel(each) for each in others])


@part
def _place(
    table: Ints, d: int, i: int, rows: int, mounts: Floats, ring: Floats, body: Floats, places: Floats
) -> tuple[int, int]:
    """Write where range finder `d` of row `i` looks from; which of the places that is, and how many."""
    k = 1 if table[d, _KIND] == LASER else table[d, _SIZE]
    x, y, heading = displaced(body[0], body[1], body[2], mounts[d, i, 0], mounts[d, i, 1], mounts[d, i, 2])
    at = table[d, _PLACES] * rows + i * k
    if table[d, _KIND] == LASER:
        places[at, 0] = x
        places[at, 1] = y
        places[at, 2] = heading
        return at, k
    c = math.cos(heading)
    s = math.sin(heading)
    first = table[d, _RING] * rows + i * k
    for j in range(k):
        on_x = ring[first + j, 0]
        on_y = ring[first + j, 1]
        places[at + j, 0] = x + (c * on_x - s * on_y)
        places[at + j, 1] = y + (s * on_x + c * on_y)
        places[at + j, 2] = wrap(heading + ring[first + j, 2])
    return at, k


@part
def _look_rows(
    grid: Grid,
    lines: SegmentIndex,
    origin_x: float,
    origin_y: float,
    yaw: float,
    ints: Ints,
    floats: Floats,
    body: Floats,
    first: int,
    end: int,
    places: Floats,
    true: Floats,
    room: Floats,
    whole: Ints,
) -> None:
    """What `sense` does to see; `room` to work in is one array, and `whole` the same seen as whole numbers."""
    most = lines.walls.shape[1]
    f = room[:_ROOM_Q_AT]
    q = whole[_ROOM_Q_AT:_ROOM_NEAR_AT]
    near = room[_ROOM_NEAR_AT:_ROOM_RINGS_AT]
    near_bits = whole[_ROOM_NEAR_AT:_ROOM_RINGS_AT]
    rings = whole[_ROOM_RINGS_AT:_ROOM_WALLS_AT]
    found = whole[_ROOM_WALLS_AT : _ROOM_WALLS_AT + most]
    candidates = whole[_ROOM_WALLS_AT + most : _ROOM_WALLS_AT + 2 * most]
    away = room[_ROOM_WALLS_AT + 2 * most : _ROOM_WALLS_AT + 3 * most]
    rest = _ROOM_WALLS_AT + 9 * most + 6 * AT_ONCE
    about = room[_ROOM_WALLS_AT + 3 * most : rest].reshape((6, most + AT_ONCE))
    nearness = room[rest:]
    rows = body.shape[0]
    table = ints[ints[_TABLE] : ints[_TABLE + 1]].reshape((-1, TABLE_COLUMNS))
    order = ints[ints[_ORDER] : ints[_ORDER + 1]]
    starts = ints[ints[_STARTS] : ints[_STARTS + 1]]
    mounts = floats[ints[_MOUNTS] : ints[_MOUNTS + 1]].reshape((-1, rows, 3))
    ring = floats[ints[_RINGS] : ints[_RINGS + 1]].reshape((-1, 3))
    limits = floats[ints[LIMITS] : ints[LIMITS + 1]]
    half_angles = floats[ints[_HALF_ANGLES] : ints[_HALF_ANGLES + 1]]
    edges = floats[ints[_EDGES] : ints[_EDGES + 1]].reshape((-1, 2))
    cos_b = floats[ints[_COSINES] : ints[_COSINES + 1]]
    sin_b = floats[ints[_SINES] : ints[_SINES + 1]]
    cos_yaw = math.cos(yaw)
    sin_yaw = math.sin(yaw)
    for d in range(table.shape[0]):
        if table[d, _KIND] < LASER:
            continue
        size = table[d, _SIZE]
        rays = table[d, _RAYS]
        beams = table[d, _BEAMS]
        sectors = table[d, _SECTORS]
        for i in range(first, end):
            at, k = _place(table, d, i, rows, mounts, ring, body[i], places)
            out = table[d, _VALUES] * rows + i * size
            if table[d, _KIND] == SONAR:
                hear(
                    grid,
                    lines,
                    origin_x,
                    origin_y,
                    yaw,
                    places[at : at + k],
                    half_angles[d],
                    cos_b[beams : beams + rays].reshape((1, rays)),
                    sin_b[beams : beams + rays].reshape((1, rays)),
                    limits[at : at + k],
                    edges[d],
                    found,
                    candidates,
                    about,
                    away,
                    rings,
                    near,
                    near_bits,
                    true[out : out + size],
                )
                continue
            x, y = to_frame(places[at, 0], places[at, 1], origin_x, origin_y, cos_yaw, sin_yaw)
            cast_scan(
                grid,
                lines,
                x,
                y,
                places[at, 2] - yaw,
                limits[at],
                cos_b[beams : beams + rays],
                sin_b[beams : beams + rays],
                order[beams : beams + rays],
                starts[sectors : sectors + SECTORS + 1],
                FINE,
                found,
                away,
                rings,
                nearness[:rays],
                f,
                q,
                true[out : out + size],
            )


@part
def _sense(
    kind: int, mount: Floats, number: Floats, body: Floats, twist: Floats, joints: Floats, values: Floats
) -> None:
    """Write what an ideal device of a row reads; of range finders it is there already."""
    if kind == ENCODER:
        for j in range(len(values)):
            values[j] = joints[j] / _TURN * number[j]
    elif kind == COMPASS:
        _, _, heading = displaced(body[0], body[1], body[2], mount[0], mount[1], mount[2])
        values[0] = wrap(heading)
    elif kind == GYRO:
        values[0] = twist[2]
    elif kind == SONAR:
        for j in range(len(values)):
            # Nothing nearer than what a transducer can tell; nan stays.
            if values[j] < number[0]:
                values[j] = number[0]


@part
def _noisy(value: float, part: Floats, noise: float) -> float:
    deviation = part[0] + part[1] * abs(value)
    return value + deviation * noise if (deviation > 0.0) & (abs(value) < np.inf) else value


@part
def _scatter(
    key: np.uint64,
    counter: NDArray[np.uint32],
    row: int,
    part: Floats,
    values: Floats,
    drawn: Floats,
    drawn_bits: Ints,
) -> None:
    """Put Gaussian noise on values, as `philox.fill_normal` and `readings.scatter` do one after the other.

    `drawn` (3, h) is room to work in for h pairs of values or fewer, and `drawn_bits` the same seen as whole numbers.
    """
    half = (len(values) + 1) // 2
    first = drawn[0, :half]
    second = drawn[1, :half]
    pairs(key, counter, row, 0, first, second)
    normals(first, second, drawn_bits[0, :half], drawn[2, :half])
    for b in range(len(values) // 2):
        values[2 * b] = _noisy(values[2 * b], part, first[b])
        values[2 * b + 1] = _noisy(values[2 * b + 1], part, second[b])
    if len(values) % 2:
        values[-1] = _noisy(values[-1], part, first[-1])


@part
def _read_rows(
    ints: Ints,
    floats: Floats,
    counter: NDArray[np.uint32],
    body: Floats,
    twist: Floats,
    joints: Floats,
    first: int,
    end: int,
    true: Floats,
    measured: Floats,
    room: Floats,
    whole: Ints,
    half: int,
) -> None:
    """What `sense` does to read; `room`, which is also `whole`, is for the draws of `half` pairs of values or fewer."""
    drawn = room[: 3 * half].reshape((3, half))
    drawn_bits = whole[: 3 * half].reshape((3, half))
    rows = body.shape[0]
    table = ints[ints[_TABLE] : ints[_TABLE + 1]].reshape((-1, TABLE_COLUMNS))
    devices = table.shape[0]
    chains = ints[ints[_CHAINS] : ints[_CHAINS + 1]]
    keys = ints[ints[_KEYS] : ints[_KEYS + 1]].reshape((-1, rows))
    mounts = floats[ints[_MOUNTS] : ints[_MOUNTS + 1]].reshape((-1, rows, 3))
    numbers = floats[ints[_NUMBERS] : ints[_NUMBERS + 1]]
    numbers_of = numbers.reshape((devices, rows, len(numbers) // max(1, devices * rows)))
    parts = floats[ints[_PARAMETERS] : ints[_PARAMETERS + 1]].reshape((-1, rows, 2))
    for d in range(devices):
        k = table[d, _SIZE]
        for i in range(first, end):
            at = table[d, _VALUES] * rows + i * k
            ideal = true[at : at + k]
            values = measured[at : at + k]
            _sense(table[d, _KIND], mounts[d, i], numbers_of[d, i], body[i], twist[i], joints[i], ideal)
            for j in range(k):
                values[j] = ideal[j]
            for c in range(table[d, _FIRST], table[d, _LAST]):
                number = parts[c, i, 0]
                if chains[c] == GAUSSIAN:
                    _scatter(np.uint64(keys[c, i]), counter, i, parts[c, i], values, drawn, drawn_bits)
                elif chains[c] == BIAS:
                    for j in range(k):
                        values[j] = values[j] - (0.0 - number)
                elif chains[c] == SCALE:
                    for j in range(k):
                        values[j] = values[j] * number
                elif chains[c] == NEAREST:
                    for j in range(k):
                        values[j] = np.rint(values[j] / number) * number
                else:
                    for j in range(k):
                        values[j] = np.floor(values[j] / number) * number


@kernel
def sense(
    first: int,
    end: int,
    looks: bool,
    reads: bool,
    body: Floats,
    twist: Floats,
    joints: Floats,
    layout: Layout,
    counter: NDArray[np.uint32],
    true: Floats,
    measured: Floats,
) -> None:
    """Let the devices of rows first..end-1 look about, if it `looks`, and then read, if it `reads`.

    Parameters
    ----------
    first, end
        The rows that are worked on.
    body, twist, joints
        True poses (N, 3), velocities (N, 3) and joints (N, j).
    layout
        The map and the devices.
    counter
        (N, 3): replica, episode and tick of each row.
    true, measured
        (V * N,), get what the devices truly and really read.
    """
    ints = layout.ints
    most_rays = 1
    most_values = 0
    for at in range(ints[_TABLE], ints[_TABLE + 1], TABLE_COLUMNS):
        most_rays = max(most_rays, ints[at + _RAYS])
        most_values = max(most_values, ints[at + _SIZE])
    # One array for all there is to work in, for each takes 0.1 us to be made.
    half = (most_values + 1) // 2
    walls = layout.segment_index.walls.shape[1]
    room = np.empty(max(3 * half, _ROOM_WALLS_AT + 9 * walls + 6 * AT_ONCE + most_rays if looks else 0))
    whole = room.view(np.int64)
    if looks:
        _look_rows(
            layout.grid,
            layout.segment_index,
            layout.origin_x,
            layout.origin_y,
            layout.yaw,
            ints,
            layout.floats,
            body,
            first,
            end,
            layout.places,
            true,
            room,
            whole,
        )
    if reads:
        _read_rows(ints, layout.floats, counter, body, twist, joints, first, end, true, measured, room, whole, half)
