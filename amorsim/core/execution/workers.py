"""Threads that share the rows of a kernel's work.

Kernels release Python's global lock and write each row independently. So threads can work on slices of the rows in
parallel, and the bits are those of one thread. No thread is shared between simulations.
"""

from __future__ import annotations

import functools
import itertools
import os
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor, wait
from typing import TypeVar

__all__ = ["Workers", "at_first_call", "cores", "in_turn"]

T = TypeVar("T")

LEAST_WORK = 8_000
"""Smaller work is not split: handing a slice to another thread takes up to 0.1 ms, and saves half of the work at most.

In rays, or work of the same cost: some 25 ns each.
"""


def cores() -> int:
    """The number of processors that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


class Workers:
    """A number of threads, including the caller's own; at most as many as processors."""

    def __init__(self, threads: int = 1, processors: int | None = None) -> None:
        self._asked = threads
        self.threads = min(threads, cores() if processors is None else processors)
        self._pool: ThreadPoolExecutor | None = None
        self._process = 0  # the process of the pool's threads

    def __reduce__(self) -> tuple[type[Workers], tuple[int]]:
        return Workers, (self._asked,)

    def share(self, rows: int, work_per_row: int, work: Callable[[int, int], None]) -> None:
        """Call ``work(first, end)`` for slices that make up all `rows`, one for each thread.

        `work_per_row` is the approximate cost of a row in rays; work too small to benefit from threads is done in one
        slice. An error in any slice is raised after all have ended.
        """
        self.bind(rows, work_per_row, lambda first, end: functools.partial(work, first, end))()

    def bind(
        self, rows: int, work_per_row: int, prepare: Callable[[int, int], Callable[[], None]]
    ) -> Callable[[], None]:
        """A function that does the work of all `rows`, as `share`; ``prepare(first, end)`` returns that of a slice.

        The slices are prepared now, once, and each call of the function does their work again.
        """
        if not rows:
            return _nothing
        threads = min(self.threads, rows)
        if threads < 2 or rows * work_per_row < LEAST_WORK:
            return prepare(0, rows)
        ends = [rows * number // threads for number in range(threads + 1)]
        mine, *others = itertools.starmap(prepare, itertools.pairwise(ends))
        return functools.partial(self._together, mine, others)

    def _together(self, mine: Callable[[], None], others: Sequence[Callable[[], None]]) -> None:
        """Run `others` in the other threads, and `mine` in this one."""
        pool = self._threads()
        handed_over = [pool.submit(other) for other in others]
        try:
            mine()
        finally:
            wait(handed_over)
        for other in handed_over:
            other.result()

    def _threads(self) -> ThreadPoolExecutor:
        if self._pool is None or self._process != os.getpid():  # a fork does not copy threads
            self._pool = ThreadPoolExecutor(self.threads - 1, thread_name_prefix="amorsim")
            self._process = os.getpid()
        return self._pool


def in_turn(calls: Sequence[Callable[[], None]]) -> Callable[[], None]:
    """One function that calls all of these in order."""
    if len(calls) == 1:
        return calls[0]

    def call_all() -> None:
        for call in calls:
            call()

    return call_all


def at_first_call(prepare: Callable[[], Callable[[], T]]) -> Callable[[], T]:
    """The function that `prepare` returns, which is called only when the function is."""
    prepared: list[Callable[[], T]] = []

    def call() -> T:
        if not prepared:
            prepared.append(prepare())
        return prepared[0]()

    return call


def _nothing() -> None:
    """The work of no rows."""
