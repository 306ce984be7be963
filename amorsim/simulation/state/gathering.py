"""The values of all robots of a fleet together, in order of replica, then of name."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Iterable

import numpy as np

from amorsim.array_types import AnyArray, Bools
from amorsim.simulation.contact.resolve import WALL
from amorsim.simulation.fleet.fleet import Fleet
from amorsim.simulation.fleet.group import Group

__all__ = ["digest_of", "gathered", "touching_robots"]


def gathered(fleet: Fleet, of: Callable[[Group], AnyArray]) -> AnyArray:
    """An array of all groups' rows, read-only, as one `(N, ...)`."""
    if len(fleet.groups) == 1:
        whole = of(fleet.groups[0]).copy()
    else:
        parts = np.concatenate([of(group) for group in fleet.groups])
        bodies = np.concatenate([group.bodies for group in fleet.groups])
        whole = parts[np.argsort(bodies)]
    whole.flags.writeable = False
    return whole


def touching_robots(fleet: Fleet) -> Bools:
    """Whether each robot or one of its parts touches something that it moves towards, `(N,)`."""
    world = fleet.world
    found = np.zeros((len(fleet.replicas), world.count), dtype=bool)
    for pair in fleet.touching:
        found.flat[[world.owner[body] for body in pair if body != WALL]] = True
    return found[:, : len(fleet.names)].reshape(-1)


def digest_of(fleet: Fleet, replicas: Iterable[int]) -> str:
    """A fingerprint of all exact results of the replicas with these numbers since the start."""
    whole = hashlib.blake2b(digest_size=16)
    world = fleet.world
    for number in replicas:
        first = int(world.first[fleet.replicas.index(number)])
        for body in range(first, first + world.named):
            group, row = fleet.row_of(body)
            whole.update(world.name(body).encode() + group.fingerprint[row].astype("<u8").tobytes())
    return whole.hexdigest()
