"""The deviation of a compass by iron on the robot."""

from __future__ import annotations

from collections.abc import Mapping

import attrs
import numpy as np

from amorsim.array_types import Array
from amorsim.contracts import Draws, Noise, State, parameter
from amorsim.kernels.sensing import noise_elements

__all__ = ["CompassDeviation"]


@attrs.frozen(kw_only=True)
class CompassDeviation(Noise):
    """Adds to a heading h the deviation a + b sin h + c cos h + d sin 2h + e cos 2h, which the robot carries along.

    These are the classical coefficients of a compass. Magnetised ("hard") iron on the robot offsets the field in
    its frame and makes the deviation with one cycle per turn (b, c). Soft iron, magnetised by the earth's field,
    makes the deviation with two cycles (d, e). A misaligned mount makes a. Headings count anticlockwise from x; a
    ship's count clockwise from north, so published coefficients must be converted. The result is not wrapped.

    Parameters
    ----------
    a
        Constant part [rad].
    b, c
        Amplitudes of sin h and cos h [rad].
    d, e
        Amplitudes of sin 2h and cos 2h [rad].
    """

    a: float = parameter(0.0, unit="rad", help="deviation at all headings: alignment")
    b: float = parameter(0.0, unit="rad", help="amplitude of the part with sin h: hard iron")
    c: float = parameter(0.0, unit="rad", help="amplitude of the part with cos h: hard iron")
    d: float = parameter(0.0, unit="rad", help="amplitude of the part with sin 2h: soft iron")
    e: float = parameter(0.0, unit="rad", help="amplitude of the part with cos 2h: soft iron")

    def corrupt(self, values: Array, side: Mapping[str, Array], elapsed: Array, state: State, draws: Draws) -> Array:
        """The headings `(N, k)` [rad] plus their deviations; inf, which is not a heading, stays."""
        out = np.empty(values.shape)
        noise_elements.deviate(values, self.a, self.b, self.c, self.d, self.e, out)
        return out
