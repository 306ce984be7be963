"""What wheel noise in terms of the body's motion needs: two wheels, and the distance between them."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from amorsim.contracts import Context
from amorsim.core.errors import ComponentError

__all__ = ["per_interval", "track_of", "with_motion_error"]

Array = npt.NDArray[np.float64]


def per_interval(interval: float | None, elapsed: Array) -> Array:
    """What a variance per step is multiplied by `(N, 1)` in a step of `elapsed` [s], if it is meant for `interval`.

    The squares of way and turn in it fall with the square of the step, the number of steps rises with its
    inverse: the share of a step must rise with the inverse too, for all of them to add up to the same.
    """
    if interval is None:
        return np.ones_like(elapsed)
    return np.where(elapsed > 0.0, interval / np.where(elapsed > 0.0, elapsed, 1.0), 1.0)


def track_of(element: str, context: Context) -> Array:
    """The nominal distance between the wheels [m] `(N, 1)` of a drive with two wheels on one axle.

    Raises
    ------
    ComponentError
        For any other drive: which of its joints turn the body, and how far, cannot be told from here.
    """
    drive = context.robot.drive
    track = getattr(drive, "track", None)
    if context.size != 2 or sum(joint.rolls for joint in drive.joints) != 2 or track is None:
        raise ComponentError(
            f"{element}: expected the ground of a differential drive (two joints that roll, and a track), got "
            f"{type(drive).__name__} with {context.size} values; take diffusion or gaussian, wheel by wheel"
        )
    return np.array(np.broadcast_to(track, (context.rows, 1)), dtype=np.float64)


def with_motion_error(travel: Array, forward: Array, turn: Array, track: Array) -> Array:
    """Travels (left, right) `(N, 2)` [m] of wheels whose body goes `forward` [m] and turns by `turn` [rad] more.

    Both errors are `(N, 1)`; where they are 0 the travels keep their bits.
    """
    half = 0.5 * track * turn
    # Taking +0.0 away keeps even the sign of a zero, which adding it would not.
    return travel - (0.0 - np.concatenate((forward - half, forward + half), axis=1))
