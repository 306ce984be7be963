"""A step of robots on two driven wheels whom nothing is in the way: their wheels and their bodies in one call."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from amorsim.kernels.compile import kernel
from amorsim.kernels.odometry import drive_wheels, wheel_twists
from amorsim.kernels.paths import ARC, go_free
from amorsim.kernels.poses import mean_twists

__all__ = ["roll_free"]

Floats = npt.NDArray[np.float64]
# A component's parameter over rows, (N, 1) float64; declared as the number that it is for one row.
Column = Any


@kernel
def roll_free(
    joints: Floats,
    rates: Floats,
    command: Floats,
    rate_max: Column,
    acceleration_max: Column,
    lag: Column,
    radius_left: Column,
    radius_right: Column,
    track: Column,
    dt: float,
    start: Floats,
    reach: Floats,
    room: Floats,
    wheels: Floats,
    end: Floats,
    twists: Floats,
) -> bool:
    """Whether all have room for the whole step; if so it is made, else only `wheels` is written.

    Parameters
    ----------
    joints, rates, command, rate_max, acceleration_max, lag
        As `odometry.drive_wheels` takes them.
    radius_left, radius_right, track
        As `odometry.wheel_twists` takes them.
    start, reach, room
        As `paths.go_free` takes them.
    wheels
        (2, N, 2) gets the wheels' angles [rad] and rates [rad/s] a step later.
    end, twists
        (N, 3) get the poses at the end of the step, and the mean velocities [m/s, m/s, rad/s] on the way.
    """
    rows = start.shape[0]
    motion = np.empty((rows, 3))
    stop = np.empty(rows)
    drive_wheels(joints, rates, command, rate_max, acceleration_max, lag, dt, wheels)
    wheel_twists(joints, wheels[0], radius_left, radius_right, track, motion)
    if not go_free(start, motion, ARC, reach, room, end, stop):
        return False
    mean_twists(motion, stop, dt, twists)
    return True
