"""The last snapshot that another process can go on from, should this one be lost; taken now and then."""

from __future__ import annotations

import pickle
import time
from typing import Any

import attrs
import numpy as np
import numpy.typing as npt

from amorsim.core.errors import SnapshotError
from amorsim.simulation.simulation import Simulation

__all__ = ["Carried", "Carrier"]

MOST_BYTES = 16_000_000  # of all that is carried
MOST_BYTES_OF_PATHS = 4_000_000
LEAST_BETWEEN = 2.0  # [s]
SHARE = 50.0  # the time between two is at least this many times what taking one lasts


@attrs.frozen(kw_only=True)
class Carried:
    """A snapshot before anything was given to the simulation at its tick, and the paths up to there.

    `paths` holds true, then estimated poses `(n, R, 6)` of every `stride`-th tick.
    """

    tick: int
    snapshot: bytes
    stride: int
    paths: npt.NDArray[np.float32]

    def to_bytes(self) -> bytes:
        """For a pipe."""
        return pickle.dumps(attrs.asdict(self), pickle.HIGHEST_PROTOCOL)

    @classmethod
    def from_bytes(cls, data: bytes) -> Carried:
        """The state in the result of `to_bytes`."""
        table: dict[str, Any] = pickle.loads(data)
        return cls(**table)


class Carrier:
    """Takes snapshots to be carried.

    Attributes
    ----------
    reason
        Why there are none, or nothing.
    """

    def __init__(self) -> None:
        self.reason = ""
        self._due = time.monotonic() + LEAST_BETWEEN

    @property
    def is_due(self) -> bool:
        """Whether it is time for another one."""
        return not self.reason and time.monotonic() >= self._due

    def take(self, simulation: Simulation, tick: int, stride: int, paths: npt.NDArray[np.float32]) -> Carried | None:
        """Take a snapshot to be sent; None if it cannot be sent, with the `reason`."""
        began = time.monotonic()
        while paths.nbytes > MOST_BYTES_OF_PATHS and len(paths) > 2:
            paths, stride = paths[::2], 2 * stride
        try:
            snapshot = simulation.snapshot().to_bytes()
        except SnapshotError as error:
            self.reason = str(error)
            return None
        if len(snapshot) + paths.nbytes > MOST_BYTES:
            self.reason = f"a snapshot would be larger than {MOST_BYTES / 1e6:g} MB"
            return None
        now = time.monotonic()
        self._due = now + max(LEAST_BETWEEN, SHARE * (now - began))
        return Carried(tick=tick, snapshot=snapshot, stride=stride, paths=paths.copy())
