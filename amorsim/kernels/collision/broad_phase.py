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

from amorsim.kernels.collision.body_hash import BodyHash, run_of_bodies, window
from amorsim.kernels.collision.clearance import map_gap
from amorsim.kernels.collision.paths import OTHER, SLACK, STANDS, Paths, Scene, bound_of, end_of
from amorsim.kernels.compile import kernel, part

__all__ = ["NEAR_BODY", "NEAR_WALL", "Clearance", "look_around", "set_out"]

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

NEAR_WALL = 1
NEAR_BODY = 2

# Number of steps ahead that a body looks around, at most.
AHEAD = 32.0


class Clearance(NamedTuple):
    """The known clearance of each body; kept from step to step."""

    at: Floats
    """The poses for which it holds, (T, 3). If a body is elsewhere, its whole replica is looked at again."""
    walls: Floats
    """Lower bounds of the gaps to the walls [m], (T,); 0 or less where nothing is known."""
    others: Floats
    """Lower bounds of the gaps to all other bodies of the replica [m], (T,)."""


@kernel
def set_out(
    paths: Paths, reach: Floats, replica_first: Ints, clearance: Clearance, end: Floats, fastest: Floats, looking: Ints
) -> int:
    """Let all bodies set out; returns the number of bodies whose clearance does not last for the step.

    Parameters
    ----------
    paths
        `stop` becomes 1, and `bound` is written for all forms but `OTHER`.
    reach
        Of the bodies [m], (T,).
    replica_first
        Bodies of replica r are ``replica_first[r]:replica_first[r + 1]``, (R + 1,).
    clearance
        For bodies whose clearance lasts, it becomes the rest after the step.
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
            paths.stop[i] = 1.0
            if paths.form[i] == STANDS:
                paths.bound[i] = 0.0
                for k in range(3):
                    end[i, k] = paths.start[i, k]
            else:
                if paths.form[i] != OTHER:
                    paths.bound[i] = bound_of(paths.motion[i, 0], paths.motion[i, 1], paths.motion[i, 2], reach[i])
                end[i, 0], end[i, 1], end[i, 2] = end_of(paths.start[i], paths.motion[i], paths.form[i])
            if paths.bound[i] > fastest[r] or paths.bound[i] != paths.bound[i]:  # nan stays
                fastest[r] = paths.bound[i]
            for k in range(3):
                if clearance.at[i, k] != paths.start[i, k]:
                    holds = False
        for i in range(first, last):
            if not holds:
                clearance.walls[i] = 0.0
                clearance.others[i] = 0.0
            own, both = _needed(paths.bound[i], fastest[r])
            if own > 0.0 and not (own < clearance.walls[i] and both < clearance.others[i]):
                looking[count] = i
                count += 1
            else:
                clearance.walls[i] -= own
                clearance.others[i] -= both
    return count


@part
def _needed(bound: float, fastest: float) -> tuple[float, float]:
    """The clearance to walls and to other bodies [m] that a body uses up in this step."""
    own = bound + SLACK if bound != 0.0 else 0.0
    return own, own + (fastest + SLACK)


@part
def _gap_to_others(
    start: Floats, reach: float, table: BodyHash, replica: int, owner: int, widest: float, within: float
) -> float:
    """Least gap [m] between the circle of a body and that of a body of another owner; `within` if none is nearer.

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
    fastest: Floats,
    widest: float,
    clearance: Clearance,
    near: NDArray[np.uint8],
) -> None:
    """Renew the clearance of bodies that have set out, and find which of them have something near.

    Each looks two steps ahead, and four times as far while it finds nothing, so the test is cheap in a crowd.

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
            cap = 0.5 * own
            nearest[0] = cap
            while nearest[0] == cap and cap < AHEAD * own:
                cap *= 4.0
                map_gap(grid, scene.origin_x, scene.origin_y, scene.yaw, scene.bodies, i, start, cap, edges, nearest)
            clearance.walls[i] = nearest[0]
            if nearest[0] < own:
                near[k] |= NEAR_WALL
        clearance.walls[i] -= own
        if not both < clearance.others[i]:
            within = 0.5 * both
            gap = within
            while gap == within and within < AHEAD * both:
                within *= 4.0
                gap = _gap_to_others(start, reach, by_place, replica[i], owner[i], widest, within)
            clearance.others[i] = gap
            if gap < both:
                near[k] |= NEAR_BODY
        clearance.others[i] -= both
