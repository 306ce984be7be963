"""The modes of a particle cloud: its particles in bins of a grid over poses, and neighbouring bins joined."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from amorsim.array_types import Array, Ints
from amorsim.kernels.compile import kernel, part
from amorsim.kernels.kinematics.poses import wrap

__all__ = ["Bins", "Modes", "bin_of", "bins", "find_modes", "put"]


_MIDDLE = 1 << 20  # of the numbers of bins along x and y
_LOW = (1 << 31) - 1
_MIX_LOW, _MIX_HIGH = 73856093, 19349663  # primes; no product of theirs with a half of a key leaves 64 bits


class Bins(NamedTuple):
    """A table of bins, found by their keys, and room to join them."""

    keys: Ints  # (T,) -1 where empty; T a power of two, twice the particles at least
    slots: Ints  # (T,) the number of the bin there
    own: Ints  # (P,) the key of each bin
    weight: Array  # (P,) of the particles in each bin
    mark: Ints  # (P,) whatever a caller notes of each bin
    parent: Ints  # (P,) a bin of the same mode, itself at a mode's root
    mode: Ints  # (P,) the number of the mode of a root
    of: Ints  # (P,) the bin of each particle
    sums: Array  # (P, 12)


class Modes(NamedTuple):
    """The heaviest modes of N rows, heaviest first, nan where there are fewer."""

    poses: Array  # (N, H, 3)
    covariances: Array  # (N, H, 3, 3)
    weights: Array  # (N, H)


@kernel
def bins(particles: int) -> Any:
    """Room for so many particles."""
    size = 16
    while size < 2 * particles:
        size *= 2
    return Bins(
        np.empty(size, dtype=np.int64),
        np.empty(size, dtype=np.int64),
        np.empty(particles, dtype=np.int64),
        np.empty(particles),
        np.empty(particles, dtype=np.int64),
        np.empty(particles, dtype=np.int64),
        np.empty(particles, dtype=np.int64),
        np.empty(particles, dtype=np.int64),
        np.empty((particles, 12)),
    )


@kernel
def bin_of(x: float, y: float, heading: float, side: float, turns: int) -> int:
    """The key of a pose's bin: `side` [m] wide, and one of `turns` parts of a full turn."""
    at_x = np.int64(math.floor(x / side)) + _MIDDLE
    at_y = np.int64(math.floor(y / side)) + _MIDDLE
    at_h = np.int64(math.floor((heading + math.pi) / (2.0 * math.pi) * turns))
    if at_h < 0 or at_h >= turns:
        at_h %= turns
    return int((at_x << 40) | (at_y << 16) | at_h)


@kernel
def _place_of(table: Bins, key: int) -> int:
    """Where a key is in the table, or the empty place for it."""
    mask = table.keys.shape[0] - 1
    mixed = (key & _LOW) * _MIX_LOW + (key >> 31) * _MIX_HIGH
    at = (mixed ^ (mixed >> 15)) & mask
    while table.keys[at] != -1 and table.keys[at] != key:
        at = (at + 1) & mask
    return int(at)


@kernel
def put(table: Bins, key: int, count: int) -> Any:
    """The number of a key's bin, and how many bins there are then; `count` is how many there were."""
    at = _place_of(table, key)
    if table.keys[at] == -1:
        table.keys[at] = key
        table.slots[at] = count
        table.own[count] = key
        table.weight[count] = 0.0
        table.mark[count] = 0
        table.parent[count] = count
        count += 1
    return table.slots[at], count


@kernel
def _root(table: Bins, b: int) -> int:
    while table.parent[b] != b:
        table.parent[b] = table.parent[table.parent[b]]
        b = table.parent[b]
    return b


@kernel
def _join(table: Bins, count: int, turns: int) -> None:
    """Join each bin with those next to it, also across corners."""
    for b in range(count):
        key = table.own[b]
        at_x = key >> 40
        at_y = (key >> 16) & 0xFFFFFF
        at_h = key & 0xFFFF
        # Half of the 26 neighbours: the others have this one among theirs.
        for n in range(14, 27):
            x = at_x + n // 9 - 1
            y = at_y + (n // 3) % 3 - 1
            h = (at_h + n % 3 - 1) % turns
            at = _place_of(table, (x << 40) | (y << 16) | h)
            if table.keys[at] != -1:
                one = _root(table, b)
                other = _root(table, table.slots[at])
                table.parent[max(one, other)] = min(one, other)


@kernel
def _add_means(particles: Array, headings: Array, weights: Array, table: Bins) -> None:
    """Add up each mode's weights, their squares, and its weighted places, cosines and sines."""
    sums = table.sums
    m = 0
    w0 = w1 = x = y = c = s = 0.0  # of a run of particles in one mode
    for p in range(particles.shape[0]):
        mode = table.mode[table.parent[table.of[p]]]
        if mode != m:
            _add(sums, m, 0, w0, w1, x, y, c, s)
            m = mode
            w0 = w1 = x = y = c = s = 0.0
        w = weights[p]
        w0 += w
        w1 += w * w
        x += w * particles[p, 0]
        y += w * particles[p, 1]
        c += w * headings[1, p]
        s += w * headings[0, p]
    _add(sums, m, 0, w0, w1, x, y, c, s)


@kernel
def _add_squares(particles: Array, weights: Array, table: Bins) -> None:
    """Add up the weighted products of deviations from each mode's mean."""
    sums = table.sums
    m = 0
    xx = xy = xh = yy = yh = hh = 0.0
    for p in range(particles.shape[0]):
        mode = table.mode[table.parent[table.of[p]]]
        if mode != m:
            _add(sums, m, 6, xx, xy, xh, yy, yh, hh)
            m = mode
            xx = xy = xh = yy = yh = hh = 0.0
        dx = particles[p, 0] - sums[m, 2]
        dy = particles[p, 1] - sums[m, 3]
        dh = wrap(particles[p, 2] - sums[m, 4])
        w = weights[p]
        xx += w * dx * dx
        xy += w * dx * dy
        xh += w * dx * dh
        yy += w * dy * dy
        yh += w * dy * dh
        hh += w * dh * dh
    _add(sums, m, 6, xx, xy, xh, yy, yh, hh)


@part
def _add(sums: Array, m: int, k: int, a: float, b: float, c: float, d: float, e: float, f: float) -> None:
    sums[m, k] += a
    sums[m, k + 1] += b
    sums[m, k + 2] += c
    sums[m, k + 3] += d
    sums[m, k + 4] += e
    sums[m, k + 5] += f


@kernel
def find_modes(
    particles: Array, headings: Array, weights: Array, side: float, turns: int, table: Bins, row: int, out: Modes
) -> int:
    """Write the modes of a row's particles (n, 3), whose weights add up to 1; returns how many bins they are in.

    `headings` (2, n or more) has the sines and cosines of theirs, and `turns` is the number of bins in a full turn.
    `table.of` has the bin of each particle then, and `table.weight` that of each bin.
    """
    table.keys[:] = -1
    count = 0
    last, b = -1, 0  # resampled particles of one bin follow each other
    for p in range(particles.shape[0]):
        key = bin_of(particles[p, 0], particles[p, 1], particles[p, 2], side, turns)
        if key != last:
            b, count = put(table, key, count)
            last = key
        table.of[p] = b
        table.weight[b] += weights[p]
    _join(table, count, turns)
    modes = 0
    for b in range(count):
        root = _root(table, b)
        table.parent[b] = root
        if root == b:
            table.mode[b] = modes
            modes += 1
    sums = table.sums
    sums[:modes] = 0.0
    _add_means(particles, headings, weights, table)
    for m in range(modes):
        w = sums[m, 0]
        if w > 0.0:
            sums[m, 2] /= w
            sums[m, 3] /= w
            sums[m, 4] = math.atan2(sums[m, 5], sums[m, 4])
        for k in range(6, 12):
            sums[m, k] = 0.0
    _add_squares(particles, weights, table)
    _write(row, sums, modes, out)
    return count


@kernel
def _write(row: int, sums: Array, modes: int, out: Modes) -> None:
    """Write the heaviest modes, and remove each from `sums`."""
    out.poses[row] = np.nan
    out.covariances[row] = np.nan
    out.weights[row] = np.nan
    for rank in range(min(out.weights.shape[1], modes)):
        best = 0
        for m in range(modes):
            if sums[m, 0] > sums[best, 0]:
                best = m
        w = sums[best, 0]
        if not w > 0.0:
            break
        # Of few particles the mean square deviation is too small, as one number of them was spent on the mean.
        rest = 1.0 - sums[best, 1] / (w * w)
        scale = 1.0 / (w * rest) if rest > 1e-9 else 0.0
        out.weights[row, rank] = w
        out.poses[row, rank, 0] = sums[best, 2]
        out.poses[row, rank, 1] = sums[best, 3]
        out.poses[row, rank, 2] = wrap(sums[best, 4])
        k = 6
        for i in range(3):
            for j in range(i, 3):
                out.covariances[row, rank, i, j] = sums[best, k] * scale
                out.covariances[row, rank, j, i] = sums[best, k] * scale
                k += 1
        sums[best, 0] = -1.0
