"""The end of a step of robots on two wheels: where they believe to be, and the fingerprint of all results."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from amorsim.kernels.compile import kernel, part
from amorsim.kernels.digest import absorb_rows
from amorsim.kernels.odometry import reckon_rows
from amorsim.kernels.sensing import SIZES

__all__ = ["RECKONING", "conclude"]

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

RECKONING = 6
"""Numbers of a robot that reckons: the left and the right wheel's radius, the track, the variance of a wheel's travel,
and the counts in a turn of each wheel."""


@part
def _conclude_rows(
    at: int,
    numbers: Floats,
    pose: Floats,
    covariance: Floats,
    before: Floats,
    after: Floats,
    out: Floats,
    grown: Floats,
    true_pose: Floats,
    joints: Floats,
    command: Floats,
    ints: Ints,
    true: Floats,
    measured: Floats,
    first: int,
    end: int,
    room: Floats,
    both: Ints,
    fingerprint: NDArray[np.uint64],
) -> None:
    """What `conclude` does, with room to work in."""
    rows = pose.shape[0]
    reckon_rows(
        measured[at : at + 2 * rows].reshape((rows, 2)),
        numbers[4:].reshape((rows, 2)),
        numbers[0],
        numbers[1],
        numbers[2],
        numbers[3],
        pose,
        covariance,
        before,
        after,
        first,
        end,
        room[0:2],
        room[2:4],
        room[4:10].reshape((3, 2)),
        both,
        out,
        grown,
    )
    flat = grown.reshape((rows, 9))
    sizes = ints[ints[SIZES] : ints[SIZES + 1]]
    absorb_rows(true_pose, joints, command, out, flat, sizes, true, measured, first, end, fingerprint)


@kernel
def conclude(
    at: int,
    numbers: Floats,
    pose: Floats,
    covariance: Floats,
    before: Floats,
    after: Floats,
    out: Floats,
    grown: Floats,
    true_pose: Floats,
    joints: Floats,
    command: Floats,
    ints: Ints,
    true: Floats,
    measured: Floats,
    first: int,
    end: int,
    fingerprint: NDArray[np.uint64],
) -> None:
    """Reckon as `odometry.reckon_wheels`, by counts that begin at `measured[at]`, and absorb what the step gave.

    That is true poses, joints, commands and the estimate, and of all devices of a plan (`ints`, see `sensing.lay`) what
    they truly and really read, as `digest.absorb_together` takes them. `numbers` (RECKONING, N, 1) ends with the counts
    of row 0. Rows first..end-1 are worked on.
    """
    room = np.empty(10)
    both = np.empty(2, dtype=np.int64)
    _conclude_rows(
        at,
        numbers,
        pose,
        covariance,
        before,
        after,
        out,
        grown,
        true_pose,
        joints,
        command,
        ints,
        true,
        measured,
        first,
        end,
        room,
        both,
        fingerprint,
    )
