"""What a peer must be able to do, so that it can be timed and watched."""

from __future__ import annotations

import abc
import importlib.metadata
from typing import ClassVar

import numpy as np
import numpy.typing as npt

from benchmarks.task import Task

__all__ = ["Peer"]

Array = npt.NDArray[np.float64]


class Peer(abc.ABC):
    """A peer that drives a task's robots.

    Only `step` is timed; `ranges` and `poses` are asked between steps.
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
