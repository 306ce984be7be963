"""The maps of all replicas: one for all, or one for each, kept within a limit of memory."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Self

import attrs
import numpy as np

from amorsim.array_types import Ints
from amorsim.core.errors import AmorsimError
from amorsim.core.execution.memory import memory_of_machine
from amorsim.core.maps.map import Map
from amorsim.worlds.drawn import DrawnWorld, origin_of
from amorsim.worlds.made import MadeWorld

__all__ = ["MOST_BYTES", "Terrain", "Terrains", "bytes_of", "map_limit"]


MOST_BYTES = 4_000_000_000
"""The maps of all replicas take no more memory than this [bytes], nor more than half of what the machine has."""


@attrs.frozen(eq=False)
class Terrain:
    """The maps of replicas; those that are the same are kept once.

    Attributes
    ----------
    maps
        Each map once.
    of_replica
        `(R,)` which of them each replica has, by its index.
    """

    maps: tuple[Map, ...]
    of_replica: Ints

    @classmethod
    def same(cls, map_: Map, replicas: int) -> Self:
        """One map for all replicas."""
        return cls((map_,), np.zeros(replicas, dtype=np.int64))

    @classmethod
    def of(cls, map_: Map, replicas: Sequence[int]) -> Self:
        """The map of each replica, by its number, in a scenario whose map is `map_`.

        Raises
        ------
        MapError
            If a generator cannot make the world of a replica; the message names the replica.
        AmorsimError
            If the maps take more memory than `map_limit`: at once, if one of them alone does, and before any step.
        """
        origin = origin_of(map_)
        if origin is None:
            return cls.same(map_, len(replicas))
        origins = [origin.of(replica) for replica in replicas]
        made = [one.made() for one in origins]
        different = len(set(made))
        _check_limit(different * bytes_of(map_), different)
        maps: list[Map] = []
        places: dict[MadeWorld, int] = {}
        taken = 0
        for one, source in zip(origins, made, strict=True):
            if source in places:
                continue
            places[source] = len(maps)
            maps.append(map_ if source == origin.made() else one.make())
            taken += bytes_of(maps[-1])
            _check_limit(taken * different / len(maps), different)
        return cls(tuple(maps), np.array([places[source] for source in made], dtype=np.int64))

    def at(self, index: int) -> Map:
        """The map of the replica with that index."""
        return self.maps[int(self.of_replica[index])]

    def between(self, replica: Ints, first: int, end: int) -> Sequence[tuple[Map, slice]]:
        """Rows `first` to `end` - 1 in slices, each with the map that its rows are on.

        `replica` is the index of each row's replica; rows in order of replica make the fewest slices.
        """
        if len(self.maps) == 1:
            return ((self.maps[0], slice(first, end)),)
        which = self.of_replica[replica[first:end]]
        ends = (np.flatnonzero(which[1:] != which[:-1]) + 1 + first).tolist()
        return [
            (self.maps[int(which[begin - first])], slice(begin, until))
            for begin, until in zip([first, *ends], [*ends, end], strict=True)
        ]


class Terrains:
    """The terrains of a scenario's map and of the maps that robots know, for some replicas; each is made once."""

    def __init__(self, replicas: Sequence[int]) -> None:
        self._replicas = tuple(replicas)
        self._known: dict[DrawnWorld, Terrain] = {}

    def of(self, map_: Map) -> Terrain:
        """The terrain of a map; what is raised is as for `Terrain.of`."""
        origin = origin_of(map_)
        if origin is None:
            return Terrain.same(map_, len(self._replicas))
        if origin not in self._known:
            self._known[origin] = Terrain.of(map_, self._replicas)
        return self._known[origin]


def map_limit() -> int:
    """The memory [bytes] that the maps of all replicas may take: `MOST_BYTES`, or half of the machine's if less."""
    there = memory_of_machine()
    return MOST_BYTES if there is None else min(MOST_BYTES, there // 2)


def bytes_of(map_: Map) -> int:
    """The memory that a map takes [bytes]."""
    held: list[Any] = [*map_.grid, *map_.segment_index, map_.segments, *(map_.unknown or ())]
    return sum(array.nbytes for array in held if isinstance(array, np.ndarray))


def _check_limit(wanted: float, maps: int) -> None:
    limit = map_limit()
    if wanted > limit:
        raise AmorsimError(
            f"{maps} replicas with a map each need about {wanted / 1e9:.3g} GB for the maps, and the limit is "
            f"{limit / 1e9:.3g} GB (4 GB, or half of the machine's memory); expected at most "
            f"{int(limit * maps / wanted)} replicas at once, a coarser resolution or smaller worlds"
        )
