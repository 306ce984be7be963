"""What a peer must be able to do, so that it can be timed and watched."""

from __future__ import annotations

import abc
import importlib.metadata
from typing import ClassVar

import attrs
import numpy as np
import numpy.typing as npt

from benchmarks.contest import Clock, Seen, drive, strayed, track_conduct, watch
from benchmarks.results import Ratio, Spread, compare
from benchmarks.task import Task, Track

__all__ = ["Contender", "Peer"]

Array = npt.NDArray[np.float64]


class Peer(abc.ABC):
    """A peer that drives a task's robots.

    Only `step` is timed, one step after another; `ranges` and `poses` are read before that, while it is watched.
    """

    name: ClassVar[str]
    distribution: ClassVar[str]
    computes: ClassVar[str]
    """What a step of it computes, for the table."""
    lag: ClassVar[int] = 0
    """By how many steps its scans trail its poses."""
    separate_worlds: ClassVar[bool] = False
    """Whether its robots cannot see or meet one another."""
    in_bitmaps: ClassVar[bool] = True
    """Whether it is asked to drive through bitmap worlds."""
    most_robots: ClassVar[int] = 1000
    """With more it is not asked to drive."""

    @classmethod
    @abc.abstractmethod
    def prepare(cls) -> None:
        """Import what is needed.

        Raises
        ------
        ImportError
            If it is not installed.
        """

    @classmethod
    def version(cls) -> str:
        """The version that is installed."""
        return importlib.metadata.version(cls.distribution)

    @abc.abstractmethod
    def __init__(self, task: Task) -> None: ...

    @abc.abstractmethod
    def reset(self) -> None:
        """Put the robots back to their starts."""

    @abc.abstractmethod
    def step(self, index: int) -> None:
        """Make step `index` with its twists: move, meet what is in the way, sense all beams."""

    @abc.abstractmethod
    def ranges(self) -> Array:
        """The last scans `(N, beams)` [m], with noise where the peer has it."""

    @abc.abstractmethod
    def poses(self) -> Array:
        """The present poses `(N, 3)`."""


@attrs.define(kw_only=True)
class Contender:
    """A peer in a contest: watched once, and timed over the same steps."""

    peer: Peer
    seen: Seen
    why_not: str
    """Why its ratio does not count, if so."""

    @classmethod
    def of(cls, peer: Peer, track: Track, steps: int, at_most: float) -> Contender:
        """Watch it over up to `steps` steps, fewer if they take longer than `at_most` seconds."""
        seen = watch(peer, steps, at_most)
        assert seen.conduct.steps is not None
        return cls(
            peer=peer, seen=seen, why_not=compare(track_conduct(track, seen.conduct.steps, peer.lag), seen.conduct)
        )

    @property
    def name(self) -> str:
        """With the version."""
        return f"{self.peer.name} {self.peer.version()}"

    def seconds_a_step(self, at_least: float, clock: Clock) -> float:
        """Drive it for `at_least` seconds."""
        assert self.seen.conduct.steps is not None
        made = drive(self.peer, self.seen.conduct.steps, at_least, clock)
        self.why_not = self.why_not or strayed(self.peer, self.seen)
        return made.seconds / made.steps

    def ratio(self, spread: Spread) -> Ratio:
        """The ratio, and whether it counts."""
        return Ratio(spread=spread, counts=not self.why_not, why_not=self.why_not)
