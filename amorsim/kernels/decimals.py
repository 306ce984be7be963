"""Numbers into lines of text, to the byte what Python's formatting gives.

A number with d decimals is its product with 10^d, rounded to whole, halves to even, by what it is exactly and not by
what the rounded product says. The product's rounding error is a number too (Dekker 1971), and decides where the product
lies just between two whole numbers.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from amorsim.kernels.compile import kernel

__all__ = ["EMPTY", "NAME", "TOKEN", "WIDEST", "write_lines"]

NAME, TOKEN, EMPTY = -1, -2, -3
"""What a column holds besides numbers: numbers of names; the next of texts that are given; nothing."""
WIDEST = 32
"""Bytes that a number takes at most, with its comma: a sign, 16 digits, a point, and up to 13 noughts after it."""

_MOST = 9007199254740992.0  # 2^53: whole numbers are told apart up to there
_ROUNDING = 2.0**-52
_SPLIT = 134217729.0  # 2^27 + 1
# Of one type with what they are added to: numba makes a number with a point of whole ones with and without a sign.
_ONE, _TEN, _HUNDRED, _THOUSAND = np.uint64(1), np.uint64(10), np.uint64(100), np.uint64(1000)
_NOUGHT, _TEN_MILLIONS = np.uint64(48), np.uint64(10_000_000)


@kernel
def _whole(value: float, scale: float) -> int:
    """``value * scale`` as it is exactly, rounded to whole, halves to even; of a value that is not negative."""
    product = value * scale
    low = math.floor(product)
    beyond = product - low - 0.5
    n = int(low)
    if abs(beyond) > product * _ROUNDING:
        # The error is less than that, so the product decides.
        return n + int(beyond > 0.0)
    wide = _SPLIT * value
    a = wide - (wide - value)
    wide = _SPLIT * scale
    b = wide - (wide - scale)
    error = ((a * b - product) + a * (scale - b) + (value - a) * b) + (value - a) * (scale - b)
    if beyond == 0.0:
        beyond = error
    return n + int(beyond > 0.0 or (beyond == 0.0 and n & 1 == 1))


@kernel
def _put_digits(n: int, count: int, out: NDArray[np.uint8], at: int) -> None:
    """Write the last `count` decimal digits of n."""
    rest: Any = np.uint64(n)
    for i in range(at + count - 1, at - 1, -1):
        tenth = rest // _TEN
        out[i] = rest - tenth * _TEN + _NOUGHT
        rest = tenth


@kernel
def _put_number(value: float, decimals: int, out: NDArray[np.uint8], at: int) -> int:
    """Write a number with some decimals; where it ends, or -1 if it has more digits than can be told exactly."""
    if value != value:
        out[at], out[at + 1], out[at + 2] = 110, 97, 110  # nan
        return at + 3
    if math.copysign(1.0, value) < 0.0:
        out[at] = 45
        at += 1
        value = -value
    if value == np.inf:
        out[at], out[at + 1], out[at + 2] = 105, 110, 102  # inf
        return at + 3
    unit = 1
    for _ in range(decimals):
        unit *= 10
    scale = np.float64(unit)
    if not value * scale < _MOST:
        return -1
    n = _whole(value, scale)
    before = n // unit
    count = 1
    limit = 10
    while before >= limit:
        limit *= 10
        count += 1
    _put_digits(before, count, out, at)
    at += count
    if decimals > 0:
        out[at] = 46
        _put_digits(n - before * unit, decimals, out, at + 1)
        at += 1 + decimals
    return at


@kernel
def _put_small(value: float, out: NDArray[np.uint8], at: int) -> Any:
    """Write a number between -10 and 10 with 6 decimals, as most are; where it ends, or 0 if it takes more to tell."""
    here: Any = np.uint64(at)
    if math.copysign(1.0, value) < 0.0:
        out[here] = 45
        here += _ONE
        value = -value
    product = value * 1e6
    low = math.floor(product)
    beyond = product - low - 0.5
    n: Any = np.uint64(int(low) + int(beyond > 0.0))
    if abs(beyond) <= product * _ROUNDING or n >= _TEN_MILLIONS:
        return 0
    # Digits in no need of one another.
    high = n // _THOUSAND
    whole = high // _THOUSAND
    out[here] = whole + _NOUGHT
    out[here + _ONE] = 46
    here += np.uint64(2)
    for three in (high - whole * _THOUSAND, n - high * _THOUSAND):
        first = three // _HUNDRED
        second = three // _TEN
        out[here] = first + _NOUGHT
        out[here + _ONE] = second - first * _TEN + _NOUGHT
        out[here + np.uint64(2)] = three - second * _TEN + _NOUGHT
        here += np.uint64(3)
    return np.int64(here)  # a number with a sign, as the rest counts in


@kernel
def write_lines(
    values: NDArray[np.float64],
    kinds: NDArray[np.int64],
    names: NDArray[np.uint8],
    name_ends: NDArray[np.int64],
    tokens: NDArray[np.uint8],
    ends: NDArray[np.int64],
    out: NDArray[np.uint8],
) -> bool:
    """Write lines of comma-separated cells; False if a number has more digits than 2^53.

    Parameters
    ----------
    values
        (n, k): a line each.
    kinds
        (k,): how many decimals the column's numbers get, up to 13, or `NAME`, `TOKEN`, `EMPTY`.
    names, name_ends
        The names' bytes one after the other, and where each ends.
    tokens
        The texts of all `TOKEN` cells in order, with a comma after each.
    ends
        (n,), written: where each line ends.
    out
        Room for all of it: `WIDEST` bytes a number, and what names and tokens take.
    """
    at = 0
    token = 0
    for i in range(values.shape[0]):
        for k in range(values.shape[1]):
            kind = kinds[k]
            if kind >= 0:
                value = values[i, k]
                end = _put_small(value, out, at) if kind == 6 and abs(value) < 10.0 else 0
                at = end if end > 0 else _put_number(value, kind, out, at)
                if at < 0:
                    return False
            elif kind == NAME:
                name = int(values[i, k])
                for c in range(name_ends[name - 1] if name else 0, name_ends[name]):
                    out[at] = names[c]
                    at += 1
            elif kind == TOKEN:
                while tokens[token] != 44:
                    out[at] = tokens[token]
                    at += 1
                    token += 1
                token += 1
            out[at] = 44
            at += 1
        out[at - 1] = 10
        ends[i] = at
    return True
