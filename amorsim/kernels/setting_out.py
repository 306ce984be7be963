"""How bodies set out: where they go if they meet nothing, and who has to look closer, in one pass over rows.

Most bodies have neither a wall nor another body within a step's reach. So much is told here of each row by itself, and
by threads side by side; who is left is looked at pair by pair (`amorsim.kernels.meeting`).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from amorsim.kernels.body_hash import BodyHash, run_of_bodies, window
from amorsim.kernels.compile import kernel, part
from amorsim.kernels.contact import map_gap
from amorsim.kernels.odometry import drive_wheels, wheel_twists
from amorsim.kernels.paths import OTHER, SLACK, STANDS, Paths, Scene, bound_of, set_out_alone
from amorsim.kernels.poses import mean_twists
from amorsim.kernels.shares import offer, spread, take_rows

__all__ = ["NEAR_BODY", "NEAR_WALL", "look_out", "roll_out"]

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

NEAR_WALL = 1
NEAR_BODY = 2


@part
def _bound(paths: Paths, body: int, reach: float) -> float:
    """How far [m] any point of a body can come, whether it has set out already or not."""
    if paths.form[body] == STANDS:
        return 0.0
    if paths.form[body] == OTHER:
        return float(paths.bound[body])
    return bound_of(paths.motion[body, 0], paths.motion[body, 1], paths.motion[body, 2], reach)


@part
def _may_meet(paths: Paths, reach: Floats, table: BodyHash, replica: int, owner: int, i: int, bound: float) -> bool:
    """Whether the circle of body i, grown by how far it can come, meets one of another owner that is not wider."""
    radius = reach[i] + (bound + SLACK)
    x = paths.start[i, 0]
    y = paths.start[i, 1]
    row0, rows = window(y, 2.0 * radius, table.side, table.rows)
    col0, cols = window(x, 2.0 * radius, table.side, table.cols)
    for run in range(2 * rows if col0 + cols > table.cols else rows):
        first, end = run_of_bodies(table, replica, row0, rows, col0, cols, run)
        for place in range(first, end):
            dx = x - table.disc[place, 0]
            dy = y - table.disc[place, 1]
            square = dx * dx + dy * dy
            j = table.body[place]
            if square > (2.0 * radius) * (2.0 * radius) or table.owner[place] == owner:
                continue
            other = reach[j] + (_bound(paths, j, reach[j]) + SLACK)
            if other <= radius and square <= (radius + other) * (radius + other):
                return True
    return False


@kernel
def _look(
    share: int,
    scene: Scene,
    replica: Ints,
    owner: Ints,
    by_place: BodyHash,
    end: Floats,
    near: NDArray[np.uint8],
    twists: Floats,
    dt: float,
) -> None:
    """The share of a thread of `look_out`, or of `roll_out` where there are `twists` to be written."""
    paths = scene.paths
    reach = scene.bodies.reach
    edges = np.empty((scene.edge_rows, 5))
    nearest = np.empty(3)
    rows = end.shape[0]
    first, last = take_rows(share, rows, 0)
    while first < last:
        for i in range(first, last):
            set_out_alone(paths, i, reach[i], end[i])
            bound = paths.bound[i]
            told = NEAR_BODY if _may_meet(paths, reach, by_place, replica[i], owner[i], i, bound) else 0
            if bound > 0.0:
                cap = bound + SLACK
                start = paths.start[i]
                map_gap(
                    scene.grid, scene.origin_x, scene.origin_y, scene.yaw, scene.bodies, i, start, cap, edges, nearest
                )
                if nearest[0] < cap:
                    told |= NEAR_WALL
            near[i] = told
        if twists.shape[0] > 0:
            mean_twists(scene.paths.motion[first:last], scene.paths.stop[first:last], dt, twists[first:last])
        first, last = take_rows(share, rows, last)


@kernel
def _look_together(
    share: int,
    scene: Scene,
    replica: Ints,
    owner: Ints,
    by_place: BodyHash,
    end: Floats,
    near: NDArray[np.uint8],
    twists: Floats,
    dt: float,
) -> int:
    """What all threads make of that, or the one; how many have something near."""
    given = (scene, replica, owner, by_place, end, near, twists, dt)
    spread(share, end.shape[0], offer(_look, given))
    found = 0
    for i in range(near.shape[0]):
        found += near[i] != 0
    return found


@kernel
def look_out(
    share: int, scene: Scene, replica: Ints, owner: Ints, by_place: BodyHash, end: Floats, near: NDArray[np.uint8]
) -> int:
    """What `paths.set_out` does, and who has something near: a wall, or a body in its replica; how many have.

    Parameters
    ----------
    share
        `ALONE`, or for `shares.spread`.
    scene
        The map and the bodies on their paths; `stop` and, but for paths of another form, `bound` are written.
    replica, owner
        (T,): which replica each body is of, and which body it is a part of, or itself.
    by_place
        The bodies where they start.
    end
        Gets the poses at the end of the step, (T, 3).
    near
        Gets `NEAR_WALL`, where a body that moves may meet one, and `NEAR_BODY`, where the circle of a body, grown by
        how far it can come, meets that of one that is not wider; or both or neither, (T,).
    """
    return _look_together(share, scene, replica, owner, by_place, end, near, np.empty((0, 3)), 0.0)


@kernel
def roll_out(
    share: int,
    scene: Scene,
    replica: Ints,
    owner: Ints,
    by_place: BodyHash,
    joints: Floats,
    rates: Floats,
    command: Floats,
    numbers: Floats,
    dt: float,
    wheels: Floats,
    twists: Floats,
    end: Floats,
    near: NDArray[np.uint8],
) -> int:
    """What `look_out` does, of robots on two driven wheels that follow a command; and how they move on the way.

    Parameters
    ----------
    share, scene, ..., near
        As `look_out` takes them; of the paths, which are arcs, `motion` is written too.
    joints, rates, command
        As `odometry.drive_wheels` takes them.
    numbers
        (6 or more, N, 1), as `drive_wheels` and `odometry.wheel_twists` take them.
    dt
        [s].
    wheels
        (2, N, 2) gets the wheels' angles [rad] and rates [rad/s] a step later.
    twists
        (N, 3) gets the mean velocities [m/s, m/s, rad/s] of those that meet nothing.
    """
    motion = scene.paths.motion
    # Of all at once, for whoever looks for others must know how far they come.
    drive_wheels(joints, rates, command, numbers[0], numbers[1], numbers[2], dt, wheels)
    wheel_twists(joints, wheels[0], numbers[3], numbers[4], numbers[5], motion)
    return _look_together(share, scene, replica, owner, by_place, end, near, twists, dt)
