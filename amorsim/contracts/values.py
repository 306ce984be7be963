"""The values that components pass to one another: readings, estimates, aims and the clock."""

from __future__ import annotations

import abc
from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import NamedTuple

from amorsim.array_types import AnyArray, Array, Bools, Ints

__all__ = ["Aim", "Beliefs", "BeliefsByName", "Clock", "Estimate", "LazyBeliefs", "Measurement", "State"]


State = dict[str, AnyArray]
Beliefs = Mapping[str, AnyArray]
"""An estimator's beliefs besides the pose: arrays by name, first axis the row; nan where there is nothing."""


class LazyBeliefs(Mapping[str, AnyArray]):
    """Beliefs some of which are functions that compute an array when it is looked up: for large ones, rarely needed.

    Only for the step in which it was made: the functions may read the state as it is then.
    """

    def __init__(self, arrays: Mapping[str, AnyArray | Callable[[], AnyArray]]) -> None:
        self._arrays = arrays

    def __getitem__(self, name: str) -> AnyArray:
        found = self._arrays[name]
        return found() if callable(found) else found

    def __contains__(self, name: object) -> bool:
        return name in self._arrays  # computes nothing

    def __iter__(self) -> Iterator[str]:
        return iter(self._arrays)

    def __len__(self) -> int:
        return len(self._arrays)


class BeliefsByName(Mapping[str, Beliefs]):
    """The beliefs of estimators and controllers that have any, by name."""

    @abc.abstractmethod
    def some(self, name: str, wanted: Iterable[str]) -> Beliefs:
        """The wanted beliefs of one of them; others need not be computed."""


class Clock(NamedTuple):
    """The time of each row: `tick` (N, 1), `time` (N, 1) [s], and the step `dt` [s]."""

    tick: Ints
    time: Array
    dt: float


class Measurement(NamedTuple):
    """A reading as the robot receives it: the measured values `(N, k)`, their tick and age, and if they are new."""

    measured: Array
    stamp: Ints  # (N, 1), the tick of the values; -1 before the first arrive
    age: Array  # (N, 1) [s], since that tick
    fresh: Bools  # (N, 1), whether they arrived in this step


class Estimate(NamedTuple):
    """An estimate of the robot's pose: `pose` (N, 3) [m, m, rad] and `covariance` (N, 3, 3)."""

    pose: Array
    covariance: Array


class Aim(NamedTuple):
    """Offsets of a sensor's beams: an angle [rad] added to each beam's bearing `(N, k)`, or None.

    `time` `(N, k)` [s] is when each beam is measured relative to this tick, at most 0; None: all at the tick.
    An element of a chain adds to the aim that it is given (``aim._replace``). A sensor without beams ignores both.
    """

    bearing: Array | None = None
    time: Array | None = None
