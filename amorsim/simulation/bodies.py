"""The bodies of all replicas in their world: where they stand, what shapes they have, who can meet whom."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from amorsim.core.map import Map
from amorsim.core.shapes import Shape, pack
from amorsim.kernels import bodies as body_kernels
from amorsim.kernels import contact as contact_kernels

__all__ = ["Emitted", "World"]

Array = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]


class Emitted(NamedTuple):
    """All emitters of a medium, by replica: e of them, in order of body."""

    poses: Array  # (R, e, 3)
    half_angle: Array  # (R, e)
    fired: npt.NDArray[np.bool_]  # (R, e)
    body: Ints  # (R, e)
    sensor: npt.NDArray[np.str_]  # (e,)


class World:
    """One map, and in every replica the same bodies, in order of replica, then of the order given.

    Attributes
    ----------
    poses, twists
        `(T, 3)` true poses in the world, and velocities [m/s, m/s, rad/s] over the last step in the bodies' frames;
        replaced, never changed.
    emissions
        What fires at this tick, by medium; see `amorsim.simulation.emissions`.
    first
        `(R + 1,)` the first body of each replica.
    everyone
        `(T,)` all bodies.
    replica_index
        `(T,)` which replica a body is of, counted from 0.
    """

    def __init__(self, map_: Map, names: Sequence[str], shapes: Sequence[Shape], replicas: int) -> None:
        self.map = map_
        self.names = tuple(names)
        self.shapes = tuple(shapes)
        self.count = len(names)
        self.replicas = replicas
        self.has_company = self.count > 1
        self.bodies = pack(list(shapes) * replicas)
        self.first: Ints = np.arange(replicas + 1, dtype=np.int64) * self.count
        self.replica_index: Ints = np.repeat(np.arange(replicas, dtype=np.int64), self.count)
        self.everyone: Ints = np.arange(replicas * self.count, dtype=np.int64)
        self.poses: Array = np.zeros((replicas * self.count, 3))
        self.twists: Array = np.zeros((replicas * self.count, 3))
        self.emissions: dict[str, Emitted] = {}

    def name(self, body: int) -> str:
        """The name of a body, the same in every replica."""
        return self.names[body % self.count]

    def wall_gaps(self, bodies: Ints, poses: Array, cap: Array) -> tuple[Array, Array]:
        """Signed gaps [m] `(Q,)` of bodies at `poses` to the walls, at most `cap`, and the nearest points `(Q, 2)`.

        Below zero exactly where a body's inside meets an occupied cell's.
        """
        out = np.empty(len(bodies))
        where = np.empty((len(bodies), 2))
        x, y, yaw = self.map.origin
        contact_kernels.map_gaps(self.map.grid, x, y, yaw, self.bodies, bodies, poses, cap, out, where)
        return out, where

    def body_gaps(self, a: Ints, poses_a: Array, b: Ints, poses_b: Array, cap: Array) -> Array:
        """Signed gaps [m] `(Q,)` between pairs of bodies, at most `cap`; below zero where they overlap."""
        out = np.empty(len(a))
        if not len(a):  # a lone robot never loads, nor compiles, what it takes to meet others
            return out
        body_kernels.body_gaps(self.bodies, a, poses_a, b, poses_b, cap, out)
        return out

    def pairs_within(self, poses: Array, margin: Array) -> tuple[Ints, Ints]:
        """The pairs of bodies of one replica whose circles, each grown by its margin `(T,)` [m], meet.

        Bodies are sorted along x within their replica and swept, so far ones are never compared.
        """
        none = np.empty(0, dtype=np.int64)
        if not self.has_company:
            return none, none
        radius = self.bodies.reach + margin
        low, high = poses[:, 0] - radius, poses[:, 0] + radius
        order = np.lexsort((low, self.replica_index))
        found_a: list[Ints] = []
        found_b: list[Ints] = []
        for step in range(1, self.count):
            left, right = order[:-step], order[step:]
            near = (self.replica_index[left] == self.replica_index[right]) & (low[right] <= high[left])
            if not near.any():
                break  # sorted by low: whoever is `step` places on is too far, so all after him are too
            left, right = left[near], right[near]
            offset = poses[left, :2] - poses[right, :2]
            meet = (offset**2).sum(axis=1) <= (radius[left] + radius[right]) ** 2
            found_a.append(left[meet])
            found_b.append(right[meet])
        if not found_a:
            return none, none
        a, b = np.concatenate(found_a), np.concatenate(found_b)
        a, b = np.minimum(a, b), np.maximum(a, b)
        order = np.lexsort((b, a))
        return a[order], b[order]
