"""A chain of noise elements over rows: the errors of a device, or the effect of the ground on a wheel's travel."""

from __future__ import annotations

import functools
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any, NoReturn

import attrs
import numpy as np
import numpy.typing as npt

from amorsim.array_types import Array
from amorsim.contracts import Aim, Context, Draws, Noise, NoiseStep, State
from amorsim.core.draws import Medians, stream_key
from amorsim.core.error_text import RAISED
from amorsim.core.execution.workers import Workers
from amorsim.core.noise_steps import NoiseProgram, steps_problem
from amorsim.core.rows import stack
from amorsim.scenario.spec import NoiseElement
from amorsim.simulation.error_context import ErrorContext, array_problem

__all__ = ["Chain", "Streams"]

Steps = list[tuple[NoiseStep, Draws]]


class Streams:
    """Makes the random streams of a group's components, each row keyed by its robot's name."""

    def __init__(
        self, seed: int, robots: Sequence[str], counter: npt.NDArray[np.uint32], workers: Workers | None = None
    ) -> None:
        self.seed = seed
        self._workers = workers
        self._robots = robots
        self._counter = counter
        self._rounds = [0]

    def draws(self, *names: str) -> Draws:
        """The stream of one component, for each row's robot."""
        known: dict[str, int] = {}
        for robot in self._robots:
            if robot not in known:
                known[robot] = stream_key(self.seed, robot, *names)
        keys = np.array([known[robot] for robot in self._robots], dtype=np.uint64)
        return Draws(keys, self._counter, self._workers, self._rounds)

    def rewind(self) -> None:
        """Restart every stream's numbers at a new tick."""
        self._rounds[0] += 1


class Chain:
    """The elements in order, with their states and draws."""

    def __init__(
        self,
        elements: Sequence[NoiseElement],
        streams: Streams,
        whose: ErrorContext,
        *where: str,
        columns: Sequence[str] = (),
    ) -> None:
        self.names = [element.name for element in elements]
        self._whose = whose
        self._where = " ".join([where[0], *map(repr, where[1:])])
        self.draws = [streams.draws(*where, "noise", name) for name in self.names]
        self.states: list[State] = [{} for _ in self.names]
        self.elements: list[Noise] = []
        kinds = [type(element.noise) for element in elements]
        self.aims = [i for i, kind in enumerate(kinds) if kind.aim is not Noise.aim]
        self.corrupts = [
            i for i, kind in enumerate(kinds) if kind.corrupt is not Noise.corrupt or kind.steps is not Noise.steps
        ]
        # For elements of one column: the column's index, and the number of columns.
        self.column = [columns.index(element.column) if element.column else None for element in elements]
        self.columns = len(columns)
        # If set, it replaces `corrupt`: called with an element's number, the element and the arguments of `corrupt`.
        # Set it before the parameters are set.
        self.watch: Callable[..., Array] | None = None
        self._links: list[_Link] = []
        # The whole chain as steps for a kernel; None if an element is written in Python, or watched.
        self.steps: Steps | None = None
        self.slides = [i for i, kind in enumerate(kinds) if kind.slide is not Noise.slide]
        self.delays = [i for i, kind in enumerate(kinds) if kind.delay is not Noise.delay]

    def set_parameters(self, rows: Sequence[Sequence[NoiseElement]]) -> None:
        """Take the parameters of every row's chain."""
        self.elements = [stack([chain[i].noise for chain in rows]) for i in range(len(self.names))]
        self._links = list(self._linked())
        self.steps = [] if not self._links else self._links[0].steps if len(self._links) == 1 else None

    def _linked(self) -> Iterator[_Link]:
        """The links of the chain: one for neighbouring elements that are steps, one for each other element."""
        steps: list[tuple[NoiseStep, Draws]] = []
        for i in self.corrupts:
            its = [(step, self.draws[i]) for step in self._steps_of(i)] if self.watch is None else []
            column = self.column[i]
            if its and column is None:
                steps += its
                continue
            if steps:
                yield _Steps(steps)
                steps = []
            yield _Steps(its, slice(column, None, self.columns)) if its else _Element(self, i)
        if steps:
            yield _Steps(steps)

    def _steps_of(self, i: int) -> Sequence[NoiseStep]:
        """The steps of an element; none if a subclass of the class that declares them overrides `corrupt`."""
        kind = next(kind for kind in type(self.elements[i]).__mro__ if {"steps", "corrupt"} & vars(kind).keys())
        if "steps" not in vars(kind):
            return ()
        try:
            steps = self.elements[i].steps()
        except RAISED as error:
            self._blame(i, error)
        self._require(i, steps_problem(steps, len(self.draws[i].keys)))
        return steps

    def start(self, context: Context) -> list[State]:
        """The elements' states at the start of an episode."""
        part = attrs.evolve(context, size=context.size // self.columns) if self.columns else context
        states = []
        for i, column in enumerate(self.column):
            try:
                states.append(dict(self.elements[i].start(context if column is None else part)))
            except RAISED as error:
                self._whose.blame_start(self._what(i), self.elements[i], error)
        return states

    def aim(self, elapsed: Array) -> Aim:
        """The device's true aim."""
        aim = Aim()
        for i in self.aims:
            try:
                aim = self.elements[i].aim(aim, elapsed, self.states[i], self.draws[i])
            except RAISED as error:
                self._blame(i, error)
        return aim

    def delay(self, elapsed: Array) -> Array:
        """Delay of a reading in addition to the latency `(N, 1)` [s]."""
        late = np.zeros_like(elapsed)
        for i in self.delays:
            try:
                more = self.elements[i].delay(elapsed, self.states[i], self.draws[i])
                longest = self.elements[i].longest_delay()
            except RAISED as error:
                self._blame(i, error)
            self._require(i, array_problem(more, "delays", elapsed.shape, "delay()"))
            if not (more <= longest).all():  # nan too
                self._require(i, "expected delays of at most longest_delay() from delay(), got longer ones or nan")
            late = late + more
        return late

    def median(self, values: Array, side: Mapping[str, Any], elapsed: Array) -> Array:
        """The corrupted values `(N, k)` with all draws at their medians; changes no state."""
        for i in self.corrupts:
            state = {name: array.copy() for name, array in self.states[i].items()}
            draws = Medians(self.draws[i].keys, self.draws[i].counter)
            try:
                values = self.elements[i].corrupt(values, side, elapsed, state, draws)
            except RAISED as error:
                self._blame(i, error)
        return values

    def slide(self, motion: Array, elapsed: Array) -> Array:
        """The slide of bodies `(N, 3)` in addition to their `motion`."""
        slid = np.zeros_like(motion)
        for i in self.slides:
            try:
                more = self.elements[i].slide(motion, elapsed, self.states[i], self.draws[i])
            except RAISED as error:
                self._blame(i, error)
            self._require(i, array_problem(more, "slides", motion.shape, "slide()"))
            slid = slid + more
        return slid

    def longest_delay(self) -> Array:
        """Upper bound of `delay` `(N, 1)` [s]; `(1, 1)` if it is the same for all."""
        longest = np.zeros((1, 1))
        for i in self.delays:
            try:
                longest = longest + self.elements[i].longest_delay()
            except RAISED as error:
                self._blame(i, error)
        return longest

    def corrupt(self, values: Array, side: Mapping[str, Any], elapsed: Array) -> Array:
        """The values `(N, k)` after the chain."""
        for link in self._links:
            values = link.corrupt(values, side, elapsed)
        return values

    def through(self, i: int, values: Array, side: Mapping[str, Any], elapsed: Array) -> Array:
        """The values after element `i`."""
        column, element, state, draws = self.column[i], self.elements[i], self.states[i], self.draws[i]
        corrupt = element.corrupt if self.watch is None else functools.partial(self.watch, i, element)
        try:
            if column is None:
                return corrupt(values, side, elapsed, state, draws)
            mine = slice(column, None, self.columns)
            part = np.ascontiguousarray(values[:, mine])
            values = values.copy()
            values[:, mine] = corrupt(part, _Part(side, mine), elapsed, state, draws)
            return values
        except RAISED as error:
            self._blame(i, error)

    def _require(self, i: int, problem: str) -> None:
        """Raise if an element's answer breaks its contract."""
        if problem:
            raise self._whose.wrong(self._what(i), self.elements[i], problem)

    def _blame(self, i: int, error: BaseException) -> NoReturn:
        self._whose.blame(self._what(i), self.elements[i], error)

    def _what(self, i: int) -> str:
        return f"noise element {self.names[i]!r} of {self._where}"


class _Element:
    """An element of a chain that is called on its own."""

    steps: Steps | None = None

    def __init__(self, chain: Chain, i: int) -> None:
        self._chain, self._i = chain, i

    def corrupt(self, values: Array, side: Mapping[str, Any], elapsed: Array) -> Array:
        return self._chain.through(self._i, values, side, elapsed)


class _Steps:
    """Neighbouring elements that run in one kernel call; all of them act on the same columns of a sample."""

    def __init__(self, steps: Steps, columns: slice | None = None) -> None:
        self.steps: Steps | None = steps if columns is None else None
        self._steps, self._columns = steps, slice(None) if columns is None else columns
        self._before, self._after = np.empty((0, 0)), np.empty((0, 0))
        self._run: Callable[[], None] | None = None

    def __getstate__(self) -> dict[str, Any]:
        """All but what is bound to the arrays, which a copy binds again."""
        return {**vars(self), "_run": None}

    def corrupt(self, values: Array, side: Mapping[str, Any], elapsed: Array) -> Array:
        mine = values[:, self._columns]
        if self._run is None or self._before.shape != mine.shape:
            self._before, self._after = np.empty(mine.shape), np.empty(mine.shape)
            program = NoiseProgram([mine.shape[1]], [self._steps])
            self._run = program.bind(self._before.reshape(-1), self._after.reshape(-1))
        self._before[:] = mine
        self._run()
        found = np.array(values)
        found[:, self._columns] = self._after
        return found


_Link = _Element | _Steps


class _Part(Mapping[str, Array]):
    """One column of a sensor's further quantities; each array is made on access."""

    def __init__(self, side: Mapping[str, Array], columns: slice) -> None:
        self._side, self._columns = side, columns

    def __contains__(self, name: object) -> bool:
        return name in self._side

    def __getitem__(self, name: str) -> Array:
        return np.ascontiguousarray(self._side[name][:, self._columns])

    def __iter__(self) -> Iterator[str]:
        return iter(self._side)

    def __len__(self) -> int:
        return len(self._side)
