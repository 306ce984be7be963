"""How bodies set out: where they go if they meet nothing, and who has to look closer, in one pass over rows.

Most bodies have neither a wall nor another body within a step's reach. That is found here for each row by itself, so
threads may share the rows; the others are looked at pair by pair (`amorsim.kernels.collision.time_of_impact`).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from amorsim.kernels.collision.body_hash import BodyHash, run_of_bodies, window
from amorsim.kernels.collision.clearance import map_gap
from amorsim.kernels.collision.paths import OTHER, SLACK, STANDS, Paths, Scene, bound_of, set_out_alone
from amorsim.kernels.compile import kernel, part

__all__ = ["NEAR_BODY", "NEAR_WALL", "look_out"]

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
def look_out(
    first: int,
    last: int,
    scene: Scene,
    replica: Ints,
    owner: Ints,
    by_place: BodyHash,
    end: Floats,
    near: NDArray[np.uint8],
) -> None:
    """What `paths.set_out` does for bodies first..last-1, and which of them have something near.

    Parameters
    ----------
    first, last
        The bodies that are worked on.
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
    paths = scene.paths
    reach = scene.bodies.reach
    edges = np.empty((scene.edge_rows, 5))
    nearest = np.empty(3)
    for i in range(first, last):
        set_out_alone(paths, i, reach[i], end[i])
        bound = paths.bound[i]
        told = NEAR_BODY if _may_meet(paths, reach, by_place, replica[i], owner[i], i, bound) else 0
        if bound > 0.0:
            cap = bound + SLACK
            start = paths.start[i]
            map_gap(scene.grid, scene.origin_x, scene.origin_y, scene.yaw, scene.bodies, i, start, cap, edges, nearest)
            if nearest[0] < cap:
                told |= NEAR_WALL
        near[i] = told
