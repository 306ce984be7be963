"""Noise as steps for a kernel: a whole chain of them in one call."""

from __future__ import annotations

import functools
from collections.abc import Callable, Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np

from amorsim.array_types import Array
from amorsim.core.draws import Draws
from amorsim.core.error_text import in_words
from amorsim.kernels.sensing import noise_steps as kernels

__all__ = ["NoiseProgram", "NoiseStep", "steps_problem"]


_RANDOM = (kernels.SCATTER, kernels.REPLACE)
_WORK = {kernels.SCATTER: 0.5, kernels.REPLACE: 0.25}  # cost of a value that needs a draw, in rays


class NoiseStep(NamedTuple):
    """One step of a noise element (`Noise.steps`), made by one of the methods below.

    Parameters of a step are numbers, or the element's own fields, which over rows are arrays `(N, 1)`.
    """

    kind: int
    a: Any
    b: Any

    @classmethod
    def scatter(cls, std: Any, proportional: Any = 0.0) -> NoiseStep:
        """Add normal noise of mean 0, its standard deviation `std` and `proportional` times the value's size."""
        return cls(kernels.SCATTER, std, proportional)

    @classmethod
    def add(cls, value: Any) -> NoiseStep:
        """Add the same to every value."""
        return cls(kernels.ADD, value, 0.0)

    @classmethod
    def multiply(cls, factor: Any) -> NoiseStep:
        """Multiply every value."""
        return cls(kernels.MULTIPLY, factor, 0.0)

    @classmethod
    def round(cls, step: Any) -> NoiseStep:
        """Round to the nearest multiple of `step`, halfway cases to the even one."""
        return cls(kernels.ROUND, step, 0.0)

    @classmethod
    def floor(cls, step: Any) -> NoiseStep:
        """Round down to a multiple of `step`."""
        return cls(kernels.FLOOR, step, 0.0)

    @classmethod
    def clip(cls, low: Any, high: Any) -> NoiseStep:
        """Clip to `low` and `high`; inf stays."""
        return cls(kernels.CLIP, low, high)

    @classmethod
    def replace(cls, probability: Any, value: Any) -> NoiseStep:
        """Replace each value by `value` with a probability."""
        return cls(kernels.REPLACE, probability, value)


def steps_problem(steps: Any, rows: int) -> str:
    """The fault of what an element's `steps` returned for a number of rows; empty if it is a sequence of steps."""
    # A step is a tuple too, so one that is not in a list would be taken for a list of its parts.
    if not isinstance(steps, (list, tuple)) or not all(isinstance(step, NoiseStep) for step in steps):
        return f"steps(): expected a list of NoiseStep, got {in_words(steps)}"
    for step in steps:
        for value in step[1:]:
            shape = np.shape(value)
            if shape not in ((), (1, 1), (rows, 1)):
                return f"steps(): expected numbers, or arrays ({rows}, 1) as fields are in a run, got the shape {shape}"
    return ""


class NoiseProgram:
    """The steps of several devices' noise, laid out for one call of the kernel.

    Parameters
    ----------
    sizes
        The number of values of each device.
    steps
        For each device its steps in order, each with the draws of its element. All draws have the same rows.
    """

    def __init__(self, sizes: Sequence[int], steps: Sequence[Sequence[tuple[NoiseStep, Draws]]]) -> None:
        flat = [pair for its in steps for pair in its]
        self._draws = flat[0][1] if flat else None
        self._random = [(s, draws, size) for s, (draws, size) in enumerate(_drawing(sizes, steps)) if size]
        self._blocks = np.zeros(len(flat), dtype=np.int64)
        if self._draws is None:
            return
        rows = len(self._draws.keys)
        parameters = [[np.broadcast_to(_column(value), (rows, 1)) for value in step[1:]] for step, _ in flat]
        self._program = kernels.Program(
            sizes=np.array(sizes, dtype=np.int64),
            ends=np.cumsum([len(its) for its in steps], dtype=np.int64),
            kinds=np.array([step.kind for step, _ in flat], dtype=np.int64),
            parameters=np.array(parameters)[..., 0].transpose(0, 2, 1).copy(),
            keys=np.array([draws.keys for _, draws in flat]),
            counter=self._draws.counter,
        )
        costs = [size * _WORK.get(step.kind, 0.05) for size, its in zip(sizes, steps, strict=True) for step, _ in its]
        self._work = 1 + int(sum(costs))

    def apply(self, values: Array, out: Array) -> None:
        """Write into `out` `(V,)` the values `(V,)` after the steps, device by device, with the next draws of the tick.

        For each device, the values of row 0 come first.
        """
        self.bind(values, out)()

    def bind(self, values: Array, out: Array) -> Callable[[], None]:
        """A function that does at each call what `apply` does, for arrays that keep their place."""
        if self._draws is None:
            return functools.partial(np.copyto, out, values)
        blocks, random = self._blocks, self._random
        work = self._draws.bind_share(
            self._work,
            lambda first, end: functools.partial(
                kernels.take_steps, first, end, *self._program, self._blocks, values, out
            ),
        )

        def apply() -> None:
            for s, draws, size in random:
                blocks[s] = draws.next_block(size)
            work()

        return apply


def _drawing(sizes: Sequence[int], steps: Sequence[Sequence[tuple[NoiseStep, Draws]]]) -> Iterator[tuple[Draws, int]]:
    """The draws of each step, and the number of draws for a row."""
    for size, its in zip(sizes, steps, strict=True):
        for step, draws in its:
            yield draws, size if step.kind in _RANDOM else 0


def _column(value: Any) -> Array:
    return np.asarray(value, dtype=np.float64)
