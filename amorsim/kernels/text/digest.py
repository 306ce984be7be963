"""A running fingerprint of exact results, one for each row: two runs with equal bits have equal fingerprints."""

from __future__ import annotations

import functools
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from amorsim.array_types import Array
from amorsim.kernels.compile import kernel, part

__all__ = ["absorb", "bind_absorb"]


# Odd multipliers with well-mixed bits, from the fractional parts of the golden ratio and of the square root of 2.
_FIRST = np.uint64(0x9E3779B97F4A7C15)
_SECOND = np.uint64(0x6A09E667F3BCC909)
_SHIFT = np.uint64(29)
_HALF = np.uint64(32)

# Arrays in a kernel call: a fixed number, because each number would be compiled separately.
_BATCH = 8
_PADDING = [np.empty((0, 0))] * _BATCH


@part
def _mix(bits: npt.NDArray[np.uint64], out: npt.NDArray[np.uint64]) -> None:
    """Mix an array into a row's fingerprint: the sum of its words, each scrambled with its place, and of their squares.

    Whole numbers may be added up in any order, so compilers do several words side by side. Array after array each sum
    goes through a chain of products, which keeps their order.
    """
    words = np.uint64(0)
    squares = np.uint64(0)
    for j in range(bits.shape[0]):
        word = (bits[j] + np.uint64(j) * _SECOND) * _FIRST
        word = (word ^ (word >> _HALF)) * _SECOND
        words += word
        squares += word * word
    first = (out[0] ^ words) * _FIRST
    second = (out[1] + squares) * _SECOND
    out[0] = first ^ (first >> _SHIFT)
    out[1] = second ^ (second >> _HALF)


@kernel
def _absorb(
    a: Array, b: Array, c: Array, d: Array, e: Array, f: Array, g: Array, h: Array, out: npt.NDArray[np.uint64]
) -> None:
    for values in (a, b, c, d, e, f, g, h):
        bits = values.view(np.uint64)
        for i in range(bits.shape[0]):
            _mix(bits[i], out[i])


def absorb(values: Sequence[Array], out: npt.NDArray[np.uint64]) -> None:
    """Mix the bits of arrays (N, k), C-contiguous and writeable, into the fingerprints `out` (N, 2), in order."""
    for call in bind_absorb(values, out):
        call()


def bind_absorb(values: Sequence[Array], out: npt.NDArray[np.uint64]) -> list[Callable[[], None]]:
    """The calls that do what `absorb` does, each time they are made, for arrays that keep their place."""
    batches = [values[start : start + _BATCH] for start in range(0, len(values), _BATCH)]
    arguments: list[Any] = [(*batch, *_PADDING[len(batch) :], out) for batch in batches]
    return [functools.partial(_absorb, *given) for given in arguments]
