"""What iron on the robot does to its compass."""

from __future__ import annotations

from collections.abc import Mapping

import attrs
import numpy as np
import numpy.typing as npt

from amorsim.contracts import Draws, Noise, State, parameter
from amorsim.kernels.sensing import noise_elements

__all__ = ["CompassDeviation"]

Array = npt.NDArray[np.float64]


@attrs.frozen(kw_only=True)
class CompassDeviation(Noise):
    """Adds to a heading h the deviation a + b sin h + c cos h + d sin 2h + e cos 2h, which the robot carries along.

    The classical coefficients of a compass. Magnetised ("hard") iron on the robot, an offset of the field in its
    frame, makes the deviation of one cycle a turn (b, c); soft iron, which the earth's field magnetises, that of
    two (d, e); a is what is mounted or aligned askew. Headings are counted as everywhere here, anticlockwise
    from x; a ship's go clockwise from north, so that published coefficients must be converted. The result is
    not wrapped.

    Parameters
    ----------
    a
        The same at all headings [rad].
    b, c
        Amplitudes of the parts that go with sin h and cos h [rad].
    d, e
        Amplitudes of the parts that go with sin 2h and cos 2h [rad].
    """

    a: float = parameter(0.0, unit="rad", help="deviation at all headings: alignment")
    b: float = parameter(0.0, unit="rad", help="amplitude of the part with sin h: hard iron")
    c: float = parameter(0.0, unit="rad", help="amplitude of the part with cos h: hard iron")
    d: float = parameter(0.0, unit="rad", help="amplitude of the part with sin 2h: soft iron")
    e: float = parameter(0.0, unit="rad", help="amplitude of the part with cos 2h: soft iron")

    def corrupt(self, values: Array, side: Mapping[str, Array], elapsed: Array, state: State, draws: Draws) -> Array:
        """The headings `(N, k)` [rad] with the deviation that each has; what is no heading (inf) stays."""
        out = np.empty(values.shape)
        noise_elements.deviate(values, self.a, self.b, self.c, self.d, self.e, out)
        return out
