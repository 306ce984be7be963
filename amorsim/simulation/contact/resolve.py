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

import functools
from collections.abc import Callable, Iterator, Sequence
from typing import NoReturn, Protocol

import attrs
import numpy as np

from amorsim.array_types import AnyArray, Array, Bools, Ints
from amorsim.core.errors import AmorsimError, ContactError
from amorsim.core.execution.workers import in_turn
from amorsim.core.maps.map import Map
from amorsim.kernels.collision.broad_phase import NEAR_BODY, NEAR_WALL, look_around, set_out
from amorsim.kernels.collision.paths import OTHER, SLACK, STANDS, Paths, Scene, poses_at
from amorsim.kernels.collision.time_of_impact import MET, WALL, Search, resolve
from amorsim.simulation.error_context import is_finite
from amorsim.simulation.schedule import Call
from amorsim.simulation.world.world import World

__all__ = ["WALL", "Contact", "Movement", "Mover"]


# Bodies that touch and slide are tested at most this far apart; a wall is at least a cell, 1 mm, thick.
SHORTEST = 2.5e-4  # [m]
# A wall that stopped a body is nearer than this.
TOUCH = 0.01  # [m]
# Number of tests of a pair in one step: enough for a hundred metres along a wall, touching it, in cells of 1 mm.
MOST_LOOKS = 400_000
# Cost of one body's broad phase, in rays.
LOOK_WORK = 16

_NOBODY: Ints = np.empty(0, dtype=np.int64)


class Mover(Protocol):
    """Bodies that move by the same code: a group of robots, their parts, or obstacles.

    Each step first calls the function of `bind_path`, and after contact that of `bind_arrival`.
    """

    bodies: Ints  # (M,) their indices among the bodies of the world

    @property
    def label(self) -> str:
        """Their name in the schedule."""

    @property
    def true_twist(self) -> Array:
        """Velocities `(M, 3)` [m/s, m/s, rad/s] over the last step in the bodies' frames."""

    def bind_path(self, motion: Array, travel: Array) -> tuple[int, Callable[[], None]]:
        """The form of the paths (`amorsim.kernels.collision.paths`), and a function that writes their parameters.

        Into `motion` `(M, 3)`, for an arc, the twist over the whole step; for a line or another form, the displacement.
        For another form also, into `travel` `(M, 2)`, upper bounds of each path's length [m] and turning [rad].
        """

    def bind_arrival(self, poses: Array, stop: Array) -> Callable[[], None]:
        """A function that takes the poses `(M, 3)` after the step, and the fraction `stop` `(M,)` of the step.

        After that fraction each body stood still.
        """

    def poses_at(self, which: Ints, fraction: Array) -> Array:
        """World poses `(Q, 3)` of the bodies with the numbers `which` `(Q,)`, at fractions `(Q,)` of the step."""

    def blame(self, error: BaseException) -> NoReturn:
        """Raise an exception again, as an error that names the bodies whose motion caused it."""

    def bad_motion(self, motion: Array) -> AmorsimError:
        """The error for motions `(M, 3)` that are not all finite."""


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
    """The step that all movers of a world make together; set up once, because the movers stay the same.

    Attributes
    ----------
    end
        `(T, 3)` the poses of all bodies after the step, as `meet` found them.
    """

    def __init__(self, world: World, movers: Sequence[Mover]) -> None:
        count = len(world.poses)
        self.movers = tuple(movers)
        self._world = world
        self._rows = [(mover, _rows_of(mover.bodies)) for mover in movers]
        # Which mover moves each body, and the body's number there.
        self._mover, self._number = np.full(count, -1, dtype=np.int64), np.zeros(count, dtype=np.int64)
        for index, mover in enumerate(movers):
            self._mover[mover.bodies], self._number[mover.bodies] = index, np.arange(len(mover.bodies))
        self._travel = np.zeros((count, 2))  # of paths of form `OTHER`
        self._fastest = np.empty(world.replicas)
        self._looking = np.empty(count, dtype=np.int64)
        self.end = np.empty((count, 3))
        stands = np.full(count, STANDS, dtype=np.uint8)
        self._paths = Paths(world.poses, np.zeros((count, 3)), stands, np.empty(count), np.empty(count))

    def path_calls(self) -> Iterator[Call]:
        """The calls that find the movers' paths through a step."""
        for mover, rows in self._rows:
            motion, put_motion, _ = _part_of(self._paths.motion, rows)
            travel, put_travel, _ = _part_of(self._travel, rows)
            form, path = mover.bind_path(motion, travel)
            self._paths.form[rows] = form
            yield Call("move", f"{mover.label} / path", in_turn([path, *put_motion, *put_travel]), mover.blame)

    def arrival_calls(self) -> Iterator[Call]:
        """The calls that pass the results of `meet` to the movers, and the resulting velocities to the world."""
        for mover, rows in self._rows:
            poses, _, fetch_poses = _part_of(self.end, rows)
            stop, _, fetch_stop = _part_of(self._paths.stop, rows)
            arrive = mover.bind_arrival(poses, stop)
            keep = functools.partial(self._keep_twists, mover, rows)
            run = in_turn([*fetch_poses, *fetch_stop, arrive, keep])
            yield Call("move", f"{mover.label} / arrival", run, mover.blame)

    def _keep_twists(self, mover: Mover, rows: slice | Ints) -> None:
        self._world.twists[rows] = mover.true_twist

    def meet(self) -> list[Contact]:
        """Move all bodies along their paths until they touch something; the contacts are in order of time."""
        world, paths, end = self._world, self._paths, self.end
        bodies = world.bodies.reach, world.first, *world.clearance
        start, motion, form, bound, stop = paths
        count = set_out(start, motion, form, self._travel, bound, stop, *bodies, end, self._fastest, self._looking)
        if count < 0:
            bad = next(m for m, rows in self._rows if not is_finite(motion[rows]))
            raise bad.bad_motion(motion[bad.bodies])
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
        return contacts

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
        if not np.count_nonzero(near):
            return _NOBODY, _NOBODY
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


def _part_of(
    whole: AnyArray, rows: slice | Ints
) -> tuple[AnyArray, list[Callable[[], None]], list[Callable[[], None]]]:
    """Some rows of an array, contiguous in memory, as kernels need them.

    Also the functions that copy its rows to the whole and back; none where it is a view.
    """
    if isinstance(rows, slice) and rows.step == 1:
        return whole[rows], [], []
    own = np.array(whole[rows])

    def put() -> None:
        whole[rows] = own

    def fetch() -> None:
        own[...] = whole[rows]

    return own, [put], [fetch]


def _search_of(a: Ints, b: Ints, asks: Bools, bodies: int) -> Search:
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
    """The error for a step in which the search for the contact of a pair does not end."""
    fast = a if b == WALL or paths.bound[a] >= paths.bound[b] else b
    other = "the walls" if b == WALL else repr(world.name(b if fast == a else a))
    return ContactError(
        f"{world.name(fast)!r}, of {2.0 * world.bodies.reach[fast]:.3g} m, moves points of its outline by up to "
        f"{paths.bound[fast]:.3g} m in one step, and goes along {other} so closely that its contacts cannot be found: "
        f"they were looked for at {MOST_LOOKS} places; expected some metres a step at most, as of a shorter dt, or "
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
