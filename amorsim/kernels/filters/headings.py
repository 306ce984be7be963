"""Sines and cosines of the headings of particles, many at a time."""

from __future__ import annotations

import math

import numpy as np

from amorsim.array_types import Array
from amorsim.kernels.compile import part
from amorsim.kernels.random.quarter_turns import cosine_of_quarters, sine_of_quarters

__all__ = ["fill_turns"]


_QUARTERS = 2.0 / math.pi  # of a turn in a radian


@part
def fill_turns(particles: Array, out: Array) -> None:
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
        sin = sine_of_quarters(r)
        cos = cosine_of_quarters(r)
        is_odd = (q == 1.0) | (q == -1.0)
        is_behind = (q == 2.0) | (q == -2.0)
        x = sin if is_odd else cos
        y = cos if is_odd else sin
        cosines[p] = -x if is_behind | (q == 1.0) else x
        sines[p] = -y if is_behind | (q == -1.0) else y
