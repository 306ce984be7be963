"""The paths of bodies through a step: the pose at a fraction of it, and a bound of the distance travelled.

Most paths are arcs, the exponential of a constant twist, or straight lines along which the heading turns evenly. The
arithmetic of a pose is that of `amorsim.kernels.kinematics.poses`, so a path followed here and one composed there give
the same bits.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from amorsim.array_types import Array, Ints
from amorsim.kernels.collision.footprints import Bodies
from amorsim.kernels.compile import kernel
from amorsim.kernels.grid.grid import Grid
from amorsim.kernels.kinematics.poses import arc, displaced

__all__ = [
    "ARC",
    "LEAST",
    "LINE",
    "OTHER",
    "SLACK",
    "STANDS",
    "Paths",
    "Scene",
    "bound_of",
    "end_of",
    "padded",
    "pose_at",
    "poses_at",
]


# Forms of a path.
STANDS = 0
ARC = 1
LINE = 2
OTHER = 3  # only the mover knows it, in Python

# The slack by which a gap must exceed what the bodies can still travel before it counts as safe: rounding of poses
# in a world of some kilometres.
SLACK = 1e-9  # [m]
# A body that travels less than this, which is less than rounding, stands still and keeps its pose to the bit.
LEAST = 1e-15  # [m]


class Paths(NamedTuple):
    """The paths of bodies 0 to T - 1 through a step."""

    start: Array
    """Poses at the start, (T, 3)."""
    motion: Array
    """For an arc, the twist over the whole step; for others, the displacement, in the body's frame, (T, 3)."""
    form: NDArray[np.uint8]
    """`STANDS`, `ARC`, `LINE` or `OTHER`, (T,)."""
    bound: Array
    """A part f of the step takes no point of a body farther than f times this [m], (T,)."""
    stop: Array
    """The fraction of the step after which each body stands still, 1 if it meets nothing, (T,)."""


class Scene(NamedTuple):
    """The cells of a map, the pose of its lower left corner, and bodies on their paths."""

    grid: Grid
    origin_x: float
    origin_y: float
    yaw: float
    bodies: Bodies
    edge_rows: int
    """Vertices of the largest body: the rows that scratch arrays need."""
    paths: Paths


@kernel
def pose_at(paths: Paths, body: int, fraction: float, out: Array) -> None:
    """Write the pose (3,) of a body at a fraction of the step; if it stopped before, where it stopped.

    On a path of form `OTHER` only fraction 0 is right.
    """
    start = paths.start
    f = min(fraction, paths.stop[body])
    x = start[body, 0]
    y = start[body, 1]
    heading = start[body, 2]
    if f > 0.0 and paths.bound[body] > 0.0:
        ahead = paths.motion[body, 0]
        left = paths.motion[body, 1]
        turn = paths.motion[body, 2]
        if paths.form[body] == ARC:
            ahead, left, turn = arc(ahead, left, turn, f)
        else:
            ahead, left, turn = ahead * f, left * f, turn * f
        x, y, heading = displaced(x, y, heading, ahead, left, turn)
    out[0] = x
    out[1] = y
    out[2] = heading


@kernel
def poses_at(paths: Paths, bodies: Ints, fraction: Array, out: Array) -> None:
    """Write the poses (Q, 3) of bodies (Q,) at fractions (Q,) of the step; see `pose_at`."""
    for q in range(out.shape[0]):
        pose_at(paths, bodies[q], fraction[q], out[q])


@kernel
def bound_of(ahead: float, left: float, turn: float, reach: float) -> float:
    """Upper bound [m] of the distance that any point of a body with this reach travels along an arc or a line."""
    return padded(math.sqrt(ahead * ahead + left * left) + abs(turn) * reach)


@kernel
def padded(travel: float) -> float:
    """A bound of a way [m] with a margin for rounding; 0 for a body that stands still."""
    return 0.0 if travel < LEAST else travel * (1.0 + 1e-9)


@kernel
def end_of(start: Array, motion: Array, form: int) -> tuple[float, float, float]:
    """The pose at the end of a path from `start` (3,)."""
    ahead = motion[0]
    left = motion[1]
    turn = motion[2]
    if form == ARC:
        ahead, left, turn = arc(ahead, left, turn, 1.0)
    return displaced(start[0], start[1], start[2], ahead, left, turn)
