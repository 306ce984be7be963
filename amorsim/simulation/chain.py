"""A chain of noise elements over rows: what a device does to its quantity, or the ground to a wheel's travel."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from amorsim.contracts import Aim, Context, Draws, Noise, State
from amorsim.core.draws import stream_key
from amorsim.core.rows import stack
from amorsim.core.workers import Workers
from amorsim.scenario.spec import NoiseElement

__all__ = ["Chain", "Streams"]

Array = npt.NDArray[np.float64]


class Streams:
    """Makes the random streams of a group's components, each row keyed by its robot's name."""

    def __init__(
        self, seed: int, robots: Sequence[str], counter: npt.NDArray[np.uint32], workers: Workers | None = None
    ) -> None:
        self.seed = seed
        self._workers = workers
        self._robots = robots
        self._counter = counter
        self._made: list[Draws] = []

    def draws(self, *names: str) -> Draws:
        """The stream of a component of each row's robot."""
        known: dict[str, int] = {}
        for robot in self._robots:
            if robot not in known:
                known[robot] = stream_key(self.seed, robot, *names)
        keys = np.array([known[robot] for robot in self._robots], dtype=np.uint64)
        made = Draws(keys, self._counter, self._workers)
        self._made.append(made)
        return made

    def rewind(self) -> None:
        """Start every stream's numbers anew, at a new tick."""
        for draws in self._made:
            draws.rewind()


class Chain:
    """The elements in order, with their states and draws."""

    def __init__(self, elements: Sequence[NoiseElement], streams: Streams, *where: str) -> None:
        self.names = [element.name for element in elements]
        self.draws = [streams.draws(*where, "noise", name) for name in self.names]
        self.states: list[State] = [{} for _ in self.names]
        self.elements: list[Noise] = []
        kinds = [type(element.noise) for element in elements]
        self.aims = [i for i, kind in enumerate(kinds) if kind.aim is not Noise.aim]
        self.corrupts = [i for i, kind in enumerate(kinds) if kind.corrupt is not Noise.corrupt]
        self.delays = [i for i, kind in enumerate(kinds) if kind.delay is not Noise.delay]

    def set_parameters(self, rows: Sequence[Sequence[NoiseElement]]) -> None:
        """Take the parameters of every row's chain."""
        self.elements = [stack([chain[i].noise for chain in rows]) for i in range(len(self.names))]

    def start(self, context: Context) -> list[State]:
        """The elements' states at the start of an episode."""
        return [dict(element.start(context)) for element in self.elements]

    def aim(self, elapsed: Array) -> Aim:
        """Where the device really looks."""
        aim = Aim()
        for i in self.aims:
            aim = self.elements[i].aim(aim, elapsed, self.states[i], self.draws[i])
        return aim

    def delay(self, elapsed: Array) -> Array:
        """How much later than the latency a reading arrives `(N, 1)` [s]."""
        late = np.zeros_like(elapsed)
        for i in self.delays:
            late = late + self.elements[i].delay(elapsed, self.states[i], self.draws[i])
        return late

    def corrupt(self, values: Array, side: Mapping[str, Any], elapsed: Array) -> Array:
        """What the values `(N, k)` become on their way through the chain."""
        for i in self.corrupts:
            values = self.elements[i].corrupt(values, side, elapsed, self.states[i], self.draws[i])
        return values
