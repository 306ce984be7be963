"""Standard normal draws from uniform ones, by Box and Muller's transform (Ann. Math. Statist. 29, 1958).

The logarithm is worked out here, as sine and cosine are, by sums and products alone: in loops without a branch or a
call, which compilers make several draws wide, and with the same bits on every processor, whatever its library of
mathematics. Each is good to some units in the last place.
"""

from __future__ import annotations

import math

import numpy as np

from amorsim.array_types import Array, Ints
from amorsim.kernels.compile import inlined, part
from amorsim.kernels.random.quarter_turns import cosine_of_quarters, sine_of_quarters

__all__ = ["normals"]


_MANTISSA = 52  # bits of it
_ROOT_HALF = 0x3FE6A09E667F3BCD  # the bits of the square root of 1/2
_LN_2 = 0.6931471805599453


@part
def _split(bits: Ints, power: Array) -> None:
    """Turn positive numbers, given by their bits, into m of m * 2**power, from the root of a half to that of two."""
    for b in range(bits.shape[0]):
        word = bits[b]
        p = (word - _ROOT_HALF) >> _MANTISSA
        power[b] = p
        bits[b] = word - (p << _MANTISSA)


@inlined
def _log(m: float, power: float) -> float:
    """The natural logarithm of m * 2**power, with m as `_split` leaves it."""
    # Twice the inverse hyperbolic tangent of s: as |s| is below 0.1716, what is left out is below 2e-17 of it.
    s = (m - 1.0) / (m + 1.0)
    z = s * s
    tail = z * (1.0 / 17.0 + z * (1.0 / 19.0 + z * (1.0 / 21.0)))
    tail = z * (1.0 / 9.0 + z * (1.0 / 11.0 + z * (1.0 / 13.0 + z * (1.0 / 15.0 + tail))))
    tail = z * (1.0 / 3.0 + z * (1.0 / 5.0 + z * (1.0 / 7.0 + tail)))
    return power * _LN_2 + 2.0 * (s + s * tail)


@part
def normals(first: Array, second: Array, first_bits: Ints, power: Array) -> None:
    """Turn pairs of uniform draws in (0, 1) into pairs of standard normal ones, in place.

    `first_bits` is `first` seen as whole numbers, and `power` room to work in, as long.
    """
    _split(first_bits, power)
    for b in range(first.shape[0]):
        radius = math.sqrt(-2.0 * _log(first[b], power[b]))
        # The angle is n + r quarter turns, to the last bit.
        n = np.floor(4.0 * second[b] + 0.5)
        r = 4.0 * second[b] - n
        sin = sine_of_quarters(r)
        cos = cosine_of_quarters(r)
        odd = (n == 1.0) | (n == 3.0)
        x = sin if odd else cos
        y = cos if odd else sin
        first[b] = radius * (-x if (n == 1.0) | (n == 2.0) else x)
        second[b] = radius * (-y if (n == 2.0) | (n == 3.0) else y)
