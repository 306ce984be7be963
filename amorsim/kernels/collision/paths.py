"""The paths of bodies through a step: where each is at a fraction of it, and how far it can have come.

Most paths are arcs, the exponential of a constant twist, or straight lines along which the heading turns evenly. The
arithmetic of a pose is that of `amorsim.kernels.kinematics.poses`, so a path followed here and one composed there give
the same bits.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

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
    "go_free",
    "pose_at",
    "poses_at",
    "set_out",
    "set_out_alone",
]

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

# Forms of a path.
STANDS = 0
ARC = 1
LINE = 2
OTHER = 3  # known to Python only

# The slack by which a gap must exceed what the bodies can still travel before it counts as safe: rounding of poses
# in a world of some kilometres.
SLACK = 1e-9  # [m]
# Whoever travels less than this, which is less than rounding, stands still, and keeps his place to the bit.
LEAST = 1e-15  # [m]


class Paths(NamedTuple):
    """The paths of bodies 0 to T - 1 through a step."""

    start: Floats
    """Poses at the start, (T, 3)."""
    motion: Floats
    """Of an arc the twist over the whole step, of others the displacement, in the body's frame, (T, 3)."""
    form: NDArray[np.uint8]
    """`STANDS`, `ARC`, `LINE` or `OTHER`, (T,)."""
    bound: Floats
    """A part f of the step takes no point of a body farther than f times this [m], (T,)."""
    stop: Floats
    """The fraction of the step after which each body stands still, 1 if it meets nothing, (T,)."""


class Scene(NamedTuple):
    """All there is to meet: the cells of a map, where it lies, and bodies on their paths."""

    grid: Grid
    origin_x: float
    origin_y: float
    yaw: float
    bodies: Bodies
    edge_rows: int
    """Vertices of the largest body: the rows that scratch arrays need."""
    paths: Paths


@kernel
def pose_at(paths: Paths, body: int, fraction: float, out: Floats) -> None:
    """Write the pose (3,) of a body at a fraction of the step; of one that stopped before, where it stopped.

    On a path of another form that is right for fractions 0 and 1 only.
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
def poses_at(paths: Paths, bodies: Ints, fraction: Floats, out: Floats) -> None:
    """Write the poses (Q, 3) of bodies (Q,) at fractions (Q,) of the step, as `pose_at` does."""
    for q in range(out.shape[0]):
        pose_at(paths, bodies[q], fraction[q], out[q])


@kernel
def bound_of(ahead: float, left: float, turn: float, reach: float) -> float:
    """How far [m] any point of a body that reaches so far can come along an arc or a line."""
    travel = math.sqrt(ahead * ahead + left * left) + abs(turn) * reach
    return 0.0 if travel < LEAST else travel * (1.0 + 1e-9)


@kernel
def _end(start: Floats, motion: Floats, form: int) -> tuple[float, float, float]:
    """The pose at the end of a path from `start` (3,)."""
    ahead = motion[0]
    left = motion[1]
    turn = motion[2]
    if form == ARC:
        ahead, left, turn = arc(ahead, left, turn, 1.0)
    return displaced(start[0], start[1], start[2], ahead, left, turn)


@kernel
def set_out_alone(paths: Paths, i: int, reach: float, end: Floats) -> None:
    """What `set_out` does for one body."""
    paths.stop[i] = 1.0
    if paths.form[i] == STANDS:
        paths.bound[i] = 0.0
        for k in range(3):
            end[k] = paths.start[i, k]
        return
    if paths.form[i] != OTHER:
        paths.bound[i] = bound_of(paths.motion[i, 0], paths.motion[i, 1], paths.motion[i, 2], reach)
    end[0], end[1], end[2] = _end(paths.start[i], paths.motion[i], paths.form[i])


@kernel
def set_out(paths: Paths, reach: Floats, end: Floats) -> None:
    """Write 1 to every `stop`, the `bound` of all paths but those of another form, which have theirs, and the ends.

    `reach` is the bodies' (T,) [m]; `end` gets the poses at the end of the step, (T, 3).
    """
    for i in range(reach.shape[0]):
        set_out_alone(paths, i, reach[i], end[i])


@kernel
def go_free(start: Floats, motion: Floats, form: int, reach: Floats, room: Floats, end: Floats, stop: Floats) -> bool:
    """Whether all bodies, on paths of one form, have room for the whole step; if so it is made, else nothing is told.

    Parameters
    ----------
    start, motion, reach
        As in `Paths` and `Bodies`, (T, 3), (T, 3) and (T,).
    form
        `ARC` or `LINE`.
    room
        How far [m] each can go and meet no wall, (T,); what is left of it afterwards.
    end, stop
        Get the poses at the end of the step (T, 3), and 1, (T,).
    """
    for i in range(reach.shape[0]):
        bound = bound_of(motion[i, 0], motion[i, 1], motion[i, 2], reach[i])
        if not (bound <= 0.0 or bound + SLACK < room[i]):  # so nan has no room
            return False
        stop[i] = bound
    for i in range(reach.shape[0]):
        if stop[i] > 0.0:
            room[i] -= stop[i] + SLACK
        stop[i] = 1.0
        end[i, 0], end[i, 1], end[i, 2] = _end(start[i], motion[i], form)
    return True
