"""When bodies on their paths first meet walls and one another, and who stops where.

A contact is found by conservative advancement: no point of a body travels farther in a part of the step than that part
of its path's bound, so a gap cannot close sooner. `amorsim.simulation.contact.resolve` does the same in NumPy,
operation for operation, for paths of other forms, and both give the same bits.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from amorsim.kernels.collision.clearance import map_gap
from amorsim.kernels.collision.footprints import body_gap
from amorsim.kernels.collision.paths import SLACK, Scene, pose_at
from amorsim.kernels.compile import kernel

__all__ = ["FINEST", "MOST_LOOKS", "ROUNDING", "TOUCH", "WALL", "resolve"]

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

WALL = -1
# What poses and gaps are uncertain by, from rounding, some metres from the origin.
ROUNDING = 4e-15  # [m]
# Fractions that differ by less travel than this lead to the same pose: no coordinate within a world changes by it.
FINEST = 1e-18  # [m]
# A wall that a body stopped at is nearer than this.
TOUCH = 0.01  # [m]
# So often a pair is looked at in one step: enough for a hundred metres along a wall, touching it, in cells of 1 mm.
MOST_LOOKS = 400_000


# What a look at a pair is for.
_FIRST = 0  # how far they are apart at first
_AHEAD = 1  # whether they are free where they cannot have met before
_GAP = 2  # how far they are apart where they are last known to be free
_SLOPE = 3  # how fast that gap closes
_PROBE = 4  # whether they are free between there and where they overlap
_POINT = 5  # where they touch


class Scratch(NamedTuple):
    """Room for one query."""

    pose_a: Floats
    pose_b: Floats
    nearest: Floats
    edges_a: Floats
    edges_b: Floats
    known: Floats
    """Poses of a pair that are known to be free, then such that overlap: x, y, heading of both, (2, 6)."""


@kernel
def _meet(scene: Scene, scratch: Scratch, a: int, b: int, since: float, shortest: float, point: Floats) -> float:
    """The last free fraction before two first overlap, from `since` on, inf if never; writes the point [m] (2,).

    It is nan where that takes more than `MOST_LOOKS`.

    One loop of looks, as the code for a look is long: first ahead as far as the gap is safe. Then the bracket is
    squeezed, three times, to about a width on either side of where the gap's slope puts the contact: the gap closes
    nearly evenly so close to it, and halving alone, which comes last, takes many more looks. Close to a contact many
    fractions lead to the same poses, and the answers of two sets of poses are remembered.
    """
    bodies = scene.bodies
    paths = scene.paths
    pose_a = scratch.pose_a
    pose_b = scratch.pose_b
    known = scratch.known
    speed = paths.bound[a] if since < paths.stop[a] else 0.0
    if b != WALL and since < paths.stop[b]:
        speed += paths.bound[b]
    if not speed > 0.0:
        return math.inf
    free = since
    hit = math.inf
    gap = 0.0
    gap_is_of = since
    guess = since
    width = 0.0
    margin = 0.0
    step = 0
    looks = 0
    fraction = since
    purpose = _FIRST
    while True:
        pose_at(paths, a, fraction, pose_a)
        if b != WALL:
            pose_at(paths, b, fraction, pose_b)
        look = math.nan
        if purpose == _PROBE:
            for row in range(2):
                same = True
                for k in range(3):
                    if known[row, k] != pose_a[k] or (b != WALL and known[row, 3 + k] != pose_b[k]):
                        same = False
                if same:
                    look = -1.0 if row == 1 else 0.0
                    break
        if look != look:
            cap = 0.0 if purpose == _PROBE else (TOUCH if purpose == _POINT else speed + SLACK)
            if b == WALL:
                map_gap(
                    scene.grid,
                    scene.origin_x,
                    scene.origin_y,
                    scene.yaw,
                    bodies,
                    a,
                    pose_a,
                    cap,
                    scratch.edges_a,
                    scratch.nearest,
                )
                look = scratch.nearest[0]
            else:
                look = body_gap(bodies, a, pose_a, b, pose_b, cap, scratch.edges_a, scratch.edges_b)
            if purpose == _PROBE or (purpose != _POINT and (look < 0.0 or purpose != _SLOPE)):
                row = 1 if look < 0.0 else 0
                for k in range(3):
                    known[row, k] = pose_a[k]
                    known[row, 3 + k] = pose_b[k]

        if purpose == _POINT:
            point[0] = scratch.nearest[1]
            point[1] = scratch.nearest[2]
            return free
        if purpose == _FIRST:
            gap = look
            known[1 if look >= 0.0 else 0] = math.nan
        elif purpose == _GAP:
            gap = look
            gap_is_of = free
        elif purpose == _SLOPE:
            slope = (gap - look) / (fraction - free)
            guess = free + gap / slope if slope > 0.0 else free
            margin = width / speed + 4.0 * np.spacing(guess)
            step += 1
        elif look < 0.0:
            hit = fraction
        else:
            free = fraction
            if purpose == _AHEAD:
                gap = look
                gap_is_of = free

        if hit == math.inf:
            if not (gap < speed * (1.0 - free) + SLACK and free < 1.0):
                return math.inf
            looks += 1
            if looks > MOST_LOOKS:
                return math.nan
            ahead = max(gap * (1.0 - 1e-9) - SLACK, shortest) / speed
            fraction = min(free + ahead, 1.0)
            purpose = _AHEAD
            continue
        while True:
            if step >= 9:
                purpose = _PROBE if np.nextafter(free, hit) < hit and (hit - free) * speed > FINEST else _POINT
                fraction = 0.5 * (free + hit) if purpose == _PROBE else free
                break
            if step % 3 > 0:
                fraction = guess - margin if step % 3 == 1 else guess + margin
                step += 1
                if free < fraction < hit:
                    purpose = _PROBE
                    break
                continue
            if gap_is_of != free:
                fraction = free
                purpose = _GAP
                break
            width = 16.0 * ROUNDING if step == 6 else ROUNDING
            fraction = free + 0.5 * max(gap, 0.0) / speed
            if gap > width and fraction > free:
                purpose = _SLOPE
                break
            guess = free
            margin = width / speed + 4.0 * np.spacing(guess)
            step += 1
        if purpose == _POINT and b != WALL:
            # Between the two, where their circles are equally near: the shapes touch close to it.
            pose_at(paths, a, free, pose_a)
            pose_at(paths, b, free, pose_b)
            share = bodies.reach[a] / (bodies.reach[a] + bodies.reach[b])
            for k in range(2):
                point[k] = pose_a[k] + share * (pose_b[k] - pose_a[k])
            return free


@kernel
def _enter(tree: Ints, time: Floats, leaf: int) -> None:
    """Play a tournament's matches anew from one leaf up: the earlier wins, the lower index where none is."""
    half = tree.shape[0] // 2
    node = (half + leaf) // 2
    while node > 0:
        left = tree[2 * node]
        right = tree[2 * node + 1]
        tree[node] = left if right < 0 or (left >= 0 and time[left] <= time[right]) else right
        node //= 2


@kernel
def resolve(
    scene: Scene, a: Ints, b: Ints, shortest: float, which: Ints, when: Floats, point: Floats, end: Floats
) -> int:
    """How many contacts there are in the step, taking the earliest first; those in it stop there.

    It is -1 where a pair takes more than `MOST_LOOKS`, whose number is the first of `which` then.

    Parameters
    ----------
    scene
        Its `stop` gets the fractions at which bodies stopped. No path may be of another form.
    a, b
        The pairs that might meet, each in order and all in order, int64 (Q,); `b` is `WALL` for a wall.
    shortest
        Those that touch and slide are looked at no farther apart than this [m].
    which
        Gets the pairs that met, in order of time, then of their index, in its first entries, int64 (Q,).
    when
        Gets the fractions of the step at which they did, (Q,).
    point
        Gets where [m] they did, (Q, 2).
    end
        Gets the poses (T, 3) of those that stopped; the others' are left alone.
    """
    pairs = a.shape[0]
    if pairs == 0:
        return 0
    paths = scene.paths
    count = paths.stop.shape[0]
    scratch = Scratch(
        np.empty(3),
        np.empty(3),
        np.empty(3),
        np.empty((scene.edge_rows, 5)),
        np.empty((scene.edge_rows, 5)),
        np.empty((2, 6)),
    )
    # The pairs of each body.
    first = np.zeros(count + 1, dtype=np.int64)
    for q in range(pairs):
        first[a[q]] += 1
        if b[q] != WALL:
            first[b[q]] += 1
    total = 0
    for i in range(count + 1):
        total += first[i]
        first[i] = total
    of_body = np.empty(total, dtype=np.int64)
    for q in range(pairs):
        first[a[q]] -= 1
        of_body[first[a[q]]] = q
        if b[q] != WALL:
            first[b[q]] -= 1
            of_body[first[b[q]]] = q

    time = np.empty(pairs)
    half = 1
    while half < pairs:
        half *= 2
    tree = np.full(2 * half, -1, dtype=np.int64)
    where = np.empty((pairs, 2))
    todo = np.empty(2 * pairs, dtype=np.int64)
    for q in range(pairs):
        tree[half + q] = q
        todo[q] = q
    waiting = pairs
    met = 0
    while True:
        for k in range(waiting):
            q = todo[k]
            a_stop = paths.stop[a[q]]
            b_stop = paths.stop[b[q]] if b[q] != WALL else 0.0
            # Whoever stopped meets nothing any more; whoever was to meet him may do so at another time now.
            if a_stop < 1.0 and b_stop < 1.0:
                time[q] = math.inf
            else:
                since = 0.0 if met == 0 else min(a_stop, b_stop)
                time[q] = _meet(scene, scratch, a[q], b[q], since, shortest, where[q])
                if math.isnan(time[q]):
                    which[0] = q
                    return -1
            _enter(tree, time, q)
        lead = tree[1]
        now = time[lead]
        if not now <= 1.0:
            return met
        which[met] = lead
        when[met] = now
        for k in range(2):
            point[met, k] = where[lead, k]
        met += 1
        waiting = 0
        for k in range(2):
            body = a[lead] if k == 0 else b[lead]
            if body != WALL and paths.stop[body] == 1.0:
                paths.stop[body] = now
                pose_at(paths, body, now, end[body])
                for entry in range(first[body], first[body + 1]):
                    todo[waiting] = of_body[entry]
                    waiting += 1
