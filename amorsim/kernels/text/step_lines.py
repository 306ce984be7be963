"""What a step left of a group of robots, side by side in one line of a table."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from amorsim.kernels.compile import kernel, part

__all__ = ["keep_step"]

Array = NDArray[np.float64]


@part
def _put(values: Array, out: Array, step: int, at: int) -> int:
    for i in range(values.shape[0]):
        for j in range(values.shape[1]):
            out[step, at] = values[i, j]
            at += 1
    return at


@kernel
def keep_step(
    time: Array,
    true_pose: Array,
    true_twist: Array,
    joint_rates: Array,
    command: Array,
    pose: Array,
    covariance: Array,
    values: Array,
    step: int,
    out: Array,
) -> int:
    """Write arrays `(N,)`, `(N, k)`, `(N, 3, 3)` and `(2, V)` one after another into ``out[step]``; where they end."""
    at = 0
    for i in range(time.shape[0]):
        out[step, at] = time[i]
        at += 1
    at = _put(true_pose, out, step, at)
    at = _put(true_twist, out, step, at)
    at = _put(joint_rates, out, step, at)
    at = _put(command, out, step, at)
    at = _put(pose, out, step, at)
    for i in range(covariance.shape[0]):
        for j in range(3):
            for k in range(3):
                out[step, at] = covariance[i, j, k]
                at += 1
    return _put(values, out, step, at)
