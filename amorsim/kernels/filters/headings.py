"""Sines and cosines of the headings of particles, many at a time."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from amorsim.kernels.compile import part

__all__ = ["fill_turns"]

Floats = npt.NDArray[np.float64]

_QUARTERS = 2.0 / math.pi  # of a turn in a radian

# Taylor's coefficients of sine and cosine of r quarter turns, (pi / 2)**k / k!, as in `random.normals`.
_S0, _S1, _S2, _S3 = 1.5707963267948966, -0.6459640975062463, 0.07969262624616705, -0.004681754135318688
_S4, _S5, _S6, _S7 = 0.00016044118478735983, -3.598843235212085e-06, 5.692172921967927e-08, -6.688035109811468e-10
_C1, _C2, _C3, _C4 = -1.2337005501361697, 0.25366950790104803, -0.02086348076335296, 0.0009192602748394266
_C5, _C6, _C7, _C8 = -2.5202042373060607e-05, 4.710874778818172e-07, -6.386603083791852e-09, 6.565963114979473e-11


@part
def fill_turns(particles: Floats, out: Floats) -> None:
    """Write the sines and cosines of the headings, in [-pi, pi], of poses (n, 3) into `out` (2, n or more).

    A loop without a branch or a call, good to some units in the last place of 1.
    """
    n = particles.shape[0]
    sines = out[0, :n]
    cosines = out[1, :n]
    for p in range(n):
        sines[p] = _QUARTERS * particles[p, 2]
    for p in range(n):
        q = np.floor(sines[p] + 0.5)
        r = sines[p] - q
        z = r * r
        sin = r * (_S0 + z * (_S1 + z * (_S2 + z * (_S3 + z * (_S4 + z * (_S5 + z * (_S6 + z * _S7)))))))
        cos = 1.0 + z * (_C1 + z * (_C2 + z * (_C3 + z * (_C4 + z * (_C5 + z * (_C6 + z * (_C7 + z * _C8)))))))
        is_odd = (q == 1.0) | (q == -1.0)
        is_behind = (q == 2.0) | (q == -2.0)
        x = sin if is_odd else cos
        y = cos if is_odd else sin
        cosines[p] = -x if is_behind | (q == 1.0) else x
        sines[p] = -y if is_behind | (q == -1.0) else y
