"""Poses of a sensor whose beams are not all taken at the same instant."""

from __future__ import annotations

import numpy as np

from amorsim.array_types import Array
from amorsim.core.poses import compose, exponential, relative

__all__ = ["poses_at"]


def poses_at(body_pose: Array, twist: Array, poses: Array, time: Array) -> Array:
    """World poses `(N * k, 3)`, at `time` `(N, k)` [s] from now, of points fixed to the body and now at `poses`.

    The body is now at `body_pose` `(N, 3)`, and is assumed to move with `twist` `(N, 3)`, the mean velocity of its last
    step. This is exact within that step if the drive keeps its twist constant. Where the time is 0, poses keep their
    bits.
    """
    k = time.shape[1]
    body = np.repeat(body_pose, k, axis=0)
    velocity = np.repeat(twist, k, axis=0)
    when = np.ascontiguousarray(time).reshape(-1, 1)
    there = compose(compose(body, exponential(velocity, when)), relative(body, poses))
    return np.where(when == 0.0, poses, there)
