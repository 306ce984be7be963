"""Numbers as lines of text, to the byte as Python formats them.

A number with d decimals is its product with 10^d, rounded to whole, halves to even, by what it is exactly and not by
what the rounded product says. The product's rounding error is a number too (Dekker 1971), and decides where the product
lies just between two whole numbers.

Most cells are numbers of six decimals, many in a row. Their digits are computed for several numbers at
once, and then only written one after another, in a third of the time.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from amorsim.array_types import Array, Ints
from amorsim.kernels.compile import kernel, part
from amorsim.kernels.text.shortest import put_not_finite, put_shortest

__all__ = ["EMPTY", "EXACT", "MISSING", "NAME", "SPAN", "WIDEST", "write_lines"]

NAME, EXACT, EMPTY, MISSING = -1, -2, -3, -4
"""Contents of a column other than fixed decimals: one of the names; a number's shortest decimals; nothing; nan."""
SPAN = 4
"""The number of integers that describe a span of columns."""
WIDEST = 32
"""Bytes that a number takes at most, with its comma: a sign, 16 digits, a point, and up to 13 noughts after it."""

_MOST = 9007199254740992.0  # 2^53: up to there, doubles represent all integers
_ROUNDING = 2.0**-52
_SPLIT = 134217729.0  # 2^27 + 1
# Of one type with what they are added to: numba makes a number with a point of whole ones with and without a sign.
_NONE, _ONE, _TWO, _TEN, _NOUGHT = np.uint64(0), np.uint64(1), np.uint64(2), np.uint64(10), np.uint64(48)

# Of the numbers that are computed together: millionths, fewer than 2^31.
_MANY = 2.0e9
_LOW = np.uint64(0xFFFFFFFF)  # tells the compiler that a product of two such parts is one of 32 bits by 32
_HUNDRED, _THOUSAND, _TEN_THOUSAND, _MILLION = np.uint64(100), np.uint64(1000), np.uint64(10_000), np.uint64(1_000_000)
# n // 10^6, 10^4 and 10^2 by a product and a shift: exact for n up to 2^31, 10^6 and 10^4, as the error of the factor
# times n stays below the least distance to the next whole number.
_PER_MILLION, _PER_TEN_THOUSAND, _PER_HUNDRED = np.uint64(2251799814), np.uint64(6871948), np.uint64(10486)
_SHIFT_MILLION, _SHIFT_TEN_THOUSAND, _SHIFT_HUNDRED = np.uint64(51), np.uint64(36), np.uint64(20)
_DIGITS = np.uint64(0x000F000F000F)
_NOUGHTS = np.uint64(0x3030303030300000)
_POINT = np.uint64(0x2E00)
_SIX = np.uint64(0xFFFFFFFFFFFF0000)
_BEFORE = np.uint64(0xFFF)  # of a word: what comes before the point
_IS_NEGATIVE, _IS_OTHER = np.uint64(0x4000), np.uint64(0x8000)


@part
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


@part
def _put_digits(n: int, count: int, out: NDArray[np.uint8], at: int) -> None:
    """Write the last `count` decimal digits of n."""
    rest: Any = np.uint64(n)
    for i in range(at + count - 1, at - 1, -1):
        tenth = rest // _TEN
        out[i] = rest - tenth * _TEN + _NOUGHT
        rest = tenth


@part
def _put_number(value: float, decimals: int, out: NDArray[np.uint8], at: int) -> int:
    """Write a number with some decimals; where it ends, or -1 if it has more digits than are exact."""
    if not abs(value) < np.inf:
        return put_not_finite(value, out, at)
    if math.copysign(1.0, value) < 0.0:
        out[at] = 45
        at += 1
        value = -value
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


@part
def _look_ahead(table: Array, step: int, first: int, count: int, words: NDArray[np.uint64]) -> None:
    """Find the digits of numbers with six decimals, without branches, so that several are done at once.

    A word is six digits in its upper bytes, what comes before the point in the lowest twelve bits, and whether it is
    negative, and whether it needs another method: it is too large, not finite, or just between two.
    """
    line, here = np.uint64(step), np.uint64(first)
    for c in range(np.uint64(count)):
        value = table[line, here + c]
        product = abs(value) * 1e6
        fits = product < _MANY
        product = product if fits else 0.25
        low = np.int32(product)
        beyond = product - np.float64(low) - 0.5
        # The product's error is less than that, so the product decides.
        fits = fits & (abs(beyond) > product * _ROUNDING)
        n = np.uint64(np.uint32(low)) + (_ONE if beyond > 0.0 else _NONE)
        whole = ((n & _LOW) * _PER_MILLION) >> _SHIFT_MILLION
        six = n - whole * _MILLION
        a = ((six & _LOW) * _PER_TEN_THOUSAND) >> _SHIFT_TEN_THOUSAND
        four = six - a * _TEN_THOUSAND
        b = ((four & _LOW) * _PER_HUNDRED) >> _SHIFT_HUNDRED
        # Three numbers of two digits, sixteen bits each; their tens are 103/1024 of them.
        pairs = a | (b << np.uint64(16)) | ((four - b * _HUNDRED) << np.uint64(32))
        tens = pairs + (pairs << _ONE) + (pairs << _TWO) + (pairs << np.uint64(5)) + (pairs << np.uint64(6))
        tens = (tens >> _TEN) & _DIGITS
        ones = pairs - (tens << _ONE) - (tens << np.uint64(3))
        word = (((tens | (ones << np.uint64(8))) << np.uint64(16)) + _NOUGHTS) | whole
        word |= _IS_NEGATIVE if math.copysign(1.0, value) < 0.0 else _NONE
        words[c] = word | (_NONE if fits else _IS_OTHER)


@part
def _put_numbers(
    table: Array,
    step: int,
    first: int,
    count: int,
    words: NDArray[np.uint64],
    out: NDArray[np.uint8],
    at: int,
) -> Any:
    """Write numbers with six decimals, a comma after each; returns where they end, or -1 as `_put_number`."""
    _look_ahead(table, step, first, count, words)
    here: Any = np.uint64(at)
    for c in range(np.uint64(count)):
        word: Any = words[c]
        if word & _IS_OTHER and table[np.uint64(step), np.uint64(first) + c] == np.inf:  # of beams that meet nothing
            out[here], out[here + _ONE], out[here + _TWO] = 105, 110, 102
            here += np.uint64(3)
        elif word & _IS_OTHER:
            place: Any = np.int64(here)
            end = _put_number(table[np.uint64(step), np.uint64(first) + c], 6, out, place)
            if end < 0:
                return -1
            here = np.uint64(end)
        else:
            out[here] = 45
            here += (word >> np.uint64(14)) & _ONE
            whole: Any = word & _BEFORE
            if whole >= _TEN:
                digits = 1 + int(whole >= _HUNDRED) + int(whole >= _THOUSAND)
                start: Any = np.int64(here)
                tens: Any = np.int64(whole // _TEN)
                _put_digits(tens, digits, out, start)
                here += np.uint64(digits)
                whole = whole % _TEN
            word = (word & _SIX) | _POINT | (whole + _NOUGHT)
            # The compiler makes one store of eight.
            out[here] = word
            out[here + _ONE] = word >> np.uint64(8)
            out[here + _TWO] = word >> np.uint64(16)
            out[here + np.uint64(3)] = word >> np.uint64(24)
            out[here + np.uint64(4)] = word >> np.uint64(32)
            out[here + np.uint64(5)] = word >> np.uint64(40)
            out[here + np.uint64(6)] = word >> np.uint64(48)
            out[here + np.uint64(7)] = word >> np.uint64(56)
            here += np.uint64(8)
        out[here] = 44
        here += _ONE
    return np.int64(here)  # a number with a sign, as the rest counts in


@part
def _put_text(texts: NDArray[np.uint8], begin: int, end: int, out: NDArray[np.uint8], at: int) -> int:
    """Copy bytes; where they end."""
    for c in range(begin, end):
        out[at] = texts[c]
        at += 1
    return at


@kernel
def write_lines(
    table: Array,
    rows: int,
    lines: Ints,
    spans: Ints,
    names: NDArray[np.uint8],
    name_ends: Ints,
    powers: NDArray[np.uint64],
    words: NDArray[np.uint64],
    ends: Ints,
    out: NDArray[np.uint8],
) -> bool:
    """Write lines of comma-separated cells; False if a number has more digits than 2^53.

    Parameters
    ----------
    table
        (s, w): a step each, in which there are numbers of `rows` rows.
    lines
        (n,): of which step and row each line is, ``step * rows + row``.
    spans
        (m, `SPAN`): columns side by side that are alike. Where the numbers of row 0 begin, how much further those of
        the next one do, and how many there are; before that their kind: how many decimals they get, up to 13, or
        `NAME`, `EXACT`, `EMPTY`, `MISSING`. Names are counted in the same way, in place of numbers.
    names, name_ends
        The names' bytes one after the other, and where each ends.
    powers
        As of `powers_of_ten`.
    words
        Room to work in: as many as the longest span.
    ends
        (n,), written: where each line ends.
    out
        Room for all of it: `WIDEST` bytes a number, and what names take.
    """
    at = 0
    for i in range(lines.shape[0]):
        step = lines[i] // rows
        row = lines[i] - step * rows
        for m in range(spans.shape[0]):
            kind = spans[m, 0]
            first = spans[m, 1] + row * spans[m, 2]
            count = spans[m, 3]
            if kind == 6:
                at = _put_numbers(table, step, first, count, words, out, at)
                if at < 0:
                    return False
                continue
            for c in range(count):
                if kind >= 0:
                    at = _put_number(table[step, first + c], kind, out, at)
                    if at < 0:
                        return False
                elif kind == NAME:
                    name = first + c
                    at = _put_text(names, name_ends[name - 1] if name else 0, name_ends[name], out, at)
                elif kind == EXACT:
                    at = put_shortest(table[step, first + c], powers, out, at)
                elif kind == MISSING:
                    out[at], out[at + 1], out[at + 2] = 110, 97, 110
                    at += 3
                out[at] = 44
                at += 1
        out[at - 1] = 10
        ends[i] = at
    return True
