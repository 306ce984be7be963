"""Motion with contact: bodies move at once along closed-form paths, and stop where they touch.

The globally earliest contact is taken first (ties: walls before bodies, then by name); those in it stop there and
stand as obstacles for the rest of the step; the others go on from that instant. A body stops at the last
representable fraction of the step at which interiors are disjoint, so every start is free by the same test.

A contact is found by conservative advancement (B. Mirtich, "Impulse-based dynamic simulation", 1996): no point of a
body travels farther in a part of the step than that part of its path's bound, so a gap cannot close sooner.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

import attrs
import numpy as np
import numpy.typing as npt

from amorsim.simulation.bodies import World

__all__ = ["Contact", "Mover", "move"]

Array = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]
Bools = npt.NDArray[np.bool_]

WALL = -1
# The slack by which a gap must exceed what the bodies can still travel before it counts as safe: rounding of poses
# in a world of some kilometres.
SLACK = 1e-9  # [m]
# Bodies that touch and slide are looked at no farther apart than this; a wall is a cell thick, 1 mm and up.
SHORTEST = 2.5e-4  # [m]
# What poses and gaps are uncertain by, from rounding, some metres from the origin.
ROUNDING = 4e-15  # [m]
# Fractions that differ by less travel than this lead to the same pose: no coordinate within a world changes by it.
FINEST = 1e-18  # [m]


class Mover(Protocol):
    """Bodies that move alike: a group of robots, or obstacles."""

    bodies: Ints  # (M,) which bodies of the world they are

    def travel(self) -> Array:
        """Length of each path [m] and total turning [rad] in the whole step `(M, 2)`, or upper bounds."""

    def poses_at(self, which: Ints, fraction: Array) -> Array:
        """World poses `(Q, 3)` of its bodies number `which` `(Q,)` at fractions `(Q,)` of the step."""

    def end_poses(self) -> Array:
        """World poses `(M, 3)` of all its bodies at the end of the step."""


@attrs.frozen(kw_only=True)
class Contact:
    """Two bodies, or a body and a wall (`other` is `WALL`), that met at a fraction of the step."""

    body: int
    other: int
    fraction: float
    point: tuple[float, float]


class _Paths:
    """The paths of all bodies through the step, those of several movers as one."""

    def __init__(self, world: World, movers: Sequence[Mover]) -> None:
        count = len(world.poses)
        self.start = world.poses
        self.stop = np.ones(count)
        self._movers = movers
        if len(movers) == 1 and len(movers[0].bodies) == count:
            # One mover of all bodies, in their order.
            self.end = movers[0].end_poses()
            travel = movers[0].travel()
            bound = travel[:, 0] + travel[:, 1] * world.bodies.reach
            self._mover = np.zeros(count, dtype=np.int64)
            self._index = world.everyone
        else:
            self.end = world.poses.copy()
            bound = np.zeros(count)
            self._mover = np.full(count, -1, dtype=np.int64)
            self._index = np.zeros(count, dtype=np.int64)
            for number, mover in enumerate(movers):
                self.end[mover.bodies] = mover.end_poses()
                travel = mover.travel()
                bound[mover.bodies] = travel[:, 0] + travel[:, 1] * world.bodies.reach[mover.bodies]
                self._mover[mover.bodies] = number
                self._index[mover.bodies] = np.arange(len(mover.bodies))
        # Whoever travels less than rounding stands still, and keeps his place to the bit.
        self.bound = np.where(bound < 1e-15, 0.0, bound * (1.0 + 1e-9))

    def at(self, bodies: Ints, fraction: Array) -> Array:
        """World poses `(Q, 3)`; a body that stopped stays where it stopped."""
        fraction = np.minimum(fraction, self.stop[bodies])
        poses = self.start[bodies]
        moving = (fraction > 0.0) & (self.bound[bodies] > 0.0)
        for number, mover in enumerate(self._movers):
            mine = np.flatnonzero(moving & (self._mover[bodies] == number))
            if len(mine):
                poses[mine] = mover.poses_at(self._index[bodies[mine]], fraction[mine])
        return poses

    def speed(self, bodies: Ints, fraction: Array) -> Array:
        """How far [m] any point of each body can go per whole step, from `fraction` on."""
        return np.where(fraction < self.stop[bodies], self.bound[bodies], 0.0)


def move(world: World, movers: Sequence[Mover]) -> tuple[Array, Array, list[Contact]]:
    """Move all bodies through a step.

    Returns
    -------
    poses
        `(T, 3)` where they stand afterwards.
    stop
        `(T,)` the fraction of the step after which each body stood still, 1 for those that met nothing.
    contacts
        In order of time.
    """
    paths = _Paths(world, movers)
    if not world.has_company and _all_clear(world, paths):
        return paths.end, paths.stop, []
    a, b = _candidates(world, paths)
    if not len(a):
        return paths.end, paths.stop, []
    contacts = _resolve(world, paths, a, b)
    poses = paths.end
    stopped = np.flatnonzero(paths.stop < 1.0)
    if len(stopped):
        poses = poses.copy()
        poses[stopped] = paths.at(stopped, paths.stop[stopped])
    return poses, paths.stop, contacts


def _all_clear(world: World, paths: _Paths) -> bool:
    """Whether no wall is near enough to be met: the common case of robots without company, told in one look."""
    reach = paths.bound + SLACK
    gaps, _ = world.wall_gaps(world.everyone, paths.start, reach)
    return not (gaps < reach).any()


def _candidates(world: World, paths: _Paths) -> tuple[Ints, Ints]:
    """Whoever might meet a wall (b is `WALL`) or another body during the step."""
    moving = np.flatnonzero(paths.bound > 0.0)
    reach = paths.bound[moving] + SLACK
    gaps, _ = world.wall_gaps(moving, paths.start[moving], reach)
    near = moving[gaps < reach]
    a, b = world.pairs_within(paths.start, paths.bound + SLACK)
    if len(a):
        reach = paths.bound[a] + paths.bound[b]
        moves = reach > 0.0
        a, b, reach = a[moves], b[moves], reach[moves] + SLACK
        close = world.body_gaps(a, paths.start[a], b, paths.start[b], reach) < reach
        a, b = a[close], b[close]
    return np.concatenate((near, a)), np.concatenate((np.full(len(near), WALL, dtype=np.int64), b))


def _resolve(world: World, paths: _Paths, a: Ints, b: Ints) -> list[Contact]:
    contacts: list[Contact] = []
    time = _first_contacts(world, paths, a, b, np.zeros(len(a)))
    replica = world.replica_index[a]
    while True:
        alive = np.flatnonzero(time <= 1.0)
        if not len(alive):
            break
        order = alive[np.lexsort((b[alive], a[alive], time[alive], replica[alive]))]
        leads = np.ones(len(order), dtype=bool)
        leads[1:] = replica[order[1:]] != replica[order[:-1]]
        chosen = order[leads]  # the earliest contact of every replica that has one
        contacts += _contacts(world, paths, a[chosen], b[chosen], time[chosen])
        stopped = np.zeros(len(paths.stop), dtype=bool)
        for body, fraction in ((a[chosen], time[chosen]), (b[chosen], time[chosen])):
            real = body != WALL
            paths.stop[body[real]] = np.minimum(paths.stop[body[real]], fraction[real])
            stopped[body[real]] = True
        # Whoever stopped meets nothing any more; whoever was to meet him may do so at another time now.
        wall = b == WALL
        touched = stopped[a] | (~wall & stopped[b])
        a_rests = paths.stop[a] < 1.0
        b_rests = wall | (paths.stop[b] < 1.0)
        time[touched & a_rests & b_rests] = np.inf
        again = np.flatnonzero(touched & ~(a_rests & b_rests))
        if len(again):
            since = np.minimum(paths.stop[a[again]], np.where(wall[again], 1.0, paths.stop[b[again]]))
            time[again] = _first_contacts(world, paths, a[again], b[again], since)
    contacts.sort(key=lambda contact: contact.fraction)
    return contacts


def _gaps(world: World, paths: _Paths, a: Ints, b: Ints, fraction: Array, cap: Array) -> Array:
    out = np.empty(len(a))
    wall = b == WALL
    if wall.any():
        i = np.flatnonzero(wall)
        out[i], _ = world.wall_gaps(a[i], paths.at(a[i], fraction[i]), cap[i])
    if not wall.all():
        i = np.flatnonzero(~wall)
        poses_a, poses_b = paths.at(a[i], fraction[i]), paths.at(b[i], fraction[i])
        out[i] = world.body_gaps(a[i], poses_a, b[i], poses_b, cap[i])
    return out


def _first_contacts(world: World, paths: _Paths, a: Ints, b: Ints, since: Array) -> Array:
    """The last free fraction `(Q,)` before each pair first overlaps, from `since` on; inf if never."""
    other = np.where(b == WALL, a, b)
    speed = paths.speed(a, since) + np.where(b == WALL, 0.0, paths.speed(other, since))
    fraction = since.copy()
    found = np.full(len(a), np.inf)
    active = np.flatnonzero(speed > 0.0)
    shortest = min(SHORTEST, world.map.resolution / 4.0)
    gap = _gaps(world, paths, a[active], b[active], fraction[active], speed[active] + SLACK)
    while len(active):
        left = speed[active] * (1.0 - fraction[active])
        going = (gap < left + SLACK) & (fraction[active] < 1.0)
        active, gap = active[going], gap[going]
        if not len(active):
            break
        ahead = np.maximum(gap * (1.0 - 1e-9) - SLACK, shortest) / speed[active]
        following = np.minimum(fraction[active] + ahead, 1.0)
        cap = speed[active] + SLACK
        next_gap = _gaps(world, paths, a[active], b[active], following, cap)
        hit = next_gap < 0.0
        if hit.any():
            i = active[hit]
            found[i] = _last_free(world, paths, a[i], b[i], fraction[i], following[hit])
        fraction[active] = following
        active, gap = active[~hit], next_gap[~hit]
    return found


def _last_free(world: World, paths: _Paths, a: Ints, b: Ints, free: Array, hit: Array) -> Array:
    """Between a free fraction and one with overlap, the last free one that numbers can tell from it.

    Halving alone takes a hundred looks at a body that pushes against a wall. So the bracket is first squeezed: the
    gap closes nearly evenly so close to a contact, and where it would be 0 is looked at from both sides.
    """
    free, hit = free.copy(), hit.copy()
    speed = paths.speed(a, free) + np.where(b == WALL, 0.0, paths.speed(np.where(b == WALL, a, b), free))
    for width in (ROUNDING, ROUNDING, 16.0 * ROUNDING):
        _squeeze(world, paths, a, b, free, hit, speed, width)
    cap = np.zeros(len(a))
    while True:
        open_ = np.flatnonzero((np.nextafter(free, hit) < hit) & ((hit - free) * speed > FINEST))
        if not len(open_):
            return free
        middle = 0.5 * (free[open_] + hit[open_])
        overlaps = _gaps(world, paths, a[open_], b[open_], middle, cap[open_]) < 0.0
        hit[open_[overlaps]] = middle[overlaps]
        free[open_[~overlaps]] = middle[~overlaps]


def _squeeze(
    world: World, paths: _Paths, a: Ints, b: Ints, free: Array, hit: Array, speed: Array, width: float
) -> None:
    """Narrow the brackets, in place, to about `width` [m] on either side of where the gap's slope puts the contact."""
    cap = speed + SLACK
    gap = _gaps(world, paths, a, b, free, cap)
    nearer = free + 0.5 * np.maximum(gap, 0.0) / speed
    slope = (gap - _gaps(world, paths, a, b, nearer, cap)) / np.where(nearer > free, nearer - free, np.inf)
    with np.errstate(divide="ignore", invalid="ignore"):
        guess = np.where((slope > 0.0) & (gap > width), free + gap / slope, free)
    margin = width / speed + 4.0 * np.spacing(guess)
    for probe in (guess - margin, guess + margin):
        inside = np.flatnonzero((probe > free) & (probe < hit))
        if len(inside):
            overlaps = _gaps(world, paths, a[inside], b[inside], probe[inside], np.zeros(len(inside))) < 0.0
            hit[inside[overlaps]] = probe[inside[overlaps]]
            free[inside[~overlaps]] = probe[inside[~overlaps]]


def _contacts(world: World, paths: _Paths, a: Ints, b: Ints, time: Array) -> list[Contact]:
    made = []
    poses = paths.at(a, time)
    reach = world.bodies.reach
    for i in range(len(a)):
        body, other = int(a[i]), int(b[i])
        if other == WALL:
            _, where = world.wall_gaps(a[i : i + 1], poses[i : i + 1], np.full(1, 0.01))
            point = (float(where[0, 0]), float(where[0, 1]))
        else:
            # Between the two, where their circles are equally near: the shapes touch close to it.
            its = paths.at(b[i : i + 1], time[i : i + 1])[0]
            share = reach[body] / (reach[body] + reach[other])
            point = tuple((poses[i, :2] + share * (its[:2] - poses[i, :2])).tolist())
        made.append(Contact(body=body, other=other, fraction=float(time[i]), point=point))
    return made
