"""Motion with contact: all bodies move together along closed-form paths, and stop where they touch.

The earliest contact of all is taken first (ties: walls before bodies, then by name). Its bodies stop there and are
obstacles for the rest of the step; the others continue from that instant. A body stops at the last
representable fraction of the step at which interiors are disjoint, so every start is free by the same test.

Two kernels do the work. The broad phase (`amorsim.kernels.collision.broad_phase`) finds the bodies that might
touch something, from the clearance that the world keeps of every body. The narrow phase
(`amorsim.kernels.collision.time_of_impact`) finds when they do. It calls back for poses on paths that only a
drive knows.

A robot of several parts is several bodies (`amorsim.simulation.contact.moved_parts`): each has a path of its own.
If one of them stops, all of them stop, and so do the joints between them.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

import attrs
import numpy as np
import numpy.typing as npt

from amorsim.core.errors import ContactError
from amorsim.core.map import Map
from amorsim.kernels.collision.broad_phase import NEAR_BODY, NEAR_WALL, look_around, set_out
from amorsim.kernels.collision.paths import LEAST, OTHER, SLACK, STANDS, Paths, Scene, poses_at
from amorsim.kernels.collision.time_of_impact import MET, WALL, Search, resolve
from amorsim.simulation.world.world import World

__all__ = ["WALL", "Contact", "Movement", "Mover"]

Array = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]

# Bodies that touch and slide are tested at most this far apart; a wall is at least a cell, 1 mm, thick.
SHORTEST = 2.5e-4  # [m]
# A wall that stopped a body is nearer than this.
TOUCH = 0.01  # [m]
# Number of tests of a pair in one step: enough for a hundred metres along a wall, touching it, in cells of 1 mm.
MOST_LOOKS = 400_000
# Cost of one body's broad phase, in rays.
LOOK_WORK = 16


class Mover(Protocol):
    """Bodies that move by the same code: a group of robots, their parts, or obstacles."""

    bodies: Ints  # (M,) their indices among the bodies of the world

    @property
    def true_twist(self) -> Array:
        """Velocities `(M, 3)` [m/s, m/s, rad/s] over the last step in the bodies' frames."""

    def path(self) -> tuple[int, Array]:
        """The form of the paths (`amorsim.kernels.collision.paths`), and their parameters `(M, 3)`.

        For an arc, the twist over the whole step; for a line or another form, the displacement.
        """

    def travel(self) -> Array:
        """Length of each path [m] and total turning [rad] in the whole step `(M, 2)`, or upper bounds."""

    def poses_at(self, which: Ints, fraction: Array) -> Array:
        """World poses `(Q, 3)` of its bodies number `which` `(Q,)` at fractions `(Q,)` of the step."""

    def arrive(self, poses: Array, stop: Array) -> None:
        """Take the poses after the step `(M, 3)`, and the fraction of the step after which each stood still `(M,)`."""


@attrs.frozen(kw_only=True)
class Contact:
    """Two bodies, or a body and a wall (`other` is `WALL`), that touched at a fraction of the step.

    A part of a robot counts as a body of its own.
    """

    body: int
    other: int
    fraction: float
    point: tuple[float, float]


class Movement:
    """The step that all movers of a world make together; set up once, because the movers stay the same."""

    def __init__(self, world: World, movers: Sequence[Mover]) -> None:
        count = len(world.poses)
        self.movers = tuple(movers)
        self._world = world
        self._rows = [(mover, _rows_of(mover.bodies)) for mover in movers]
        # Which mover moves each body, and the body's number there.
        self._mover, self._number = np.full(count, -1, dtype=np.int64), np.zeros(count, dtype=np.int64)
        for index, mover in enumerate(movers):
            self._mover[mover.bodies], self._number[mover.bodies] = index, np.arange(len(mover.bodies))
        self._form = np.full(count, STANDS, dtype=np.uint8)
        self._motion = np.zeros((count, 3))
        self._bound = np.empty(count)
        self._fastest = np.empty(world.replicas)
        self._looking = np.empty(count, dtype=np.int64)
        self._end = np.empty((count, 3))
        # The kernels write `stop` and, except for form `OTHER`, `bound`.
        self._paths = Paths(world.poses, self._motion, self._form, self._bound, np.empty(count))

    def make(self) -> tuple[Array, Array, list[Contact]]:
        """Move all bodies through a step.

        Returns
        -------
        poses
            `(T, 3)` the poses afterwards.
        stop
            `(T,)` the fraction of the step after which each body stood still, 1 for those that touched nothing.
        contacts
            In order of time.
        """
        world, paths, end = self._world, self._paths, self._end
        self._lay_paths()
        count = set_out(paths, world.bodies.reach, world.first, world.clearance, end, self._fastest, self._looking)
        if world.has_parts:
            end[world.parts] = self._at(paths, world.parts, np.ones(len(world.parts)))
        contacts: list[Contact] = []
        if count:
            a, b = self._candidates(paths, self._looking[:count])
            if len(a):
                replica = world.replica_index[a]
                for map_, rows in world.terrain.between(replica, 0, len(a)):
                    contacts += self._resolve(map_, paths, a[rows], b[rows])
                if len(world.terrain.maps) > 1:  # those of one map are in order of time
                    contacts.sort(key=lambda contact: contact.fraction)
                stopped = np.flatnonzero(paths.stop < 1.0)
                end[stopped] = self._at(paths, stopped, paths.stop[stopped])
        world.clearance.at[:] = end
        return end, paths.stop, contacts

    def arrive(self, poses: Array, stop: Array) -> None:
        """Pass the results of `make` to the movers, and the resulting velocities to the world."""
        for mover, rows in self._rows:
            mover.arrive(np.ascontiguousarray(poses[rows]), np.ascontiguousarray(stop[rows]))
            self._world.twists[rows] = mover.true_twist

    def _lay_paths(self) -> None:
        """Take the movers' paths through this step."""
        for mover, rows in self._rows:
            form, motion = mover.path()
            self._form[rows] = form
            self._motion[rows] = motion
            if form == OTHER:
                travel = mover.travel()
                bound = travel[:, 0] + travel[:, 1] * self._world.bodies.reach[rows]
                self._bound[rows] = np.where(bound < LEAST, 0.0, bound * (1.0 + 1e-9))

    def _at(self, paths: Paths, bodies: Ints, fraction: Array) -> Array:
        """World poses `(Q, 3)` of bodies at fractions `(Q,)`; one that stopped stays where it stopped."""
        poses = np.empty((len(bodies), 3))
        poses_at(paths, bodies, fraction, poses)
        fraction = np.minimum(fraction, paths.stop[bodies])
        asks = (paths.form[bodies] == OTHER) & (fraction > 0.0) & (paths.bound[bodies] > 0.0)
        movers = self._mover[bodies]
        for index in np.unique(movers[asks]).tolist():
            mine = np.flatnonzero(asks & (movers == index))
            poses[mine] = self.movers[index].poses_at(self._number[bodies[mine]], fraction[mine])
        return poses

    def _scene(self, map_: Map, paths: Paths) -> Scene:
        world = self._world
        return Scene(map_.grid, *map_.origin, world.bodies, world.edge_rows, paths)

    def _candidates(self, paths: Paths, looking: Ints) -> tuple[Ints, Ints]:
        """The pairs of a body and a wall (b is `WALL`) or another body that might touch in this step, in order."""
        world = self._world
        near = np.empty(len(looking), dtype=np.uint8)
        replica = world.replica_index[looking]
        given = (
            *(world.replica_index, world.owner, world.by_place(paths.start)),
            *(self._fastest, world.widest, world.clearance, near),
        )

        def part(first: int, last: int) -> None:
            for map_, rows in world.terrain.between(replica, first, last):
                look_around(rows.start, rows.stop, looking, self._scene(map_, paths), *given)

        world.workers.share(len(looking), LOOK_WORK, part)
        a = looking[(near & NEAR_WALL) != 0]
        b = np.full(len(a), WALL, dtype=np.int64)
        close = looking[(near & NEAR_BODY) != 0]
        if len(close):
            looks = np.zeros(len(paths.start), dtype=np.bool_)
            looks[close] = True
            one, other = world.pairs_within(paths.start, paths.bound + SLACK, looks)
            a, b = np.concatenate((a, one)), np.concatenate((b, other))
            order = np.lexsort((b, a))
            a, b = a[order], b[order]
        return a, b

    def _resolve(self, map_: Map, paths: Paths, a: Ints, b: Ints) -> list[Contact]:
        """The contacts among pairs on one map that might touch; sets the `stop` of their paths."""
        world, scene = self._world, self._scene(map_, paths)
        asks = (paths.form[a] == OTHER) | ((paths.form[b] == OTHER) & (b != WALL))
        search = _search_of(a, b, asks, len(paths.form))
        shortest = min(SHORTEST, map_.resolution / 4.0)
        while waiting := resolve(scene, world.same_owner, search, shortest, MOST_LOOKS):
            if waiting < 0:
                raise _too_many_looks(world, paths, int(a[search.todo[0]]), int(b[search.todo[0]]))
            pairs = search.todo[:waiting]
            two = pairs[b[pairs] != WALL]
            search.poses[pairs, 0] = self._at(paths, a[pairs], search.fraction[pairs])
            search.poses[two, 1] = self._at(paths, b[two], search.fraction[two])
            search.answered[pairs] = True
        met = search.met[: search.used[MET]]
        a, b, when = a[met], b[met], search.when[: len(met)]
        poses, others = self._at(paths, a, when), self._at(paths, np.where(b == WALL, a, b), when)
        point = _points(world, a, poses, b, others)
        return [
            Contact(body=body, other=other, fraction=fraction, point=(x, y))
            for body, other, fraction, (x, y) in zip(a.tolist(), b.tolist(), when.tolist(), point.tolist(), strict=True)
        ]


def _rows_of(bodies: Ints) -> slice | Ints:
    """An index of some bodies, in order: a slice if they are evenly spaced."""
    step = int(bodies[1] - bodies[0]) if len(bodies) > 1 else 1
    return slice(int(bodies[0]), int(bodies[-1]) + 1, step) if (np.diff(bodies) == step).all() else bodies


def _search_of(a: Ints, b: Ints, asks: npt.NDArray[np.bool_], bodies: int) -> Search:
    """A search that has not begun, of pairs among a number of `bodies`."""
    count = len(a)
    two = np.flatnonzero(b != WALL)
    pair, body = np.concatenate((np.arange(count), two)), np.concatenate((a, b[two]))
    order = np.argsort(body, kind="stable")
    leaves = 1 << (count - 1).bit_length()
    tree = np.full(2 * leaves, -1, dtype=np.int64)
    tree[leaves : leaves + count] = np.arange(count)
    return Search(
        a=a,
        b=b,
        asks=asks,
        answered=np.zeros(count, dtype=np.bool_),
        stage=np.zeros(count, dtype=np.int64),
        fraction=np.zeros(count),
        poses=np.zeros((count, 2, 3)),
        known=np.full((count, 2, 2, 3), np.nan),
        speed=np.empty(count),
        free=np.empty(count),
        hit=np.empty(count),
        gap=np.empty(count),
        guess=np.empty(count),
        looks=np.empty((count, 2), dtype=np.int64),
        time=np.full(count, np.inf),
        first=np.searchsorted(body[order], np.arange(bodies + 1)),
        of_body=pair[order],
        tree=tree,
        todo=np.arange(count),
        met=np.empty(count, dtype=np.int64),
        when=np.empty(count),
        used=np.array([count, 0]),
    )


def _too_many_looks(world: World, paths: Paths, a: int, b: int) -> ContactError:
    """The error for a step in which the search of a pair does not end."""
    fast = a if b == WALL or paths.bound[a] >= paths.bound[b] else b
    other = "the walls" if b == WALL else repr(world.name(b if fast == a else a))
    return ContactError(
        f"{world.name(fast)!r}, of {2.0 * world.bodies.reach[fast]:.3g} m, moves points of its outline by up to "
        f"{paths.bound[fast]:.3g} m in one step, and goes along {other} so closely that its contacts cannot be found: "
        f"they were looked for at {MOST_LOOKS} places; expected some metres a step at the most, as of a shorter dt, or "
        "of smaller speeds and rates"
    )


def _points(world: World, a: Ints, poses: Array, b: Ints, others: Array) -> Array:
    """Points of contact [m] `(Q, 2)` of pairs at their poses `(Q, 3)`."""
    # The point between the two that is equally near to both circles: the shapes touch close to it.
    reach = world.bodies.reach
    share = reach[a] / (reach[a] + reach[b])
    point = poses[:, :2] + share[:, None] * (others[:, :2] - poses[:, :2])
    wall = np.flatnonzero(b == WALL)
    if len(wall):
        _, point[wall] = world.wall_gaps(a[wall], poses[wall], np.full(len(wall), TOUCH))
    return point
