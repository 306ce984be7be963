"""Random draws that are a pure function of who asks and when.

A draw depends on a key (seed, robot, component, element) and a counter (replica, episode, tick, index), and on
nothing else: no generator has a state to save, and nobody's draws change when a sensor, a robot, a replica or a
thread is added.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterable

import numpy as np
import numpy.typing as npt

from amorsim.core.errors import AmorsimError
from amorsim.kernels import philox

__all__ = ["Draws", "check_collisions", "stream_key"]

Array = npt.NDArray[np.float64]


def stream_key(seed: int, *names: str) -> int:
    """The 64-bit key of a stream: a hash of the seed and of the names (robot, component, element)."""
    text = "\x1f".join((str(seed), *names))
    return int.from_bytes(hashlib.blake2b(text.encode(), digest_size=8).digest(), "little")


def check_collisions(seed: int, streams: Iterable[tuple[str, ...]]) -> None:
    """Raise where two different streams would draw the same numbers (odds of one in 10^13 for a thousand streams)."""
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

    Each call takes the next numbers of the tick; at the next tick they start anew.

    Parameters
    ----------
    keys
        `(N,)` uint64, from `stream_key`.
    counter
        `(N, 3)` uint32: replica, episode and tick of each row, kept up to date by the engine.
    """

    __slots__ = ("_block", "_counter", "_keys")

    def __init__(self, keys: npt.NDArray[np.uint64], counter: npt.NDArray[np.uint32]) -> None:
        self._keys = keys
        self._counter = counter
        self._block = 0

    def rewind(self) -> None:
        """Start the tick's numbers anew; for the engine, before it calls the component."""
        self._block = 0

    def normal(self, k: int = 1) -> Array:
        """Standard normal draws `(N, k)`, independent in all rows, columns, calls and ticks."""
        out = np.empty((len(self._keys), k))
        philox.fill_normal(self._keys, self._counter, self._block, out)
        self._block += (k + 1) // 2
        return out

    def uniform(self, k: int = 1) -> Array:
        """Uniform draws in (0, 1), `(N, k)`, independent in all rows, columns, calls and ticks."""
        out = np.empty((len(self._keys), k))
        philox.fill_uniform(self._keys, self._counter, self._block, out)
        self._block += (k + 1) // 2
        return out
