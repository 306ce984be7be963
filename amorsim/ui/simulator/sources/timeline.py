"""The past of a running simulation, to look back on: poses of every tick, and snapshots now and then."""

from __future__ import annotations

import copy
from collections.abc import Iterator

import numpy as np
import numpy.typing as npt

from amorsim.array_types import AnyArray, Array
from amorsim.core.errors import SnapshotError
from amorsim.simulation.simulation import Simulation
from amorsim.simulation.state.snapshot import Snapshot

__all__ = ["MOST_BYTES_OF_SNAPSHOTS", "Paths", "Snapshots"]


MOST_BYTES_OF_PATHS = 64_000_000
MOST_MOMENTS = 100_000  # of a path: at full speed, a single robot would take minutes to fill the bytes
MOST_SNAPSHOTS = 128
MOST_BYTES_OF_SNAPSHOTS = 256_000_000
FIRST_STRIDE = 50  # ticks between snapshots, at first


class Paths:
    """True and estimated poses of all robots; every tick at first, every second when there are too many, and so on.

    They begin at the tick `first`.
    """

    def __init__(self, robots: int, most_bytes: int = MOST_BYTES_OF_PATHS, *, first: int = 0) -> None:
        self._first = first
        self._most = max(4, min(MOST_MOMENTS, most_bytes // (24 * max(robots, 1))))
        self._kept = np.empty((min(1024, self._most), robots, 6), dtype=np.float32)
        self._count = 0
        self.stride = 1
        self.newest = first

    def keep(self, tick: int, true: Array, estimated: Array) -> None:
        """Keep the poses `(R, 3)` of a tick; ticks come in order."""
        self.newest = tick
        since = tick - self._first
        if since % self.stride:
            return
        if self._count == len(self._kept):
            if self._count >= self._most:
                self._thin()
                if since % self.stride:
                    return
            else:
                self._kept.resize((min(2 * self._count, self._most), *self._kept.shape[1:]), refcheck=False)
        self._kept[self._count, :, :3] = true
        self._kept[self._count, :, 3:] = estimated
        self._count += 1

    def _thin(self) -> None:
        self._count = (self._count + 1) // 2
        self._kept[: self._count] = self._kept[: 2 * self._count : 2].copy()
        self.stride *= 2

    def at(self, tick: int) -> tuple[int, npt.NDArray[np.float32]]:
        """The last tick at or before `tick` that was kept, and its poses: true, then estimated `(R, 6)`."""
        place = max(0, min((tick - self._first) // self.stride, self._count - 1))
        return self._first + place * self.stride, self._kept[place]

    @property
    def kept(self) -> npt.NDArray[np.float32]:
        """All that is kept `(n, R, 6)`, of every `stride`-th tick."""
        return self._kept[: self._count]

    def put(self, kept: npt.NDArray[np.float32], stride: int, newest: int) -> None:
        """Take the poses that another one kept, up to a tick."""
        self._kept, self._count = kept.copy(), len(kept)
        self.stride, self.newest = stride, newest

    def cut(self, tick: int) -> None:
        """Forget what came after `tick`."""
        self._count = min(self._count, (tick - self._first) // self.stride + 1)
        self.newest = min(self.newest, tick)

    def copy(self) -> Paths:
        """Another with the same poses."""
        other = copy.copy(self)
        other._kept = self._kept[: max(self._count, 1)].copy()
        return other

    def track(self, robot: int, most: int) -> tuple[list[int], Array]:
        """Ticks and poses `(n, 6)` of one robot, at most `most` of them, including the last."""
        every = max(1, -(-self._count // max(most, 2)))
        # From the end, so that a path ends where its robot is.
        places = np.arange(self._count - 1, -1, -every)[::-1]
        return (self._first + places * self.stride).tolist(), self._kept[places, robot].astype(float)


class Snapshots:
    """Snapshots by tick, at distances that grow as a simulation runs; or the reason why there are none.

    They begin at the tick `first`.
    """

    def __init__(
        self, most_bytes: int = MOST_BYTES_OF_SNAPSHOTS, stride: int = FIRST_STRIDE, *, first: int = 0
    ) -> None:
        self._first = first
        self._held: dict[int, Snapshot] = {}
        self._most_bytes = most_bytes
        self._most = MOST_SNAPSHOTS
        self._size = 0  # of one [bytes]
        self.stride = stride
        self.reason = ""

    def keep(self, simulation: Simulation, tick: int) -> None:
        """Take a snapshot if one is due at this tick, before anything is given to the simulation at it."""
        if self.reason or (tick - self._first) % self.stride:
            return
        try:
            self._held[tick] = simulation.snapshot()
        except SnapshotError as error:
            self.reason = str(error)
            self._held.clear()
            return
        if len(self._held) == 1:
            self._size = max(1, sum(array.nbytes for array in _arrays(self._held[tick])))
            self._most = max(2, min(MOST_SNAPSHOTS, self._most_bytes // self._size))
        if len(self._held) > self._most:
            self.stride *= 2
            self._held = {at: snapshot for at, snapshot in self._held.items() if (at - self._first) % self.stride == 0}

    def before(self, tick: int) -> tuple[int, Snapshot] | None:
        """The last snapshot at or before a tick."""
        ticks = [at for at in self._held if at <= tick]
        return (max(ticks), self._held[max(ticks)]) if ticks else None

    def copy(self) -> Snapshots:
        """Another that holds the same snapshots."""
        other = copy.copy(self)
        other._held = dict(self._held)
        return other

    def cut(self, tick: int) -> None:
        """Forget what came after `tick`."""
        self._held = {at: snapshot for at, snapshot in self._held.items() if at <= tick}

    def __len__(self) -> int:
        return len(self._held)

    @property
    def nbytes(self) -> int:
        """About how many bytes they take."""
        return self._size * len(self._held)


def _arrays(snapshot: Snapshot) -> Iterator[AnyArray]:
    for group in snapshot.groups:
        for held in (*group.arrays.values(), *group.states.values()):
            yield from held.values()
