"""A running fingerprint of exact results, one for each row: two runs with equal bits have equal fingerprints."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from amorsim.kernels.compile import kernel, part

__all__ = ["NOTHING", "absorb", "absorb_rows", "absorb_together"]

Floats = npt.NDArray[np.float64]

# Odd multipliers with well-mixed bits, from the fractional parts of the golden ratio and of the square root of 2.
_FIRST = np.uint64(0x9E3779B97F4A7C15)
_SECOND = np.uint64(0x6A09E667F3BCC909)
_SHIFT = np.uint64(29)
_OTHER = np.uint64(32)

# Arrays a kernel call takes: always so many, for each number of them would be compiled by itself.
_BATCH = 8
NOTHING = np.empty((0, 0))


@part
def _mix(bits: npt.NDArray[np.uint64], out: npt.NDArray[np.uint64]) -> None:
    first = out[0]
    second = out[1]
    for j in range(bits.shape[0]):
        word = bits[j]
        first = (first ^ word) * _FIRST
        first ^= first >> _SHIFT
        second = (second + word) * _SECOND
        second ^= second >> _OTHER
    out[0] = first
    out[1] = second


@part
def _mix_both(
    bits: npt.NDArray[np.uint64],
    others: npt.NDArray[np.uint64],
    out: npt.NDArray[np.uint64],
    other_out: npt.NDArray[np.uint64],
) -> None:
    """What `_mix` does for two rows of as many bits: each waits for its own product, so two take no longer than one."""
    first = out[0]
    second = out[1]
    other_first = other_out[0]
    other_second = other_out[1]
    for j in range(bits.shape[0]):
        word = bits[j]
        other = others[j]
        first = (first ^ word) * _FIRST
        other_first = (other_first ^ other) * _FIRST
        first ^= first >> _SHIFT
        other_first ^= other_first >> _SHIFT
        second = (second + word) * _SECOND
        other_second = (other_second + other) * _SECOND
        second ^= second >> _OTHER
        other_second ^= other_second >> _OTHER
    out[0] = first
    out[1] = second
    other_out[0] = other_first
    other_out[1] = other_second


@kernel
def _absorb(
    a: Floats, b: Floats, c: Floats, d: Floats, e: Floats, f: Floats, g: Floats, h: Floats, out: npt.NDArray[np.uint64]
) -> None:
    for values in (a, b, c, d, e, f, g, h):
        bits = values.view(np.uint64)
        for i in range(bits.shape[0]):
            _mix(bits[i], out[i])


@part
def absorb_rows(
    a: Floats,
    b: Floats,
    c: Floats,
    d: Floats,
    e: Floats,
    sizes: npt.NDArray[np.int64],
    first: Floats,
    second: Floats,
    begin: int,
    end: int,
    out: npt.NDArray[np.uint64],
) -> None:
    """What `absorb_together` does, for kernels."""
    rows = out.shape[0]
    for values in (a, b, c, d, e):
        bits = values.view(np.uint64)
        for i in range(begin, min(end, bits.shape[0])):
            _mix(bits[i], out[i])
    first_bits = first.view(np.uint64)
    second_bits = second.view(np.uint64)
    start = 0
    for k in sizes:
        for i in range(begin, end - 1, 2):
            at = start + i * k
            _mix_both(first_bits[at : at + k], first_bits[at + k : at + 2 * k], out[i], out[i + 1])
            _mix_both(second_bits[at : at + k], second_bits[at + k : at + 2 * k], out[i], out[i + 1])
        if (end - begin) % 2:
            at = start + (end - 1) * k
            _mix(first_bits[at : at + k], out[end - 1])
            _mix(second_bits[at : at + k], out[end - 1])
        start += rows * k


@kernel
def absorb_together(
    a: Floats,
    b: Floats,
    c: Floats,
    d: Floats,
    e: Floats,
    sizes: npt.NDArray[np.int64],
    first: Floats,
    second: Floats,
    begin: int,
    end: int,
    out: npt.NDArray[np.uint64],
) -> None:
    """Mix five arrays (N, k), and then many in turn, the first of each kind and the second, as `absorb` does.

    `first` and `second` hold arrays (N, k) one after the other, of sizes k (A,). Rows begin..end-1 are mixed.
    """
    absorb_rows(a, b, c, d, e, sizes, first, second, begin, end, out)


def absorb(values: Sequence[npt.NDArray[np.float64]], out: npt.NDArray[np.uint64]) -> None:
    """Mix the bits of arrays (N, k), C-contiguous and writeable, into the fingerprints `out` (N, 2), in order."""
    for start in range(0, len(values), _BATCH):
        batch = [*values[start : start + _BATCH], *(NOTHING,) * _BATCH]
        a, b, c, d, e, f, g, h = batch[:_BATCH]
        _absorb(a, b, c, d, e, f, g, h, out)
