"""Motion with contact: bodies move at once along closed-form paths, and stop where they touch.

The globally earliest contact is taken first (ties: walls before bodies, then by name); those in it stop there and
stand as obstacles for the rest of the step; the others go on from that instant. A body stops at the last
representable fraction of the step at which interiors are disjoint, so every start is free by the same test.

A contact is found by conservative advancement (B. Mirtich, "Impulse-based dynamic simulation", 1996): no point of a
body travels farther in a part of the step than that part of its path's bound, so a gap cannot close sooner.

A robot of several parts is several bodies (`amorsim.simulation.contact.moved_parts`): each has a path of its own, and
where one of them stops, all of them do, and the joints between them.

Where all that might meet go along arcs and lines, a kernel does it (`amorsim.kernels.collision.time_of_impact`). Paths
of other forms are known to their drives only, and take the same road in NumPy, with the same bits.
"""

from __future__ import annotations

import functools
from collections.abc import Sequence
from typing import Protocol

import attrs
import numpy as np
import numpy.typing as npt

from amorsim.core.errors import ContactError
from amorsim.kernels.collision.broad_phase import NEAR_BODY, NEAR_WALL, look_out
from amorsim.kernels.collision.paths import LEAST, OTHER, SLACK, STANDS, Paths, Scene, go_free, poses_at, set_out
from amorsim.kernels.collision.time_of_impact import FINEST, MOST_LOOKS, ROUNDING, TOUCH, WALL, resolve
from amorsim.simulation.world.world import World

__all__ = ["WALL", "Contact", "Mover", "move"]

Array = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]

# Bodies that touch and slide are looked at no farther apart than this; a wall is a cell thick, 1 mm and up.
SHORTEST = 2.5e-4  # [m]
# So many steps ahead walls are looked for, so that those in the open need not look in every one.
LOOK = 32.0
# Rays that it costs as much as to set out and to look who is near.
LOOK_WORK = 16


class Mover(Protocol):
    """Bodies that move alike: a group of robots, or obstacles."""

    bodies: Ints  # (M,) which bodies of the world they are

    def path(self) -> tuple[int, Array]:
        """The form of the paths (`amorsim.kernels.collision.paths`), and what they are made of `(M, 3)`.

        That is the twist over the whole step of an arc, and the displacement of a line or of another form.
        """

    def travel(self) -> Array:
        """Length of each path [m] and total turning [rad] in the whole step `(M, 2)`, or upper bounds."""

    def poses_at(self, which: Ints, fraction: Array) -> Array:
        """World poses `(Q, 3)` of its bodies number `which` `(Q,)` at fractions `(Q,)` of the step."""

    def arrive(self, poses: Array, stop: Array) -> None:
        """Take where they are after the step `(M, 3)`, and the fraction after which they stood still `(M,)`."""


@attrs.frozen(kw_only=True)
class Contact:
    """Two bodies, or a body and a wall (`other` is `WALL`), that met at a fraction of the step.

    A part of a robot is told as the body that it is.
    """

    body: int
    other: int
    fraction: float
    point: tuple[float, float]


class _Paths:
    """The paths of all bodies through the step, those of several movers as one.

    Making it lets the bodies set out: `end` is where they go if they meet nothing, `near` who might meet a wall, and
    `close` who might meet another body that reaches no farther.
    """

    def __init__(self, world: World, motion: Array, form: npt.NDArray[np.uint8]) -> None:
        count = len(world.poses)
        self.start = world.poses
        self.stop = np.empty(count)
        self.bound = np.empty(count)
        self.end = np.empty((count, 3))
        self.others: list[Mover] = []
        self.arrays = Paths(self.start, motion, form, self.bound, self.stop)
        self.scene = Scene(world.map.grid, *world.map.origin, world.bodies, world.edge_rows, self.arrays)
        self.near = self.close = world.everyone[:0]

    @classmethod
    def of(cls, world: World, movers: Sequence[Mover], told: Sequence[tuple[int, Array]]) -> _Paths:
        """The paths of movers, that have told what their own are made of."""
        count = len(world.poses)
        if len(movers) == 1 and len(movers[0].bodies) == count:
            # One mover of all bodies, in their order.
            kind, motion = told[0]
            form = _one_form(count, kind)
        else:
            form = np.full(count, STANDS, dtype=np.uint8)
            motion = np.zeros((count, 3))
            for mover, (kind, its) in zip(movers, told, strict=True):
                form[mover.bodies] = kind
                motion[mover.bodies] = its
        paths = cls(world, _floats(motion), form)
        for mover, (kind, _) in zip(movers, told, strict=True):
            if kind == OTHER:
                paths._add_other(world, mover)
        if world.has_company:
            near = np.empty(count, dtype=np.uint8)
            looked = paths.scene, world.replica_index, world.owner, world.by_place(paths.start), paths.end, near
            world.workers.share(count, LOOK_WORK, lambda first, last: look_out(first, last, *looked))
            paths.near = np.flatnonzero(near & NEAR_WALL)
            paths.close = np.flatnonzero(near & NEAR_BODY)
        else:
            set_out(paths.arrays, world.bodies.reach, paths.end)
            paths.near = paths._look_around(world)
        if world.has_parts:
            paths.end[world.parts] = paths.at(world.parts, np.ones(len(world.parts)))
        return paths

    def _look_around(self, world: World) -> Ints:
        """Who might meet a wall, in order; being without company they look further, and keep what room they have."""
        if world.has_parts:
            moving = np.flatnonzero(self.bound > 0.0)
            reach = self.bound[moving] + SLACK
            gaps, _ = world.wall_gaps(moving, self.start[moving], reach)
            return moving[gaps < reach]
        reach = self.bound + SLACK
        gaps, _ = world.wall_gaps(world.everyone, self.start, LOOK * reach)
        near = gaps < reach
        world.room = np.where(near, 0.0, gaps - reach)
        world.room_at = self.end
        return np.flatnonzero(near & (self.bound > 0.0))

    def _add_other(self, world: World, mover: Mover) -> None:
        self.others.append(mover)
        travel = mover.travel()
        bound = travel[:, 0] + travel[:, 1] * world.bodies.reach[mover.bodies]
        self.bound[mover.bodies] = np.where(bound < LEAST, 0.0, bound * (1.0 + 1e-9))

    def has_others(self, bodies: Ints) -> bool:
        """Whether the path of any of the bodies is known to its mover only."""
        return bool(self.others) and bool((self.arrays.form[bodies] == OTHER).any())

    def at(self, bodies: Ints, fraction: Array) -> Array:
        """World poses `(Q, 3)`; a body that stopped stays where it stopped."""
        poses = np.empty((len(bodies), 3))
        poses_at(self.arrays, bodies, fraction, poses)
        if self.others:
            fraction = np.minimum(fraction, self.stop[bodies])
            moving = (fraction > 0.0) & (self.bound[bodies] > 0.0)
            for mover in self.others:
                row = np.searchsorted(mover.bodies, bodies).clip(max=len(mover.bodies) - 1)
                mine = np.flatnonzero(moving & (mover.bodies[row] == bodies))
                if len(mine):
                    poses[mine] = mover.poses_at(row[mine], fraction[mine])
        return poses

    def speed(self, bodies: Ints, fraction: Array) -> Array:
        """How far [m] any point of each body can go per whole step, from `fraction` on."""
        return np.where(fraction < self.stop[bodies], self.bound[bodies], 0.0)


def _floats(motion: Array) -> Array:
    return np.ascontiguousarray(motion, dtype=np.float64)


@functools.lru_cache(maxsize=16)
def _one_form(count: int, form: int) -> npt.NDArray[np.uint8]:
    return np.full(count, form, dtype=np.uint8)


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
    told = [mover.path() for mover in movers]
    if not world.has_company and len(told) == 1 and world.room_at is world.poses and told[0][0] != OTHER:
        # Robots without company, of whom is known how far they are from all walls: no wall is looked at.
        kind, motion = told[0]
        end, stop = np.empty_like(world.poses), np.empty(len(world.poses))
        if go_free(world.poses, _floats(motion), kind, world.bodies.reach, world.room, end, stop):
            world.room_at = end
            return end, stop, []
    return _meet(world, _Paths.of(world, movers, told))


def _meet(world: World, paths: _Paths) -> tuple[Array, Array, list[Contact]]:
    """What `move` tells, of those who have set out."""
    if not len(paths.near) and not len(paths.close):
        return paths.end, paths.stop, []
    a, b = _candidates(world, paths)
    if not len(a):
        return paths.end, paths.stop, []
    shortest = min(SHORTEST, world.map.resolution / 4.0)
    if paths.has_others(a) or paths.has_others(b[b != WALL]):
        which, when = _resolve(world, paths, a, b, shortest)
        a, b = a[which], b[which]
        point = _points(world, paths, a, b, when)
        stopped = np.flatnonzero(paths.stop < 1.0)
        paths.end[stopped] = paths.at(stopped, paths.stop[stopped])
    else:  # parts that might meet something are not among them
        which, when, point = np.empty(len(a), dtype=np.int64), np.empty(len(a)), np.empty((len(a), 2))
        met = resolve(paths.scene, a, b, shortest, which, when, point, paths.end)
        if met < 0:
            raise _too_many_looks(world, paths, int(a[which[0]]), int(b[which[0]]))
        a, b, when, point = a[which[:met]], b[which[:met]], when[:met], point[:met]
        if world.has_parts:
            _stop_parts(world, paths)
            late = world.parts[paths.stop[world.parts] < 1.0]
            paths.end[late] = paths.at(late, paths.stop[late])
    contacts = [
        Contact(body=body, other=other, fraction=fraction, point=(x, y))
        for body, other, fraction, (x, y) in zip(a.tolist(), b.tolist(), when.tolist(), point.tolist(), strict=True)
    ]
    return paths.end, paths.stop, contacts


def _candidates(world: World, paths: _Paths) -> tuple[Ints, Ints]:
    """Whoever might meet a wall (b is `WALL`) or another body during the step, in order."""
    a, b = paths.near, np.full(len(paths.near), WALL, dtype=np.int64)
    if not len(paths.close):
        return a, b
    of_pair, other = world.pairs_within(paths.start, paths.bound + SLACK, paths.close)
    if len(of_pair):
        reach = paths.bound[of_pair] + paths.bound[other]
        moves = reach > 0.0
        of_pair, other, reach = of_pair[moves], other[moves], reach[moves] + SLACK
        gaps = world.body_gaps(of_pair, paths.start[of_pair], other, paths.start[other], reach)
        close = gaps < reach
        a, b = np.concatenate((a, of_pair[close])), np.concatenate((b, other[close]))
        order = np.lexsort((b, a))
        a, b = a[order], b[order]
    return a, b


def _resolve(world: World, paths: _Paths, a: Ints, b: Ints, shortest: float) -> tuple[Ints, Array]:
    """The pairs that met, and when, as the kernel `time_of_impact.resolve` finds them, for paths of any form."""
    met: list[Ints] = []
    time = _first_contacts(world, paths, a, b, np.zeros(len(a)), shortest)
    when = time.copy()
    replica = world.replica_index[a]
    while True:
        alive = np.flatnonzero(time <= 1.0)
        if not len(alive):
            break
        order = alive[np.lexsort((alive, time[alive], replica[alive]))]
        leads = np.ones(len(order), dtype=bool)
        leads[1:] = replica[order[1:]] != replica[order[:-1]]
        chosen = order[leads]  # the earliest contact of every replica that has one
        met.append(chosen)
        when[chosen] = time[chosen]
        stopped = np.zeros(len(paths.stop), dtype=bool)
        for side, fraction in ((a[chosen], time[chosen]), (b[chosen], time[chosen])):
            real = side != WALL
            body = world.owner[side[real]]
            paths.stop[body] = np.minimum(paths.stop[body], fraction[real])
            stopped[body] = True
        if world.has_parts:
            _stop_parts(world, paths)
            stopped[world.parts] = stopped[world.owner[world.parts]]
        # Whoever stopped meets nothing any more; whoever was to meet him may do so at another time now.
        wall = b == WALL
        touched = stopped[a] | (~wall & stopped[b])
        a_rests = paths.stop[a] < 1.0
        b_rests = wall | (paths.stop[b] < 1.0)
        time[touched & a_rests & b_rests] = np.inf
        again = np.flatnonzero(touched & ~(a_rests & b_rests))
        if len(again):
            since = np.minimum(paths.stop[a[again]], np.where(wall[again], 1.0, paths.stop[b[again]]))
            time[again] = _first_contacts(world, paths, a[again], b[again], since, shortest)
    which = np.concatenate(met) if met else np.empty(0, dtype=np.int64)
    # Of one replica they are in order, and at one instant stay so.
    which = which[np.lexsort((np.arange(len(which)), replica[which], when[which]))]
    return which, when[which]


def _stop_parts(world: World, paths: _Paths) -> None:
    """Let all parts stop where their robots do."""
    paths.stop[world.parts] = paths.stop[world.owner[world.parts]]


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


def _first_contacts(world: World, paths: _Paths, a: Ints, b: Ints, since: Array, shortest: float) -> Array:
    """The last free fraction `(Q,)` before each pair first overlaps, from `since` on; inf if never."""
    other = np.where(b == WALL, a, b)
    speed = paths.speed(a, since) + np.where(b == WALL, 0.0, paths.speed(other, since))
    fraction = since.copy()
    found = np.full(len(a), np.inf)
    active = np.flatnonzero(speed > 0.0)
    gap = _gaps(world, paths, a[active], b[active], fraction[active], speed[active] + SLACK)
    looks = 0
    while len(active):
        left = speed[active] * (1.0 - fraction[active])
        going = (gap < left + SLACK) & (fraction[active] < 1.0)
        active, gap = active[going], gap[going]
        if not len(active):
            break
        looks += 1
        if looks > MOST_LOOKS:
            raise _too_many_looks(world, paths, int(a[active[0]]), int(b[active[0]]))
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


def _too_many_looks(world: World, paths: _Paths, a: int, b: int) -> ContactError:
    """What is wrong with a step in which two are looked at without end."""
    fast = a if b == WALL or paths.bound[a] >= paths.bound[b] else b
    other = "the walls" if b == WALL else repr(world.name(b if fast == a else a))
    return ContactError(
        f"{world.name(fast)!r}, of {2.0 * world.bodies.reach[fast]:.3g} m, moves points of its outline by up to "
        f"{paths.bound[fast]:.3g} m in one step, and goes along {other} so closely that its contacts cannot be found: "
        f"they were looked for at {MOST_LOOKS} places; expected some metres a step at the most, as of a shorter dt, or "
        "of smaller speeds and rates"
    )


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


def _points(world: World, paths: _Paths, a: Ints, b: Ints, time: Array) -> Array:
    """Where [m] pairs touch `(Q, 2)`."""
    poses = paths.at(a, time)
    point = np.empty((len(a), 2))
    wall = b == WALL
    if wall.any():
        _, point[wall] = world.wall_gaps(a[wall], poses[wall], np.full(int(wall.sum()), TOUCH))
    if not wall.all():
        # Between the two, where their circles are equally near: the shapes touch close to it.
        pair = ~wall
        reach = world.bodies.reach
        share = reach[a[pair]] / (reach[a[pair]] + reach[b[pair]])
        its = paths.at(b[pair], time[pair])[:, :2]
        point[pair] = poses[pair, :2] + share[:, None] * (its - poses[pair, :2])
    return point
