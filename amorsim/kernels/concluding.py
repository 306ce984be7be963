"""The end of a step of robots on two wheels: where they believe to be, and the fingerprint of all results."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from amorsim.kernels.compile import kernel
from amorsim.kernels.digest import absorb_together
from amorsim.kernels.odometry import reckon_wheels

__all__ = ["conclude"]

Floats = NDArray[np.float64]
# A component's parameter over rows, (N, 1) float64; declared as the number that it is for one row.
Column = Any


@kernel
def conclude(
    first: int,
    counts_per_revolution: Floats,
    radius_left: Column,
    radius_right: Column,
    track: Column,
    variance: Column,
    pose: Floats,
    covariance: Floats,
    before: Floats,
    after: Floats,
    out: Floats,
    grown: Floats,
    true_pose: Floats,
    joints: Floats,
    command: Floats,
    sizes: NDArray[np.int64],
    true: Floats,
    measured: Floats,
    begin: int,
    end: int,
    fingerprint: NDArray[np.uint64],
) -> None:
    """Reckon as `odometry.reckon_wheels`, by counts that begin at `measured[first]`, and absorb what the step gave.

    That is true poses, joints, commands and the estimate, and of all devices what they truly and really read, as
    `digest.absorb_together` takes them. Rows begin..end-1 are worked on.
    """
    rows = pose.shape[0]
    counts = measured[first : first + 2 * rows].reshape((rows, 2))
    reckon_wheels(
        counts[begin:end],
        counts_per_revolution[begin:end],
        radius_left[begin:end],
        radius_right[begin:end],
        track[begin:end],
        variance[begin:end],
        pose[begin:end],
        covariance[begin:end],
        before[begin:end],
        after[begin:end],
        out[begin:end],
        grown[begin:end],
    )
    flat = grown.reshape((rows, 9))
    absorb_together(true_pose, joints, command, out, flat, sizes, true, measured, begin, end, fingerprint)
