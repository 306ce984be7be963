"""A step of sensing for devices of the common kinds: where they look from, and what their noise makes of what they see.

All devices of a group are done in one call each, and what they read lies in one array: device by device, and of each
the values of row 0 first. The arithmetic is that of the components by themselves, in the same order, so the bits are
the same (`amorsim.simulation.plan` tells which components have a twin here).
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from amorsim.kernels.compile import kernel, part
from amorsim.kernels.philox import normals, pairs
from amorsim.kernels.poses import displaced, wrap

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
    "SONAR",
    "TABLE_COLUMNS",
    "place",
    "read",
]

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]

# Kinds of devices.
ENCODER, COMPASS, GYRO, LASER, SONAR = range(5)
# Kinds of elements of a chain: Gaussian noise, a constant, a factor, whole steps.
GAUSSIAN, BIAS, SCALE, NEAREST, FLOOR = range(5)

# Columns of the table of devices: its kind; how many values it has; how many there are of the devices before it, how
# many elements of rings, and how many places that are looked from; its first element in the chains, and one past its
# last.
_KIND, _SIZE, _VALUES, _RING, _PLACES, _FIRST, _LAST = range(7)
TABLE_COLUMNS = 7

_TURN = 2.0 * math.pi


@kernel
def place(table: Ints, mounts: Floats, ring: Floats, body: Floats, places: Floats) -> None:
    """Write where range finders look from, poses in the world, into `places` (L * N, 3).

    Parameters
    ----------
    table
        (D, TABLE_COLUMNS), of the devices.
    mounts
        (D, N, 3): where each sits on its body.
    ring
        (E * N, 3): where the elements of rings sit on their mounts.
    body
        (N, 3): the bodies' poses.
    """
    rows = body.shape[0]
    for d in range(table.shape[0]):
        if table[d, _KIND] < LASER:
            continue
        k = 1 if table[d, _KIND] == LASER else table[d, _SIZE]
        for i in range(rows):
            x, y, heading = displaced(
                body[i, 0], body[i, 1], body[i, 2], mounts[d, i, 0], mounts[d, i, 1], mounts[d, i, 2]
            )
            at = table[d, _PLACES] * rows + i * k
            if table[d, _KIND] == LASER:
                places[at, 0] = x
                places[at, 1] = y
                places[at, 2] = heading
                continue
            c = math.cos(heading)
            s = math.sin(heading)
            first = table[d, _RING] * rows + i * k
            for j in range(k):
                on_x = ring[first + j, 0]
                on_y = ring[first + j, 1]
                places[at + j, 0] = x + (c * on_x - s * on_y)
                places[at + j, 1] = y + (s * on_x + c * on_y)
                places[at + j, 2] = wrap(heading + ring[first + j, 2])


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
    return value + deviation * noise if deviation > 0.0 and abs(value) < np.inf else value


@part
def _scatter(
    key: np.uint64,
    counter: npt.NDArray[np.uint32],
    row: int,
    part: Floats,
    values: Floats,
    first: Floats,
    second: Floats,
) -> None:
    """Put Gaussian noise on values, as `philox.fill_normal` and `readings.scatter` do one after the other.

    `first` and `second` are room to work in.
    """
    pairs(key, counter, row, 0, first, second)
    normals(first, second)
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
    keys: npt.NDArray[np.uint64],
    mounts: Floats,
    numbers: Floats,
    counter: npt.NDArray[np.uint32],
    body: Floats,
    twist: Floats,
    joints: Floats,
    first: int,
    end: int,
    true: Floats,
    measured: Floats,
    one: Floats,
    other: Floats,
) -> None:
    """What `read` does, with room to work in."""
    rows = body.shape[0]
    for d in range(table.shape[0]):
        k = table[d, _SIZE]
        half = (k + 1) // 2
        for i in range(first, end):
            at = table[d, _VALUES] * rows + i * k
            _sense(table[d, _KIND], mounts[d, i], numbers[d, i], body[i], twist[i], joints[i], true[at : at + k])
            values = measured[at : at + k]
            for j in range(k):
                values[j] = true[at + j]
            for c in range(table[d, _FIRST], table[d, _LAST]):
                number = parts[c, i, 0]
                if chains[c] == GAUSSIAN:
                    _scatter(keys[c, i], counter, i, parts[c, i], values, one[:half], other[:half])
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
def read(
    table: Ints,
    chains: Ints,
    parts: Floats,
    keys: npt.NDArray[np.uint64],
    mounts: Floats,
    numbers: Floats,
    counter: npt.NDArray[np.uint32],
    body: Floats,
    twist: Floats,
    joints: Floats,
    first: int,
    end: int,
    true: Floats,
    measured: Floats,
) -> None:
    """Write what the devices of rows first..end-1 truly and really read, into `true` and `measured` (V * N,).

    Parameters
    ----------
    table, mounts
        As in `place`.
    chains, parts, keys
        Elements of all chains: their kinds (C,), their parameters (C, N, 2), and the keys of their draws (C, N).
    numbers
        (D, N, m): counts in a turn of each joint of an encoder, and first the least range of a sonar.
    counter
        (N, 3): replica, episode and tick of each row.
    body, twist, joints
        True poses (N, 3), velocities (N, 3) and joints (N, j).
    true
        Range finders have put what they see there.
    """
    most = (table[:, _SIZE].max() + 1) // 2
    one = np.empty(most)
    other = np.empty(most)
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
        one,
        other,
    )
