"""Numbers as the shortest decimals that are read back as the same, to the byte as Python's ``repr`` gives.

Of the decimals that are read as a double those with the fewest digits are sought, and of them the nearest: on the grid
of a power of ten that is just finer than the distance to the next double, and on that of the power above it, where at
most one lies so near. Products with powers of ten of 128 bits, rounded to odd, decide on which side of a bound a
decimal lies (R. Giulietti, The Schubfach way to render doubles, 2020).
"""

from __future__ import annotations

import functools
import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from amorsim.kernels.compile import part

__all__ = ["powers_of_ten", "put_not_finite", "put_shortest"]

_LEAST, _GREATEST = -292, 324  # exponents of the powers that doubles need
_ONE, _FOUR, _TEN, _NOUGHT = np.uint64(1), np.uint64(4), np.uint64(10), np.uint64(48)
_FORTY = np.uint64(40)
_HALF, _LOW = np.uint64(32), np.uint64(0xFFFFFFFF)


@functools.cache
def powers_of_ten() -> NDArray[np.uint64]:
    """The powers from 10^-292 to 10^324, of each the highest 128 bits, rounded up: `(617, 2)`, the upper 64 first."""
    table = np.empty((_GREATEST - _LEAST + 1, 2), dtype=np.uint64)
    for row, exponent in enumerate(range(_LEAST, _GREATEST + 1)):
        power = 10 ** abs(exponent)
        shift = 127 - (power.bit_length() - 1)
        if exponent >= 0:
            bits = power << shift if shift >= 0 else -(-power >> -shift)
        else:
            # 2^(127 + e), divided by the power, where 2^-e is the power of two below its reciprocal.
            bits = -(-(1 << 127 + power.bit_length()) // power)
        table[row] = bits >> 64, bits & ((1 << 64) - 1)
    return table


@part
def _product(a: Any, b: Any) -> Any:
    """The upper and lower 64 bits of a product."""
    a1, a0, b1, b0 = a >> _HALF, a & _LOW, b >> _HALF, b & _LOW
    low = a0 * b0
    middle = a1 * b0 + (low >> _HALF)
    other = a0 * b1 + (middle & _LOW)
    return a1 * b1 + (middle >> _HALF) + (other >> _HALF), (other << _HALF) | (low & _LOW)


@part
def _scaled(high: Any, low: Any, factor: Any) -> Any:
    """The upper 64 of 192 bits of a product, the lowest of them set if any below is: rounded to odd."""
    x, _ = _product(low, factor)
    upper, y = _product(high, factor)
    y = y + x
    return (upper + np.uint64(y < x)) | np.uint64(y > _ONE)


@part
def _decimal_of(value: float, powers: NDArray[np.uint64]) -> Any:
    """The digits as a whole number, and the power of ten that they count; of a value that is finite and > 0."""
    _, exponent = math.frexp(value)  # value = fraction * 2^exponent, 0.5 <= fraction < 1
    q = exponent - 53
    if q < -1074:  # of fewer bits than others
        q = -1074
    c: Any = np.uint64(np.int64(math.ldexp(value, -q) if q > -1000 else math.ldexp(math.ldexp(value, 1000), -q - 1000)))
    is_odd = c & _ONE
    is_power_of_two = np.int64(c == np.uint64(4503599627370496) and q > -1074)  # the next below is half as far
    k = (q * 1262611 - 524031 * is_power_of_two) >> 22
    h: Any = np.uint64(q + ((-k * 1741647) >> 19) + 1)
    high, low = powers[-k + 292, 0], powers[-k + 292, 1]
    middle = c * _FOUR
    v = _scaled(high, low, middle << h)
    lower = _scaled(high, low, (middle - np.uint64(2 - is_power_of_two)) << h) + is_odd
    upper = _scaled(high, low, (middle + np.uint64(2)) << h) - is_odd
    s = v // _FOUR
    if s >= _TEN:
        coarse = s // _TEN
        below = lower <= coarse * _FORTY
        above = coarse * _FORTY + _FORTY <= upper
        if below != above:
            return coarse + np.uint64(above), k + 1
    below = lower <= s * _FOUR
    above = s * _FOUR + _FOUR <= upper
    if below != above:
        return s + np.uint64(above), k
    half = s * _FOUR + np.uint64(2)
    return s + np.uint64(v > half or (v == half and s & _ONE == _ONE)), k


@part
def put_not_finite(value: float, out: NDArray[np.uint8], at: int) -> int:
    """Write nan, inf or -inf; where it ends."""
    if value != value:
        out[at], out[at + 1], out[at + 2] = 110, 97, 110  # nan
        return at + 3
    if value < 0.0:
        out[at] = 45
        at += 1
    out[at], out[at + 1], out[at + 2] = 105, 110, 102  # inf
    return at + 3


@part
def put_shortest(value: float, powers: NDArray[np.uint64], out: NDArray[np.uint8], at: int) -> int:
    """Write a number; where it ends, after 24 bytes at most: -1.2345678901234567e-308."""
    if not abs(value) < np.inf:
        return put_not_finite(value, out, at)
    if math.copysign(1.0, value) < 0.0:
        out[at] = 45
        at += 1
        value = -value
    if value == 0.0:
        out[at], out[at + 1], out[at + 2] = 48, 46, 48  # 0.0
        return at + 3
    digits, power = _decimal_of(value, powers)
    while digits % _TEN == 0:
        digits = digits // _TEN
        power += 1
    count = 1
    limit = _TEN
    while count < 17 and digits >= limit:
        limit *= _TEN
        count += 1
    point = count + power  # digits before the point
    if -4 < point <= 16:
        return _put_plain(digits, count, point, out, at)
    end = _put_digits(digits, count, 1, out, at)
    if count == 1:
        end -= 1  # no point
    exponent = point - 1
    out[end] = 101
    out[end + 1] = 45 if exponent < 0 else 43
    exponent = abs(exponent)
    places = 3 if exponent >= 100 else 2
    for i in range(end + 1 + places, end + 1, -1):
        out[i] = 48 + exponent % 10
        exponent //= 10
    return end + 2 + places


@part
def _put_plain(digits: Any, count: int, point: int, out: NDArray[np.uint8], at: int) -> int:
    """Write digits, `point` of them before the point, filled up with noughts."""
    if point <= 0:
        out[at], out[at + 1] = 48, 46
        at += 2
        for _ in range(-point):
            out[at] = 48
            at += 1
        return _put_digits(digits, count, count, out, at) - 1
    if point < count:
        return _put_digits(digits, count, point, out, at)
    at = _put_digits(digits, count, count, out, at) - 1
    for _ in range(point - count):
        out[at] = 48
        at += 1
    out[at], out[at + 1] = 46, 48
    return at + 2


@part
def _put_digits(digits: Any, count: int, point: int, out: NDArray[np.uint8], at: int) -> int:
    """Write `count` digits, a point after `point` of them, and where that ends."""
    for i in range(at + count, at - 1, -1):
        if i == at + point:
            out[i] = 46
        else:
            rest = digits // _TEN
            out[i] = digits - rest * _TEN + _NOUGHT
            digits = rest
    return at + count + 1
