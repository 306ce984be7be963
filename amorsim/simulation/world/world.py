"""The bodies of all replicas in their world: their poses and shapes, and the gaps between them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from amorsim.array_types import Array, Bools, Ints
from amorsim.core.execution.workers import Workers, in_turn
from amorsim.core.maps.map import Map
from amorsim.core.shapes import Shape, pack
from amorsim.kernels.collision import body_hash
from amorsim.kernels.collision import clearance as contact_kernels
from amorsim.kernels.collision import footprints as body_kernels
from amorsim.kernels.collision.body_hash import BodyHash
from amorsim.kernels.collision.broad_phase import Clearance
from amorsim.kernels.collision.footprints import Bodies
from amorsim.kernels.raycast import body_beams, body_cones, body_rays
from amorsim.simulation.world.marks_and_lamps import Surroundings
from amorsim.simulation.world.terrain import Terrain

__all__ = ["CONE_WORK", "Emitted", "World", "empty_hash"]


CONE_WORK = 16
"""Cost of a cone, in rays."""

_GAP_WORK = 8  # of one gap to the walls

FEW = 16
"""Up to this number of bodies, a replica needs no hash: all are compared."""


class Emitted(NamedTuple):
    """All emitters of a medium, by replica: e of them, in order of body."""

    poses: Array  # (R, e, 3)
    half_angle: Array  # (R, e)
    fired: Bools  # (R, e)
    time: Array  # (R, e)
    body: Ints  # (R, e)
    sensor: npt.NDArray[np.str_]  # (e,)


class World:
    """One map for all replicas or one for each, and in all the same bodies, in order of replica, then as given.

    A robot of several parts has several bodies: its own, and one for each part. The parts come after all robots and
    obstacles. All bodies of a robot have the same owner; bodies of one owner neither touch nor see each other.

    Attributes
    ----------
    terrain
        The maps.
    workers
        The threads that share the rows of long work.
    poses, twists
        `(T, 3)` true poses in the world, and velocities [m/s, m/s, rad/s] over the last step in the bodies' frames;
        they keep their place. Set `poses` as a whole.
    clearance
        Distances of each body to walls and to other bodies; the search for contact keeps them from step to step.
    widest
        The largest reach of a body [m].
    surroundings
        Marks, lamps, and the colours and heights of bodies.
    emissions
        The emitters that fire at this tick, by medium; see `amorsim.simulation.emissions`.
    first
        `(R + 1,)` the first body of each replica.
    everyone
        `(T,)` all bodies.
    edge_rows
        Vertices of the largest body: the number of rows of the kernels' scratch arrays.
    replica_index
        `(T,)` the replica of each body, counted from 0.
    is_robot
        `(B,)` which bodies of a replica are robots or parts of robots: the first `robots` of those given, or all.
    named
        Number of robots and obstacles in a replica; its other bodies are parts.
    owner
        `(T,)` the owner of each body: for a part, the body of its robot; for all others, the body itself.
    same_owner
        `(T,)` the next body with the same owner, as a ring.
    parts
        `(R * P,)` the bodies that are parts.
    """

    def __init__(
        self,
        map_: Map | Terrain,
        names: Sequence[str],
        shapes: Sequence[Shape],
        replicas: int,
        threads: int = 1,
        robots: int | None = None,
        surroundings: Surroundings | None = None,
        owners: Sequence[int] = (),
    ) -> None:
        self.terrain = map_ if isinstance(map_, Terrain) else Terrain.same(map_, replicas)
        self.surroundings = Surroundings.of(()) if surroundings is None else surroundings
        self.workers = Workers(threads)
        self.names = tuple(names)
        self.shapes = tuple(shapes)
        self.count = len(names)
        self.named = self.count - len(owners)
        number = np.arange(self.count)
        self.is_robot = (number < (self.count if robots is None else robots)) | (number >= self.named)
        self.replicas = replicas
        self.has_company = self.named > 1
        self.has_parts = len(owners) > 0
        self.bodies = pack(list(shapes) * replicas)
        self.edge_rows = max((sum(map(len, shape.vertices)) for shape in shapes), default=0)
        self.widest = max((shape.reach for shape in shapes), default=1.0)
        self._hash: BodyHash | None = None
        self._hashed: Array | None = None  # the poses that `_hash` is made from; None once the bodies have moved
        self.first: Ints = np.arange(replicas + 1, dtype=np.int64) * self.count
        self.replica_index: Ints = np.repeat(np.arange(replicas, dtype=np.int64), self.count)
        self.everyone: Ints = np.arange(replicas * self.count, dtype=np.int64)
        whose = np.concatenate((np.arange(self.named, dtype=np.int64), np.array(owners, dtype=np.int64)))
        self.owner: Ints = (self.first[:-1, None] + whose).reshape(-1)
        self.parts: Ints = np.flatnonzero(self.owner != self.everyone)
        self.same_owner = _rings(self.owner)
        self._poses: Array = np.zeros((replicas * self.count, 3))
        self.twists: Array = np.zeros((replicas * self.count, 3))
        nothing = np.zeros(replicas * self.count)
        self.clearance = Clearance(np.full_like(self._poses, np.nan), nothing, nothing.copy())
        self.emissions: dict[str, Emitted] = {}
        self.marks_near = 0  # about as many as the last search found: the size of the next one's buffers

    @property
    def poses(self) -> Array:
        """The true poses `(T, 3)` of all bodies in the world; an array that keeps its place."""
        return self._poses

    @poses.setter
    def poses(self, poses: Array) -> None:
        self._poses[...] = poses
        self._hashed = None

    def name(self, body: int) -> str:
        """The name of a body, the same in every replica."""
        return self.names[body % self.count]

    def whose(self, body: int) -> tuple[str, str]:
        """The name of the robot or obstacle that a body belongs to, and of the part; "" for its own body."""
        name = self.name(body)
        owner = self.name(int(self.owner[body]))
        return owner, name[len(owner) + 1 :]

    def parts_of(self, bodies: Ints) -> Ints:
        """The parts `(N, p)` of robots' bodies `(N,)`, in order; all have the same number."""
        if not self.has_parts:
            return np.empty((len(bodies), 0), dtype=np.int64)
        # Parts are in order of their owners, so those of one owner are contiguous.
        owners = self.owner[self.parts]
        first, last = np.searchsorted(owners, bodies), np.searchsorted(owners, bodies, side="right")
        found: Ints = self.parts[first[:, None] + np.arange(int((last - first)[0]))]
        return found

    def wall_gaps(self, bodies: Ints, poses: Array, cap: Array) -> tuple[Array, Array]:
        """Signed gaps [m] `(Q,)` of bodies at `poses` to the walls, at most `cap`, and the nearest points `(Q, 2)`.

        A gap is below zero exactly if a body's inside overlaps an occupied cell's.
        """
        out = np.empty(len(bodies))
        where = np.empty((len(bodies), 2))
        replica = self.replica_index[bodies]

        def part(a: int, b: int) -> None:
            for map_, rows in self.terrain.between(replica, a, b):
                walls = map_.grid, *map_.origin, self.bodies
                contact_kernels.map_gaps(*walls, bodies[rows], poses[rows], cap[rows], out[rows], where[rows])

        self.workers.share(len(bodies), _GAP_WORK, part)
        return out, where

    def body_gaps(self, a: Ints, poses_a: Array, b: Ints, poses_b: Array, cap: Array) -> Array:
        """Signed gaps [m] `(Q,)` between pairs of bodies, at most `cap`; below zero where they overlap."""
        out = np.empty(len(a))
        if not len(a):  # a lone robot need not load or compile this kernel
            return out
        body_kernels.body_gaps(self.bodies, a, poses_a, b, poses_b, cap, out)
        return out

    def by_place(self, poses: Array) -> BodyHash:
        """The spatial hash of the bodies at `poses` `(T, 3)`; made once per array, until the bodies move."""
        if self._hash is None or poses is not self._hashed:
            if self._hash is None:
                self._hash = empty_hash(self.count, self.replicas, 2.0 * self.widest)
            body_hash.hash_bodies(poses, self.bodies.reach, self.owner, self.first, self._hash)
            self._hashed = poses
        return self._hash

    def pairs_within(self, poses: Array, margin: Array, looks: Bools | None = None) -> tuple[Ints, Ints]:
        """The pairs of bodies of one replica whose circles, each grown by its margin `(T,)` [m], meet; in order.

        Bodies of one owner are not a pair. If `looks` `(T,)` is given, it marks at least one body of each pair.
        """
        if not self.has_company:
            none = np.empty(0, dtype=np.int64)
            return none, none
        radius = self.bodies.reach + margin
        table = self.by_place(poses)
        if looks is None:
            looks = np.ones(len(poses), dtype=np.bool_)
        found = np.empty(4 * int(np.count_nonzero(looks)) + 64, dtype=np.int64)
        count = body_hash.pairs_within(table, self.replica_index, looks, poses, radius, found)
        if count > len(found):
            found = np.empty(count, dtype=np.int64)
            body_hash.pairs_within(table, self.replica_index, looks, poses, radius, found)
        a, b = np.divmod(np.sort(found[:count]), len(poses))
        if self.has_parts:
            apart = self.owner[a] != self.owner[b]
            a, b = a[apart], b[apart]
        return a, b

    def bind_cast(
        self,
        own: Ints,
        replica: Ints,
        origins: Array,
        cos_b: Array,
        sin_b: Array,
        range_max: Array,
        out: Array,
        hit: Ints | None = None,
    ) -> Callable[[], None]:
        """A function that lowers `out` where another body of the same replica is nearer; see `body_rays.cast_bodies`.

        `hit`, if given, is like `out`, is filled with -1, and gets the body that a beam hits. A robot `own` `(N,)` sees
        neither itself nor its parts.
        """
        cast: Any = body_beams.cast_beams if cos_b.shape[1] == 1 else body_rays.cast_bodies

        def prepare(a: int, b: int) -> Callable[[], None]:
            mine = slice(a, b) if len(cos_b) > 1 else slice(None)
            beams: Any = replica[a:b], own[a:b], origins[a:b], cos_b[mine], sin_b[mine], range_max[a:b], out[a:b]
            hits = _NO_HITS if hit is None else hit[a:b]
            return lambda: cast(*self.met(), *beams, hits)

        return in_turn([self._find_places, self.workers.bind(len(origins), cos_b.shape[1], prepare)])

    def bind_hear(
        self,
        own: Ints,
        replica: Ints,
        origins: Array,
        half_angle: float,
        cos_b: Array,
        sin_b: Array,
        range_max: Array,
        out: Array,
    ) -> Callable[[], None]:
        """A function that lowers `out` `(N,)` where a body in a cone is nearer; see `body_cones.nearest_bodies`."""

        def prepare(a: int, b: int) -> Callable[[], None]:
            before, after = (replica[a:b], own[a:b], origins[a:b]), (range_max[a:b], out[a:b])
            return lambda: body_cones.nearest_bodies(*self.met(), *before, half_angle, cos_b, sin_b, *after)

        return in_turn([self._find_places, self.workers.bind(len(origins), CONE_WORK, prepare)])

    def _find_places(self) -> None:
        """Bring the spatial hash up to date, before threads read it."""
        self.by_place(self.poses)

    def met(self) -> tuple[Bodies, Array, int, BodyHash, float]:
        """The bodies at their present poses, as the kernels that look for them take them."""
        return self.bodies, self.poses, self.edge_rows, self.by_place(self.poses), self.widest


_NO_HITS: Ints = np.empty((0, 0), dtype=np.int64)  # for calls that do not need what was hit


def _rings(owner: Ints) -> Ints:
    """For each body `(T,)` the next one with the same owner, and after the last the first."""
    order = np.argsort(owner, kind="stable")
    owners = owner[order]
    first, last = np.searchsorted(owners, owners), np.searchsorted(owners, owners, side="right")
    after = np.arange(1, len(owner) + 1)
    ring = np.empty_like(owner)
    ring[order] = order[np.where(after < last, after, first)]
    return ring


def empty_hash(count: int, replicas: int, side: float) -> BodyHash:
    """An empty hash for `count` bodies in each replica: at least four buckets a body, or one for a few bodies."""
    bits = 0 if count <= FEW else (4 * count - 1).bit_length()
    rows, cols = 1 << bits // 2, 1 << (bits + 1) // 2
    bodies = count * replicas
    return BodyHash(
        side=side,
        rows=rows,
        cols=cols,
        first=np.empty(replicas * rows * cols + 1, dtype=np.int64),
        body=np.empty(bodies, dtype=np.int64),
        owner=np.empty(bodies, dtype=np.int64),
        disc=np.empty((bodies, 3)),
    )
