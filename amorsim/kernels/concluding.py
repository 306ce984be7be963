"""The end of a step of robots on two wheels: where they believe to be, and the fingerprint of all results."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from amorsim.kernels.compile import kernel, part
from amorsim.kernels.digest import absorb_rows
from amorsim.kernels.odometry import reckon_rows

__all__ = ["conclude"]

Floats = NDArray[np.float64]
# A component's parameter over rows, (N, 1) float64; declared as the number that it is for one row.
Column = Any


@part
def _conclude_rows(
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
    one: Floats,
    other: Floats,
    jacobian: Floats,
    both: NDArray[np.int64],
    fingerprint: NDArray[np.uint64],
) -> None:
    """What `conclude` does, with room to work in."""
    rows = pose.shape[0]
    counts = measured[first : first + 2 * rows].reshape((rows, 2))
    reckon_rows(
        counts,
        counts_per_revolution,
        radius_left,
        radius_right,
        track,
        variance,
        pose,
        covariance,
        before,
        after,
        begin,
        end,
        one,
        other,
        jacobian,
        both,
        out,
        grown,
    )
    flat = grown.reshape((rows, 9))
    absorb_rows(true_pose, joints, command, out, flat, sizes, true, measured, begin, end, fingerprint)


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
    _conclude_rows(
        first,
        counts_per_revolution,
        radius_left,
        radius_right,
        track,
        variance,
        pose,
        covariance,
        before,
        after,
        out,
        grown,
        true_pose,
        joints,
        command,
        sizes,
        true,
        measured,
        begin,
        end,
        np.empty(2),
        np.empty(2),
        np.empty((3, 2)),
        np.empty(2, dtype=np.int64),
        fingerprint,
    )
