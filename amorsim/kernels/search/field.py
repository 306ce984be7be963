"""The distance of every cell to a goal, as a wave that spreads over the free cells."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from amorsim.array_types import Array, Ints, Ints32
from amorsim.kernels.compile import kernel, part
from amorsim.kernels.search.octile import DIAGONAL, GOING_ON, NONE_LEFT

__all__ = ["Wave", "descend", "new_wave", "spread"]


class Wave(NamedTuple):
    """A wave on n cells, which lie as in `amorsim.kernels.search.frontier`.

    Cells that wait are sorted by the whole part of their distance only. No step is shorter than 1, so cells with equal
    whole parts cannot shorten each other's way, and no step reaches farther than two whole parts ahead: three lists
    take turns, and no heap is needed.
    """

    free: NDArray[np.uint8]  # (n,) 1 where a path may lead
    to_go: Array  # (n,) [cells] to the goal, inf where the wave has not come
    waits: Ints32  # (n,) the whole part of `to_go`, -1 where the wave has not come
    lists: Ints32  # (3, n) the cells that wait, by their whole part modulo 3
    order: Ints32  # (n,) the cells passed, in order
    used: Ints  # (5,) entries in use of each list, the present whole part, entries of `order`


def new_wave(free: NDArray[np.uint8], goal: int) -> Wave:
    """A wave at its goal."""
    n = len(free)
    wave = Wave(
        free=free,
        to_go=np.full(n, np.inf),
        waits=np.full(n, -1, np.int32),
        lists=np.empty((3, n), np.int32),
        order=np.empty(n, np.int32),
        used=np.array([1, 0, 0, 0, 0]),
    )
    wave.to_go[goal] = 0.0
    wave.waits[goal] = 0
    wave.lists[0, 0] = goal
    return wave


@part
def _reach(wave: Wave, cell: int, to_go: float) -> None:
    """Let a cell wait for the wave if this way to the goal [cells] is shorter than those before."""
    if to_go < wave.to_go[cell]:
        wave.to_go[cell] = to_go
        whole = int(to_go)
        if wave.waits[cell] != whole:  # an entry that is left in a later list is skipped there
            wave.waits[cell] = whole
            slot = whole % 3
            wave.lists[slot, wave.used[slot]] = cell
            wave.used[slot] += 1


@kernel
def spread(wave: Wave, width: int, most: int) -> int:
    """Let the wave pass `most` cells, or all that it can reach; returns which of the two."""
    free, used = wave.free, wave.used
    left = most
    while True:
        whole = used[3]
        slot = whole % 3
        if used[slot] == 0:
            if used[0] + used[1] + used[2] == 0:
                return NONE_LEFT
            used[3] += 1
            continue
        cell = wave.lists[slot, used[slot] - 1]
        if wave.waits[cell] == whole and left == 0:
            return GOING_ON
        used[slot] -= 1
        if wave.waits[cell] != whole:
            continue
        wave.order[used[4]] = cell
        used[4] += 1
        left -= 1
        here = wave.to_go[cell]
        near, far = here + 1.0, here + DIAGONAL
        east, west = free[cell + 1] != 0, free[cell - 1] != 0
        north, south = free[cell + width] != 0, free[cell - width] != 0
        if east:
            _reach(wave, cell + 1, near)
        if west:
            _reach(wave, cell - 1, near)
        if north:
            _reach(wave, cell + width, near)
            if east and free[cell + width + 1]:
                _reach(wave, cell + width + 1, far)
            if west and free[cell + width - 1]:
                _reach(wave, cell + width - 1, far)
        if south:
            _reach(wave, cell - width, near)
            if east and free[cell - width + 1]:
                _reach(wave, cell - width + 1, far)
            if west and free[cell - width - 1]:
                _reach(wave, cell - width - 1, far)


@kernel
def descend(free: NDArray[np.uint8], to_go: Array, width: int, start: int, out: Ints32) -> int:
    """Write the cells of the path from a start that a whole wave has reached to its goal; returns how many."""
    out[0] = start
    count = 1
    cell = start
    while to_go[cell] > 0.0:
        here = to_go[cell]
        for up in (-width, 0, width):
            found = False
            for across in (-1, 0, 1):
                other = cell + up + across
                # The distance was computed as this sum, so it is equal to the last bit.
                step = DIAGONAL if up != 0 and across != 0 else 1.0
                if (
                    to_go[other] + step == here
                    and free[other]
                    and (up == 0 or free[cell + up])
                    and (across == 0 or free[cell + across])
                ):
                    cell = other
                    found = True
                    break
            if found:
                break
        out[count] = cell
        count += 1
    return count
