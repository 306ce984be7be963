"""Standard normal draws from uniform ones, by Box and Muller's transform (Ann. Math. Statist. 29, 1958).

The logarithm, sine and cosine are worked out here, by sums and products alone: in loops without a branch or a call,
which compilers make several draws wide, and with the same bits on every processor, whatever its library of mathematics.
Each is good to some units in the last place.
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from amorsim.kernels.compile import inlined, part

__all__ = ["normals"]

Floats = npt.NDArray[np.float64]

_MANTISSA = 52  # bits of it
_ROOT_HALF = 0x3FE6A09E667F3BCD  # the bits of the square root of 1/2
_LN_2 = 0.6931471805599453

# Taylor's coefficients of sine and cosine of r quarter turns, (pi / 2)**k / k!: for r of at most a half the terms left
# out are below 5e-17 and 3e-18.
_S0, _S1, _S2, _S3 = 1.5707963267948966, -0.6459640975062463, 0.07969262624616705, -0.004681754135318688
_S4, _S5, _S6, _S7 = 0.00016044118478735983, -3.598843235212085e-06, 5.692172921967927e-08, -6.688035109811468e-10
_C1, _C2, _C3, _C4 = -1.2337005501361697, 0.25366950790104803, -0.02086348076335296, 0.0009192602748394266
_C5, _C6, _C7, _C8 = -2.5202042373060607e-05, 4.710874778818172e-07, -6.386603083791852e-09, 6.565963114979473e-11


@part
def _split(bits: npt.NDArray[np.int64], power: Floats) -> None:
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
def normals(first: Floats, second: Floats, first_bits: npt.NDArray[np.int64], power: Floats) -> None:
    """Turn pairs of uniform draws in (0, 1) into pairs of standard normal ones, in place.

    `first_bits` is `first` seen as whole numbers, and `power` room to work in, as long.
    """
    _split(first_bits, power)
    for b in range(first.shape[0]):
        radius = math.sqrt(-2.0 * _log(first[b], power[b]))
        # The angle is n + r quarter turns, to the last bit.
        n = np.floor(4.0 * second[b] + 0.5)
        r = 4.0 * second[b] - n
        z = r * r
        sin = r * (_S0 + z * (_S1 + z * (_S2 + z * (_S3 + z * (_S4 + z * (_S5 + z * (_S6 + z * _S7)))))))
        cos = 1.0 + z * (_C1 + z * (_C2 + z * (_C3 + z * (_C4 + z * (_C5 + z * (_C6 + z * (_C7 + z * _C8)))))))
        odd = (n == 1.0) | (n == 3.0)
        x = sin if odd else cos
        y = cos if odd else sin
        first[b] = radius * (-x if (n == 1.0) | (n == 2.0) else x)
        second[b] = radius * (-y if (n == 2.0) | (n == 3.0) else y)
