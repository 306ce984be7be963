"""Random draws that are a pure function of names and time.

A draw depends on a key (seed, robot, component, element) and a counter (replica, episode, tick, index), and on
nothing else: no generator has a state to save, and no draws change when a sensor, a robot, a replica or a thread is
added.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Iterable, Sequence

import numpy as np
import numpy.typing as npt

from amorsim.array_types import Array
from amorsim.core.errors import AmorsimError
from amorsim.core.execution.workers import Workers
from amorsim.kernels.random import philox
from amorsim.kernels.sensing.noise_steps import MEDIANS

__all__ = ["Draws", "Medians", "check_collisions", "stream_key"]


def stream_key(seed: int, *names: str) -> int:
    """The 64-bit key of a stream: a hash of the seed and of the names (robot, component, element)."""
    text = "\x1f".join((str(seed), *names))
    return int.from_bytes(hashlib.blake2b(text.encode(), digest_size=8).digest(), "little")


def check_collisions(seed: int, streams: Iterable[tuple[str, ...]]) -> None:
    """Raise if two different streams would draw the same numbers (odds of one in 10^13 for a thousand streams)."""
    seen: dict[int, tuple[str, ...]] = {}
    for names in streams:
        other = seen.setdefault(stream_key(seed, *names), names)
        if other != names:
            raise AmorsimError(
                f"with seed {seed} the random draws of {' '.join(names)} and {' '.join(other)} would be the same; "
                "take another seed or rename one of them"
            )


class Draws:
    """The random numbers of one component (or one element of a noise chain), for N rows, at the current tick.

    Each call takes the next numbers of the tick; the next tick starts a new sequence.

    Parameters
    ----------
    keys
        `(N,)` uint64, from `stream_key`.
    counter
        `(N, 3)` uint32: replica, episode and tick of each row, kept up to date by the engine.
    workers
        Threads that share the rows; their number does not change the draws.
    rounds
        One number, shared by many streams: when it changes, the tick's numbers start again.
    """

    __slots__ = ("_block", "_counter", "_keys", "_round", "_rounds", "_workers")

    def __init__(
        self,
        keys: npt.NDArray[np.uint64],
        counter: npt.NDArray[np.uint32],
        workers: Workers | None = None,
        rounds: Sequence[int] = (0,),
    ) -> None:
        self._keys = keys
        self._counter = counter
        self._workers = workers
        self._rounds = rounds
        self._round = rounds[0]
        self._block = 0

    @property
    def keys(self) -> npt.NDArray[np.uint64]:
        """The keys of the rows `(N,)`; do not change them."""
        return self._keys

    def rewind(self) -> None:
        """Restart the tick's numbers; for the engine, before it calls the component."""
        self._block = 0

    def take(self, rows: npt.NDArray[np.intp]) -> Draws:
        """The draws of some of the rows, at the present tick and from its first number on."""
        return Draws(self._keys[rows], self._counter[rows], self._workers)

    @property
    def counter(self) -> npt.NDArray[np.uint32]:
        """Replica, episode and tick of the rows `(N, 3)`; do not change them."""
        return self._counter

    def still(self, rows: npt.NDArray[np.intp]) -> Draws:
        """The draws of some of the rows from the next number on, independent of later draws from this object."""
        kept = Draws(self._keys[rows], self._counter[rows], self._workers)
        kept._block = self._block if self._round == self._rounds[0] else 0
        return kept

    def share(self, work_per_row: int, work: Callable[[int, int], None]) -> None:
        """Call ``work(first, end)`` for slices of the rows, in the engine's threads if that is faster.

        For kernels that treat each row independently; `work_per_row` is the approximate cost of a row in rays.
        """
        if self._workers is None:
            work(0, len(self._keys))
        else:
            self._workers.share(len(self._keys), work_per_row, work)

    def bind_share(self, work_per_row: int, prepare: Callable[[int, int], Callable[[], None]]) -> Callable[[], None]:
        """A function that does the work of all rows, as `share`; ``prepare(first, end)`` returns that of a slice."""
        if self._workers is None:
            return prepare(0, len(self._keys))
        return self._workers.bind(len(self._keys), work_per_row, prepare)

    def normal(self, k: int = 1) -> Array:
        """Standard normal draws `(N, k)`, independent in all rows, columns, calls and ticks."""
        return self._fill(philox.fill_normal, k)

    def uniform(self, k: int = 1) -> Array:
        """Uniform draws in (0, 1), `(N, k)`, independent in all rows, columns, calls and ticks."""
        return self._fill(philox.fill_uniform, k)

    def reserve(self, k: int) -> tuple[npt.NDArray[np.uint64], npt.NDArray[np.uint32], int]:
        """Keys, counter and the number of the first block, for a kernel that draws the next `k` numbers of each row.

        `normal` and `uniform` use them too, see `amorsim.kernels.random.philox.pairs`. Do not change the arrays.
        """
        return self._keys, self._counter, self.next_block(k)

    def next_block(self, k: int) -> int:
        """Take the next `k` numbers of each row; returns the number of their first block."""
        if self._round != self._rounds[0]:
            self._round = self._rounds[0]
            self._block = 0
        block = self._block
        self._block += (k + 1) // 2
        return block

    def _fill(self, fill: Callable[..., None], k: int) -> Array:
        keys, counter, block = self.reserve(k)
        out = np.empty((len(keys), k))
        if self._workers is None or self._workers.threads == 1:
            fill(keys, counter, block, out)
        else:
            self._workers.share(len(keys), k, lambda a, b: fill(keys[a:b], counter[a:b], block, out[a:b]))
        return out


class Medians(Draws):
    """Returns medians of the distributions in place of draws: the typical behaviour of a component."""

    __slots__ = ()

    def next_block(self, k: int) -> int:
        """`noise_steps.MEDIANS` in place of a block."""
        return MEDIANS

    def normal(self, k: int = 1) -> Array:
        """Zeros `(N, k)`."""
        return np.zeros((len(self.keys), k))

    def uniform(self, k: int = 1) -> Array:
        """Halves `(N, k)`."""
        return np.full((len(self.keys), k), 0.5)
