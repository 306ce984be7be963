"""The schedule of a step: the calls that make it, in order, each bound to the arrays that it reads and writes."""

from __future__ import annotations

import itertools
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import Any, NamedTuple, NoReturn

from amorsim.core.arguments import whole
from amorsim.core.error_text import RAISED

__all__ = ["PHASES", "Call", "Schedule", "walk"]

PHASES = ("control", "actuate", "move", "sense", "estimate", "record")
"""The phases of a step, in order. All rows finish one before the next begins."""


class Call(NamedTuple):
    """One call of a step: a function without arguments, bound to arrays that keep their place."""

    phase: str
    """One of `PHASES`."""
    label: str
    """Whose call it is, and what it does: ``"rover x 64 / laser: Laser"``."""
    run: Callable[[], None]
    blame: Callable[[BaseException], NoReturn] | None = None
    """Raises an exception of a component as one that names the robot, the component and the time."""


def walk(calls: Iterable[Call]) -> None:
    """Make the calls in order."""
    for call in calls:
        try:
            call.run()
        except RAISED as error:
            if call.blame is None:
                raise
            call.blame(error)


class Schedule(Sequence[Call]):
    """The calls of a simulation's step, in order, as they are now: ``print(simulation.schedule)``.

    They are prepared when a simulation begins, and again when parameters change or an episode begins.
    """

    def __init__(
        self, calls: Callable[[], Sequence[Call]], try_steps: Callable[[int, Callable[[], None]], None]
    ) -> None:
        self._calls = calls
        self._try_steps = try_steps

    def __getitem__(self, index: Any) -> Any:
        return self._calls()[index]

    def __len__(self) -> int:
        return len(self._calls())

    def __iter__(self) -> Iterator[Call]:
        return iter(self._calls())

    def __str__(self) -> str:
        return "\n".join(f"{call.phase:<9} {call.label}" for call in self)

    def __repr__(self) -> str:
        return f"<Schedule of {len(self)} calls; print it to see them>"

    def profile(self, steps: int = 100) -> str:
        """The schedule as text, with the mean time of each call in microseconds.

        It makes `steps` steps, and then puts the simulation back to where it was.
        """
        steps = whole(steps, "steps", "a number of steps >= 1", least=1)
        calls = tuple(self._calls())
        rounds: list[list[int]] = []

        def step() -> None:
            times = [time.perf_counter_ns()]
            for call in calls:
                call.run()
                times.append(time.perf_counter_ns())
            rounds.append([after - before for before, after in itertools.pairwise(times)])

        self._try_steps(steps + 1, step)
        spent = [sum(column) for column in zip(*rounds[1:], strict=True)]  # the first loads kernels
        mean = [total / steps / 1000.0 for total in spent]
        lines = [f"{us:8.1f} us  {call.phase:<9} {call.label}" for us, call in zip(mean, calls, strict=True)]
        return "\n".join([*lines, f"{sum(mean):8.1f} us  in all"])
