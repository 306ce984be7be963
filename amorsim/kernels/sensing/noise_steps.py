"""A chain of noise in one pass: the effect of its elements on values, step by step, row by row."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from amorsim.array_types import Array, Ints
from amorsim.kernels.compile import kernel, part
from amorsim.kernels.random.normals import normals
from amorsim.kernels.random.philox import lay_out, pairs

__all__ = [
    "ADD",
    "CLIP",
    "FLOOR",
    "MEDIANS",
    "MULTIPLY",
    "REPLACE",
    "ROUND",
    "SCATTER",
    "Program",
    "take_steps",
]


SCATTER, ADD, MULTIPLY, ROUND, FLOOR, CLIP, REPLACE = range(7)
MEDIANS = -1  # in the place of a block's number: not draws, but the medians of what they are drawn from


class Program(NamedTuple):
    """The steps for the values of D devices in N rows: S steps in all, those of a device one after another."""

    sizes: Ints
    """(D,): how many values each device has."""
    ends: Ints
    """(D,): one past the last step of each device."""
    kinds: Ints
    """(S,)"""
    parameters: Array
    """(S, N, 2): what each step takes."""
    keys: NDArray[np.uint64]
    """(S, N): of the draws of each step."""
    counter: NDArray[np.uint32]
    """(N, 3): replica, episode and tick of each row."""


@part
def _take_step(kind: int, a: float, b: float, drawn: Array, values: Array) -> None:
    """Do one step to the values (k,) of a row, in place; `drawn` are its draws (k,)."""
    for j in range(values.shape[0]):
        value = values[j]
        if kind == SCATTER:
            deviation = a + b * abs(value)
            if deviation > 0.0 and math.isfinite(value):
                value = value + deviation * drawn[j]
        elif kind == ADD:
            # Taking +0.0 away keeps even the sign of a zero, which adding it would not.
            value = value - (0.0 - a)
        elif kind == MULTIPLY:
            value = value * a
        elif kind == ROUND:
            value = np.rint(value / a) * a
        elif kind == FLOOR:
            value = np.floor(value / a) * a
        elif kind == CLIP:
            value = a if value < a else value
            value = b if b < value < math.inf else value
        else:
            value = b if drawn[j] < a else value
        values[j] = value


@kernel
def take_steps(
    first_row: int,
    end_row: int,
    sizes: Ints,
    ends: Ints,
    kinds: Ints,
    parameters: Array,
    keys: NDArray[np.uint64],
    counter: NDArray[np.uint32],
    blocks: Ints,
    values: Array,
    out: Array,
) -> None:
    """Write into `out` (V,) the result of the steps for `values` (V,), for rows first_row..end_row-1.

    The arguments from `sizes` to `counter` are the fields of the `Program`. Values lie device by device, and of each
    device row by row. `blocks` (S,) are the numbers of the first block that
    each step draws from, or `MEDIANS`.
    """
    rows = counter.shape[0]
    most = 0
    for d in range(sizes.shape[0]):
        most = max(most, sizes[d])
    half = (most + 1) // 2
    first = np.empty(half)
    second = np.empty(half)
    power = np.empty(half)
    bits = first.view(np.int64)
    drawn = np.empty(2 * half)
    begin = 0
    first_step = 0
    for d in range(sizes.shape[0]):
        k = sizes[d]
        pairs_of = (k + 1) // 2
        for i in range(first_row, end_row):
            mine = out[begin + i * k : begin + (i + 1) * k]
            for j in range(k):
                mine[j] = values[begin + i * k + j]
            for s in range(first_step, ends[d]):
                kind = kinds[s]
                if kind == SCATTER or kind == REPLACE:  # noqa: SIM109 - compiles in a third of the time
                    if blocks[s] == MEDIANS:
                        for j in range(k):
                            drawn[j] = 0.0 if kind == SCATTER else 0.5
                    else:
                        pairs(keys[s, i], counter, i, blocks[s], first[:pairs_of], second[:pairs_of])
                        if kind == SCATTER:
                            normals(first[:pairs_of], second[:pairs_of], bits[:pairs_of], power[:pairs_of])
                        lay_out(first[:pairs_of], second[:pairs_of], drawn[:k])
                _take_step(kind, parameters[s, i, 0], parameters[s, i, 1], drawn, mine)
        begin += k * rows
        first_step = ends[d]
