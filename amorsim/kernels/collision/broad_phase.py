"""The broad phase: which bodies might meet a wall or another body in this step.

Every body has a clearance: a lower bound of its gap to the walls, and one of its gap to all other bodies. Each step
subtracts the distance that the body, and the fastest body of its replica, may have moved. Only a body whose clearance
does not last for the step looks around and renews it. Bodies that are far apart therefore cost a few subtractions.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from amorsim.array_types import Array, Ints
from amorsim.kernels.collision.body_hash import BodyHash, run_of_bodies, window
from amorsim.kernels.collision.clearance import has_room, map_gap
from amorsim.kernels.collision.paths import OTHER, SLACK, STANDS, Scene, bound_of, end_of, padded
from amorsim.kernels.compile import kernel, part

__all__ = ["NEAR_BODY", "NEAR_WALL", "Clearance", "look_around", "set_out"]


NEAR_WALL = 1
NEAR_BODY = 2

# Number of steps ahead that a body looks around, at most.
AHEAD = 64.0
FAR = 32.0  # for other bodies
# Where its circle has no room for as many steps, the gap of its shape is found.
NEAR = 4.0


class Clearance(NamedTuple):
    """The known clearance of each body; kept from step to step."""

    at: Array
    """The poses for which it holds, (T, 3). If a body is elsewhere, its whole replica is looked at again."""
    walls: Array
    """Lower bounds of the gaps to the walls [m], (T,); 0 or less where nothing is known."""
    others: Array
    """Lower bounds of the gaps to all other bodies of the replica [m], (T,)."""


@kernel
def set_out(
    start: Array,
    motion: Array,
    form: NDArray[np.uint8],
    travel: Array,
    bound: Array,
    stop: Array,
    reach: Array,
    replica_first: Ints,
    at: Array,
    walls: Array,
    others: Array,
    end: Array,
    fastest: Array,
    looking: Ints,
) -> int:
    """Begin the step of all bodies; returns the number of those whose clearance does not last for it.

    Returns -1, and has written nothing of use, if a motion is not finite.

    Parameters
    ----------
    start, motion, form, bound, stop
        The paths, as in `Paths`; `stop` becomes 1, and `bound` is written.
    travel
        Bounds of the paths of form `OTHER`: length [m] and turning [rad], (T, 2).
    reach
        Of the bodies [m], (T,).
    replica_first
        Bodies of replica r are ``replica_first[r]:replica_first[r + 1]``, (R + 1,).
    at, walls, others
        The bodies' `Clearance`. For bodies whose clearance lasts, it becomes the rest after the step.
    end
        Gets the poses at the end of the step, (T, 3).
    fastest
        Gets the largest bound of each replica [m], (R,).
    looking
        Gets the bodies that have to look around, in order, (T,).
    """
    count = 0
    for r in range(fastest.shape[0]):
        first = replica_first[r]
        last = replica_first[r + 1]
        fastest[r] = 0.0
        holds = True
        for i in range(first, last):
            stop[i] = 1.0
            if not (math.isfinite(motion[i, 0]) and math.isfinite(motion[i, 1]) and math.isfinite(motion[i, 2])):
                return -1
            if form[i] == STANDS:
                bound[i] = 0.0
                for k in range(3):
                    end[i, k] = start[i, k]
            else:
                if form[i] == OTHER:
                    bound[i] = padded(travel[i, 0] + travel[i, 1] * reach[i])
                else:
                    bound[i] = bound_of(motion[i, 0], motion[i, 1], motion[i, 2], reach[i])
                end[i, 0], end[i, 1], end[i, 2] = end_of(start[i], motion[i], form[i])
            if bound[i] > fastest[r] or bound[i] != bound[i]:  # nan stays
                fastest[r] = bound[i]
            for k in range(3):
                if at[i, k] != start[i, k]:
                    holds = False
        for i in range(first, last):
            if not holds:
                walls[i] = 0.0
                others[i] = 0.0
            own, both = _needed(bound[i], fastest[r])
            if own > 0.0 and not (own < walls[i] and both < others[i]):
                looking[count] = i
                count += 1
            else:
                walls[i] -= own
                others[i] -= both
    return count


@part
def _needed(bound: float, fastest: float) -> tuple[float, float]:
    """The clearance [m] to walls and other bodies that a body uses up in this step."""
    own = bound + SLACK if bound != 0.0 else 0.0
    return own, own + (fastest + SLACK)


@part
def _gap_to_others(
    start: Array, reach: float, table: BodyHash, replica: int, owner: int, widest: float, within: float
) -> float:
    """The least gap [m] between the circle of a body and that of another owner's body; `within` if none is nearer.

    The circle has the radius `reach` about `start` (3,), and no body reaches farther than `widest`.
    """
    x = start[0]
    y = start[1]
    half = reach + widest + within
    row0, rows = window(y, half, table.side, table.rows)
    col0, cols = window(x, half, table.side, table.cols)
    least = within
    if rows == table.rows and cols == table.cols:  # all are in the window
        least = math.inf
    for run in range(2 * rows if col0 + cols > table.cols else rows):
        first, end = run_of_bodies(table, replica, row0, rows, col0, cols, run)
        for place in range(first, end):
            if table.owner[place] == owner:
                continue
            dx = x - table.disc[place, 0]
            dy = y - table.disc[place, 1]
            gap = math.sqrt(dx * dx + dy * dy) - (reach + table.disc[place, 2])
            if gap < least:
                least = gap
    return least


@kernel
def look_around(
    first: int,
    last: int,
    looking: Ints,
    scene: Scene,
    replica: Ints,
    owner: Ints,
    by_place: BodyHash,
    fastest: Array,
    widest: float,
    clearance: Clearance,
    near: NDArray[np.uint8],
) -> None:
    """Renew the clearance of bodies that have set out, and find which of them have something near.

    For walls, each looks for room around its circle, farther first, and only without any for the gap of its shape. For
    other bodies, each looks two steps ahead, and four times as far while it finds nothing, which is cheap in a crowd.

    Parameters
    ----------
    first, last
        Entries of `looking` to process: each writes only its own results, so threads may share them.
    looking
        Bodies that move, (L,).
    scene
        The map and the bodies on their paths.
    replica, owner
        (T,): which replica each body is of, and which body it is a part of, or itself.
    by_place
        The bodies where they start.
    fastest
        The largest bound of each replica [m], (R,).
    widest
        Of all bodies the largest reach [m].
    clearance
        Of these bodies, what is left after the step is written.
    near
        Gets `NEAR_WALL` where the body may meet a wall, `NEAR_BODY` where it may meet another body, both or 0, (L,).
    """
    paths = scene.paths
    grid = scene.grid
    edges = np.empty((scene.edge_rows, 5))
    nearest = np.empty(3)
    for k in range(first, last):
        i = looking[k]
        start = paths.start[i]
        reach = scene.bodies.reach[i]
        own, both = _needed(paths.bound[i], fastest[replica[i]])
        near[k] = 0
        if not own < clearance.walls[i]:
            room = AHEAD * own
            while room > NEAR * own and not has_room(
                grid, scene.origin_x, scene.origin_y, scene.yaw, reach, start, room
            ):
                room *= 0.5
            if room <= NEAR * own:
                map_gap(grid, scene.origin_x, scene.origin_y, scene.yaw, scene.bodies, i, start, room, edges, nearest)
                room = nearest[0]
            clearance.walls[i] = room
            if room < own:
                near[k] |= NEAR_WALL
        clearance.walls[i] -= own
        if not both < clearance.others[i]:
            within = 0.5 * both
            gap = within
            while gap == within and within < FAR * both:
                within *= 4.0
                gap = _gap_to_others(start, reach, by_place, replica[i], owner[i], widest, within)
            clearance.others[i] = gap
            if gap < both:
                near[k] |= NEAR_BODY
        clearance.others[i] -= both
