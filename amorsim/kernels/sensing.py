"""A step of sensing for devices of the common kinds: where they look from, and what their noise makes of what they see.

All devices of a group are done in one call each, and what they read lies in one array: device by device, and of each
the values of row 0 first. The arithmetic is that of the components by themselves, in the same order, so the bits are
the same (`amorsim.simulation.plan` tells which components have a twin here).
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from amorsim.kernels.compile import kernel, part
from amorsim.kernels.cone_walls import AT_ONCE, MOST
from amorsim.kernels.cones import hear
from amorsim.kernels.grid import Grid
from amorsim.kernels.lines import Lines
from amorsim.kernels.normals import normals
from amorsim.kernels.philox import pairs
from amorsim.kernels.poses import displaced, wrap
from amorsim.kernels.rays import to_frame
from amorsim.kernels.scans import FINE, ROOM_F, ROOM_Q, ROOM_RINGS, cast_scan

__all__ = [
    "BIAS",
    "COMPASS",
    "ENCODER",
    "FLOOR",
    "GAUSSIAN",
    "GYRO",
    "LASER",
    "NEAREST",
    "SCALE",
    "SECTORS",
    "SONAR",
    "TABLE_COLUMNS",
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

_TURN = 2.0 * math.pi


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
    lines: Lines,
    origin_x: float,
    origin_y: float,
    yaw: float,
    table: Ints,
    mounts: Floats,
    ring: Floats,
    limits: Floats,
    half_angles: Floats,
    edges: Floats,
    cos_b: Floats,
    sin_b: Floats,
    order: Ints,
    starts: Ints,
    body: Floats,
    first: int,
    end: int,
    places: Floats,
    true: Floats,
    rooms: Any,
) -> None:
    """What `sense` does to see, with room to work in."""
    nearness, f, q, blocks, rings, found, following, ends, away, maybe, walls, spans = rooms
    rows = body.shape[0]
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
                    following,
                    ends,
                    away,
                    rings,
                    maybe,
                    walls,
                    spans,
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
                blocks,
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
    table: Ints,
    chains: Ints,
    parts: Floats,
    keys: NDArray[np.uint64],
    mounts: Floats,
    numbers: Floats,
    counter: NDArray[np.uint32],
    body: Floats,
    twist: Floats,
    joints: Floats,
    first: int,
    end: int,
    true: Floats,
    measured: Floats,
    drawn: Floats,
    drawn_bits: Ints,
) -> None:
    """What `sense` does to read, with room to work in."""
    rows = body.shape[0]
    for d in range(table.shape[0]):
        k = table[d, _SIZE]
        for i in range(first, end):
            at = table[d, _VALUES] * rows + i * k
            _sense(table[d, _KIND], mounts[d, i], numbers[d, i], body[i], twist[i], joints[i], true[at : at + k])
            values = measured[at : at + k]
            for j in range(k):
                values[j] = true[at + j]
            for c in range(table[d, _FIRST], table[d, _LAST]):
                number = parts[c, i, 0]
                if chains[c] == GAUSSIAN:
                    _scatter(keys[c, i], counter, i, parts[c, i], values, drawn, drawn_bits)
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
    looks: bool,
    reads: bool,
    resolution: float,
    cell_rows: int,
    cell_cols: int,
    super_cols: int,
    supers: NDArray[np.int32],
    tables: NDArray[np.int32],
    pages: NDArray[np.uint64],
    room: NDArray[np.uint16],
    boxes: Floats,
    blocks_first: Ints,
    line_walls: Floats,
    origin_x: float,
    origin_y: float,
    yaw: float,
    table: Ints,
    mounts: Floats,
    numbers: Floats,
    ring: Floats,
    limits: Floats,
    half_angles: Floats,
    edges: Floats,
    cos_b: Floats,
    sin_b: Floats,
    order: Ints,
    starts: Ints,
    chains: Ints,
    parts: Floats,
    keys: NDArray[np.uint64],
    counter: NDArray[np.uint32],
    body: Floats,
    twist: Floats,
    joints: Floats,
    first: int,
    end: int,
    places: Floats,
    true: Floats,
    measured: Floats,
) -> None:
    """Let the devices of rows first..end-1 look about, if it `looks`, and then read, if it `reads`.

    Parameters
    ----------
    resolution, ..., room
        A `Grid`, by its fields: an array by itself is handed over sooner than one in a tuple.
    boxes, blocks_first, line_walls
        `Lines`, by their fields.
    origin_x, origin_y, yaw
        Where the grid lies in the world.
    table
        (D, TABLE_COLUMNS), of the devices.
    mounts
        (D, N, 3): where each sits on its body.
    numbers
        (D, N, m): counts in a turn of each joint of an encoder, and first the least range of a sonar.
    ring
        (E * N, 3): where the elements of rings sit on their mounts.
    limits
        (L * N,): the longest range seen from each place.
    half_angles, edges
        (D,) and (D, 2): of a sonar's cones, and its cosine and sine.
    cos_b, sin_b, order, starts
        Of the finders' beams, one device after another: of a scanner sorted as `scans.sort_beams` does, with
        `SECTORS` and one `starts`.
    chains, parts, keys
        Elements of all chains: their kinds (C,), their parameters (C, N, 2), and the keys of their draws (C, N).
    counter
        (N, 3): replica, episode and tick of each row.
    body, twist, joints
        True poses (N, 3), velocities (N, 3) and joints (N, j).
    places
        (L * N, 3), gets where range finders look from, poses in the world.
    true, measured
        (V * N,), get what the devices truly and really read.
    """
    if looks:
        grid = Grid(resolution, cell_rows, cell_cols, super_cols, supers, tables, pages, room)
        lines = Lines(boxes, blocks_first, line_walls)
        most = line_walls.shape[1]
        rooms = (
            np.empty(max(1, table[:, _RAYS].max())),
            np.empty(ROOM_F),
            np.empty(ROOM_Q, dtype=np.int64),
            np.empty(boxes.shape[1], dtype=np.int64),
            np.empty(ROOM_RINGS, dtype=np.int64),
            np.empty(most, dtype=np.int64),
            np.empty(most, dtype=np.int64),
            np.empty((5, most)),
            np.empty(max(most, boxes.shape[1])),
            np.empty(AT_ONCE, dtype=np.uint8),
            np.empty((MOST, 3)),
            np.empty((MOST, 3), dtype=np.int64),
        )
        _look_rows(
            grid,
            lines,
            origin_x,
            origin_y,
            yaw,
            table,
            mounts,
            ring,
            limits,
            half_angles,
            edges,
            cos_b,
            sin_b,
            order,
            starts,
            body,
            first,
            end,
            places,
            true,
            rooms,
        )
    if reads:
        drawn = np.empty((3, (table[:, _SIZE].max() + 1) // 2))
        _read_rows(
            table,
            chains,
            parts,
            keys,
            mounts,
            numbers,
            counter,
            body,
            twist,
            joints,
            first,
            end,
            true,
            measured,
            drawn,
            drawn.view(np.int64),
        )
