"""A step of robots on two driven wheels whom nothing is in the way: their wheels and their bodies."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from amorsim.kernels.compile import kernel
from amorsim.kernels.odometry import drive_wheels, wheel_twists
from amorsim.kernels.paths import ARC, go_free
from amorsim.kernels.poses import mean_twists

__all__ = ["ROLLING", "roll_free"]

Floats = npt.NDArray[np.float64]

ROLLING = 7
"""Numbers of a robot that rolls: the greatest rate and acceleration of a wheel, and its lag, the left and the right
wheel's radius, the track, and how far the body reaches."""


@kernel
def roll_free(
    joints: Floats,
    rates: Floats,
    command: Floats,
    numbers: Floats,
    dt: float,
    start: Floats,
    room: Floats,
    wheels: Floats,
    end: Floats,
    twists: Floats,
) -> bool:
    """Whether all have room for the whole step; if so it is made, else only `wheels` is written.

    Parameters
    ----------
    joints, rates, command
        As `odometry.drive_wheels` takes them.
    numbers
        (ROLLING, N, 1), as `drive_wheels`, `odometry.wheel_twists` and `paths.go_free` take them.
    start, room
        As `paths.go_free` takes them.
    wheels
        (2, N, 2) gets the wheels' angles [rad] and rates [rad/s] a step later.
    end, twists
        (N, 3) get the poses at the end of the step, and the mean velocities [m/s, m/s, rad/s] on the way.
    """
    rows = start.shape[0]
    motion = np.empty((rows, 3))
    stop = np.empty(rows)
    drive_wheels(joints, rates, command, numbers[0], numbers[1], numbers[2], dt, wheels)
    wheel_twists(joints, wheels[0], numbers[3], numbers[4], numbers[5], motion)
    if not go_free(start, motion, ARC, numbers[6].reshape(rows), room, end, stop):
        return False
    mean_twists(motion, stop, dt, twists)
    return True
