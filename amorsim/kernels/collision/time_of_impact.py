"""The narrow phase: when bodies on their paths first touch walls and each other, and where each stops.

A contact is found by conservative advancement (B. Mirtich, "Impulse-based dynamic simulation", 1996): a part of the
step takes no point of a body farther than that part of its path's bound, so a gap cannot close sooner. The search of a
pair is a state machine: `_look` finds the gap at a fraction of the step, `_next` takes it in and chooses the fraction
to look at next.

Poses on arcs and lines are computed here. Only its mover knows a path of form `OTHER`: the search of such a pair
waits until the caller has written its poses, and goes on when `resolve` is called again.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from amorsim.array_types import Array, Bools, Ints
from amorsim.kernels.collision.clearance import map_gap
from amorsim.kernels.collision.footprints import body_gap
from amorsim.kernels.collision.paths import SLACK, Paths, Scene, pose_at
from amorsim.kernels.compile import kernel, part

__all__ = ["FINEST", "MET", "ROUNDING", "WAITING", "WALL", "Search", "resolve"]


WALL = -1
# What poses and gaps are uncertain by, from rounding, some metres from the origin.
ROUNDING = 4e-15  # [m]
# Fractions that differ by less travel than this lead to the same pose: no coordinate within a world changes by it.
FINEST = 1e-18  # [m]

# The stages of a pair's search.
_BEGIN = 0
_GAP = 1  # find the gap where the pair is known to be free
_AHEAD = 2  # go ahead as far as the gap is safe
_SLOPE = 3  # find how fast the gap closes
_PROBE = 4  # narrow the bracket: free or not?
_END = 5

# Entries of `Search.used`.
WAITING = 0
MET = 1


class Search(NamedTuple):
    """The pairs that might meet, each with the state of its search, and the contacts found."""

    a: Ints
    """Bodies, in order, (Q,)."""
    b: Ints
    """The other body, or `WALL`, (Q,)."""
    asks: Bools
    """Whether the caller has to write poses, as a path is of form `OTHER`, (Q,)."""
    answered: Bools
    """Whether it has, (Q,)."""
    stage: Ints
    """What is looked for at `fraction`: 0 to begin with, (Q,)."""
    fraction: Array
    """Where to look at the pair, (Q,)."""
    poses: Array
    """Poses of both there, (Q, 2, 3)."""
    known: Array
    """Poses of both at which they are known to be free, and such at which they overlap, nan if none, (Q, 2, 2, 3)."""
    speed: Array
    """The gap closes by no more than this [m] in a whole step, (Q,)."""
    free: Array
    """The last fraction known to be free, (Q,)."""
    hit: Array
    """The first one known to overlap; inf until there is one, (Q,)."""
    gap: Array
    """At `free` [m]; nan if not known, (Q,)."""
    guess: Array
    """The fraction at which the gap would be 0, by its slope, (Q,)."""
    looks: Ints
    """Looks ahead so far, and steps of narrowing, (Q, 2)."""
    time: Array
    """What was found: the last free fraction before the pair first overlaps, inf if it never does, (Q,)."""
    first: Ints
    """The pairs of body i are entries ``first[i]:first[i + 1]`` of `of_body`, (T + 1,)."""
    of_body: Ints
    tree: Ints
    """A tournament of the pairs for the earliest time: the winner is entry 1, the leaves are the second half."""
    todo: Ints
    """The pairs to search, all at first, (Q,); after a call those that wait."""
    met: Ints
    """The pairs that met, in order of time, (Q,)."""
    when: Array
    """The fractions at which they did, (Q,)."""
    used: Ints
    """Number of entries used of `todo` and of `met`, (2,)."""


@part
def _begin(paths: Paths, s: Search, q: int) -> None:
    """Begin the search of pair q where one of the two stopped, or at the start of the step."""
    since = paths.stop[s.a[q]]
    s.speed[q] = 0.0
    if s.b[q] != WALL:
        since = min(since, paths.stop[s.b[q]])
    if since == 1.0:
        since = 0.0
    if since < paths.stop[s.a[q]]:
        s.speed[q] = paths.bound[s.a[q]]
    if s.b[q] != WALL and since < paths.stop[s.b[q]]:
        s.speed[q] += paths.bound[s.b[q]]
    s.fraction[q] = since
    s.free[q] = since
    s.hit[q] = math.inf
    s.time[q] = math.inf
    s.looks[q, 0] = 0
    s.looks[q, 1] = 0
    s.stage[q] = _GAP if s.speed[q] > 0.0 else _END


@part
def _look(scene: Scene, s: Search, q: int, edges: Array, nearest: Array) -> float:
    """The gap [m] of pair q at its poses; for a probe only its sign counts.

    Close to a contact many fractions lead to the same poses, so the answers for two sets of poses are kept.
    """
    poses = s.poses[q]
    known = s.known[q]
    if s.stage[q] == _PROBE:
        for k in range(2):
            same = True
            for i in range(2):
                for j in range(3):
                    same = same and known[k, i, j] == poses[i, j]
            if same:
                return 0.0 if k == 0 else -1.0
    cap = 0.0 if s.stage[q] == _PROBE else s.speed[q] + SLACK
    a = s.a[q]
    if s.b[q] == WALL:
        map_gap(
            scene.grid,
            scene.origin_x,
            scene.origin_y,
            scene.yaw,
            scene.bodies,
            a,
            poses[0],
            cap,
            edges[0],
            nearest,
        )
        look = float(nearest[0])
    else:
        look = body_gap(scene.bodies, a, poses[0], s.b[q], poses[1], cap, edges[0], edges[1])
    if s.stage[q] != _SLOPE:
        k = 1 if look < 0.0 else 0
        for i in range(2):
            for j in range(3):
                known[k, i, j] = poses[i, j]
    return look


@part
def _next(s: Search, q: int, look: float, shortest: float) -> None:
    """Take in the gap [m] found at `fraction`, and choose the stage and the fraction that follow.

    As long as the pair is free it goes ahead, as far as the gap is safe. Then the contact lies between `free` and
    `hit`. This bracket is narrowed three times to about `width` on either side of where the gap's slope puts the
    contact: the gap closes nearly evenly so close to it. Halving, which comes last, alone would take many more looks.
    """
    speed = s.speed[q]
    at = s.fraction[q]
    stage = s.stage[q]
    if stage == _GAP:
        s.gap[q] = look
    elif stage == _SLOPE:
        slope = (s.gap[q] - look) / (at - s.free[q])
        s.guess[q] = s.free[q] + s.gap[q] / slope if slope > 0.0 else s.free[q]
        s.looks[q, 1] += 1
    elif look < 0.0:
        s.hit[q] = at
    else:
        s.free[q] = at
        s.gap[q] = look if stage == _AHEAD else math.nan
    free = s.free[q]
    hit = s.hit[q]
    gap = s.gap[q]

    if hit == math.inf:
        if not (gap < speed * (1.0 - free) + SLACK and free < 1.0):
            s.stage[q] = _END
            return
        s.looks[q, 0] += 1
        s.stage[q] = _AHEAD
        s.fraction[q] = min(free + max(gap * (1.0 - 1e-9) - SLACK, shortest) / speed, 1.0)
        return

    while s.looks[q, 1] < 9:  # three times: the slope, a probe below the guess, and one above it
        step = s.looks[q, 1]
        width = 16.0 * ROUNDING if step >= 6 else ROUNDING
        if step % 3 == 0:
            s.fraction[q] = free
            s.stage[q] = _GAP
            if math.isnan(gap) and stage != _GAP:
                return
            s.fraction[q] = free + 0.5 * max(gap, 0.0) / speed
            s.stage[q] = _SLOPE
            if gap > width and s.fraction[q] > free:
                return
            s.guess[q] = free
            s.looks[q, 1] += 1
        else:
            margin = width / speed + 4.0 * np.spacing(s.guess[q])
            s.fraction[q] = s.guess[q] - margin if step % 3 == 1 else s.guess[q] + margin
            s.stage[q] = _PROBE
            s.looks[q, 1] += 1
            if free < s.fraction[q] < hit:
                return
    s.fraction[q] = 0.5 * (free + hit)
    s.stage[q] = _PROBE
    if not (np.nextafter(free, hit) < hit and (hit - free) * speed > FINEST):
        s.time[q] = free
        s.stage[q] = _END


@part
def _search(scene: Scene, s: Search, q: int, shortest: float, most_looks: int, edges: Array, nearest: Array) -> bool:
    """Search pair q until its time is found, nan after too many looks; False if it waits for poses."""
    paths = scene.paths
    if s.stage[q] == _BEGIN:
        _begin(paths, s, q)
    while s.stage[q] != _END:
        if s.looks[q, 0] > most_looks:
            s.time[q] = math.nan
            return True
        if s.asks[q] and s.fraction[q] > 0.0:
            if not s.answered[q]:
                return False
            s.answered[q] = False
        else:
            pose_at(paths, s.a[q], s.fraction[q], s.poses[q, 0])
            if s.b[q] != WALL:
                pose_at(paths, s.b[q], s.fraction[q], s.poses[q, 1])
        _next(s, q, _look(scene, s, q, edges, nearest), shortest)
    return True


@part
def _enter(tree: Ints, time: Array, leaf: int) -> None:
    """Replay a tournament's matches from one leaf up: the earlier wins, the lower index if they are equal."""
    half = tree.shape[0] // 2
    node = (half + leaf) // 2
    while node > 0:
        left = tree[2 * node]
        right = tree[2 * node + 1]
        tree[node] = left if right < 0 or (left >= 0 and time[left] <= time[right]) else right
        node //= 2


@part
def _stop(paths: Paths, same_owner: Ints, body: int, fraction: float) -> None:
    """Let a body stop, and all bodies of its owner with it."""
    member = body
    while True:
        if paths.stop[member] == 1.0:
            paths.stop[member] = fraction
        member = same_owner[member]
        if member == body:
            return


@part
def _search_again(paths: Paths, same_owner: Ints, s: Search, body: int, fraction: float) -> None:
    """Put what the bodies of one owner, which stopped at a fraction, might still meet among the pairs to search."""
    member = body
    while True:
        if paths.stop[member] == fraction:
            for entry in range(s.first[member], s.first[member + 1]):
                q = s.of_body[entry]
                if paths.stop[s.a[q]] < 1.0 and (s.b[q] == WALL or paths.stop[s.b[q]] < 1.0):
                    s.time[q] = math.inf  # both are at rest
                    _enter(s.tree, s.time, q)
                else:
                    s.stage[q] = _BEGIN
                    s.todo[s.used[WAITING]] = q
                    s.used[WAITING] += 1
        member = same_owner[member]
        if member == body:
            return


@kernel
def resolve(scene: Scene, same_owner: Ints, s: Search, shortest: float, most_looks: int) -> int:
    """Take the contacts of the step, the earliest first; the bodies in it stop there.

    Returns the number of pairs that wait for poses, the first entries of `s.todo`, 0 at the end. It is -1 if a pair,
    the first of `s.todo`, takes too many looks.

    Parameters
    ----------
    scene
        `stop` of its paths gets the fractions at which bodies stopped.
    same_owner
        The next body with the same owner, round in a ring, (T,).
    s
        The pairs that might meet.
    shortest
        Bodies that touch and slide are looked at no farther apart than this [m].
    most_looks
        Number of looks ahead at a pair after which the search is given up.
    """
    paths = scene.paths
    edges = np.empty((2, scene.edge_rows, 5))
    nearest = np.empty(3)
    while True:
        waiting = 0
        for k in range(s.used[WAITING]):
            q = s.todo[k]
            if not _search(scene, s, q, shortest, most_looks, edges, nearest):
                s.todo[waiting] = q
                waiting += 1
            elif math.isnan(s.time[q]):
                s.todo[0] = q
                return -1
            else:
                _enter(s.tree, s.time, q)
        s.used[WAITING] = waiting
        if waiting > 0:
            return waiting
        lead = s.tree[1]
        now = s.time[lead]
        if not now <= 1.0:
            return 0
        s.met[s.used[MET]] = lead
        s.when[s.used[MET]] = now
        s.used[MET] += 1
        _stop(paths, same_owner, s.a[lead], now)
        if s.b[lead] != WALL:
            _stop(paths, same_owner, s.b[lead], now)
        _search_again(paths, same_owner, s, s.a[lead], now)
        if s.b[lead] != WALL:
            _search_again(paths, same_owner, s, s.b[lead], now)
