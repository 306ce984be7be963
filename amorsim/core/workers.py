"""Threads that share the rows of a kernel's work.

Kernels release Python's global lock and write each row by itself, so rows can be worked on side by side and give the
bits that one thread gives, whoever takes which (`amorsim.kernels.shares`). No kernel is compiled a second time for it,
and no thread is shared between simulations, so there is nothing to lock.

The other threads are inside a kernel while they work and for a while after that, and get work there without Python.
Then they go to sleep.
"""

from __future__ import annotations

import atexit
import os
import queue
import threading
import time
import weakref
from collections.abc import Callable
from typing import TypeVar

import numpy as np

from amorsim.kernels import shares
from amorsim.kernels.beside import cores
from amorsim.kernels.shares import ALONE

__all__ = ["ALONE", "Workers", "cores"]

# Work that is smaller is not parted. In rays, or what costs about as much: some 25 ns each.
LEAST_WORK = 1_500
# So much is taken at once at least.
_GRAIN_WORK = 200
# How long [s] a thread looks for other work before it goes to sleep, and the caller for others to end before it lets
# them have its core.
_LOOKS = 400e-6
_WAITS = 400e-6
_PAUSE = 50e-6
_LAST = 5.0  # [s] that a thread gets to end with the process
_TURNS = 1 << 18
_MOST = 1 << (shares.ROW_BITS - 1)  # units that a ticket can count, and room

R = TypeVar("R")
_Slices = Callable[[int], None]


class Workers:
    """So many threads; one of them is the caller's own. There are no more of them than processors."""

    def __init__(self, threads: int = 1, processors: int | None = None) -> None:
        self._asked = threads
        self.threads = min(threads, cores() if processors is None else processors)
        self._crew: _Crew | None = None

    def __reduce__(self) -> tuple[type[Workers], tuple[int]]:
        return Workers, (self._asked,)

    def share(self, rows: int, work_per_row: int, work: Callable[[int], R]) -> R:
        """What ``work(share)`` gives: one call of one kernel, which spreads its rows where that pays.

        It is called with `ALONE` where it does not, and else hands the share on to `shares.spread`.
        """
        if not self._pays(rows, work_per_row):
            return work(ALONE)
        return self._found().lend(rows, work_per_row, work)

    def share_slices(self, rows: int, work_per_row: int, work: Callable[[int, int], None]) -> None:
        """Call ``work(first, end)`` for slices that make up all `rows`; for kernels that take no shares.

        An error that is raised in any thread is raised once all have ended.
        """
        if self._pays(rows, work_per_row):
            self._found().share(rows, work_per_row, lambda share: _by_slices(share, rows, work))
        elif rows:
            work(0, rows)

    def _pays(self, rows: int, work_per_row: int) -> bool:
        return self.threads > 1 and rows > 1 and rows * work_per_row >= LEAST_WORK

    def _found(self) -> _Crew:
        crew = self._crew
        if crew is None or crew.process != os.getpid():  # threads do not come along when a process forks
            crew = self._crew = _Crew(self.threads)
            _crews.add(crew)
            weakref.finalize(self, crew.dismiss).atexit = False
        return crew


def _by_slices(share: int, rows: int, work: Callable[[int, int], None]) -> None:
    first, end = shares.take_rows(share, rows, 0)
    while first < end:
        work(first, end)
        first, end = shares.take_rows(share, rows, end)


class _Crew:
    """The threads beside the caller's, and the words by which they find their work."""

    def __init__(self, threads: int) -> None:
        self.process = os.getpid()
        self._threads = threads
        size = shares.RECORDS + threads * shares.LINE
        room = np.zeros((size + shares.LINE) // 8, dtype=np.int64)
        skipped = -room.ctypes.data % shares.LINE
        self._room = room  # which the words are a part of
        self._words = memoryview(room.data)[skipped // 8 : (skipped + size) // 8]
        self._base = room.ctypes.data + skipped
        looks = _per_second(self._base)
        self._words[shares.THREADS // 8] = threads
        for number in range(threads):
            self._note(number, shares.BASE, self._base)
            self._note(number, shares.NUMBER, number)
            self._note(number, shares.PATIENCE, int((_LOOKS if number else _WAITS) * looks))
        self._task: tuple[int, _Slices | None] = 0, None  # Python's work, and at which turn
        self._called = 0  # how often there was work
        self._is_engaged = False
        self._is_dismissed = False
        self._errors: list[BaseException] = []
        self._asleep = [False] * threads
        self._calls: list[queue.SimpleQueue[None]] = [queue.SimpleQueue() for _ in range(threads)]
        self._others = [
            threading.Thread(target=self._serve, args=(number,), name=f"amorsim_{number}", daemon=True)
            for number in range(1, threads)
        ]
        for other in self._others:
            other.start()

    def _place(self, number: int, what: int) -> int:
        return (shares.RECORDS + number * shares.LINE + what) // 8

    def _note(self, number: int, what: int, word: int) -> None:
        self._words[self._place(number, what)] = word

    def _share_of(self, number: int) -> int:
        return self._base + shares.RECORDS + number * shares.LINE

    def _call_together(self, rows: int, work_per_row: int) -> int:
        """Say how rows are to be parted, and wake who sleeps; rows that a ticket counts as one."""
        words = self._words
        unit = 1 + rows // _MOST
        words[shares.UNIT // 8] = unit
        words[shares.GRAIN // 8] = 1 + _GRAIN_WORK // (work_per_row * unit)
        self._called += 1
        for number in range(1, self._threads):
            if self._asleep[number]:
                self._asleep[number] = False
                self._calls[number].put(None)
        return unit

    def lend(self, rows: int, work_per_row: int, work: Callable[[int], R]) -> R:
        if self._is_engaged:  # by work that has work to share itself
            return work(ALONE)
        self._is_engaged = True
        try:
            self._call_together(rows, work_per_row)
            return work(self._share_of(0))
        finally:
            self._is_engaged = False

    def share(self, rows: int, work_per_row: int, work: _Slices) -> None:
        if self._is_engaged:
            work(ALONE)
            return
        self._is_engaged = True
        words = self._words
        turn = words[self._place(0, shares.TURN)] % _TURNS + 1
        self._task = turn, work
        unit = self._call_together(rows, work_per_row)
        words[shares.WORK // 8] = 0
        words[shares.TICKET // 8] = turn << 2 * shares.ROW_BITS | -(-rows // unit)
        self._note(0, shares.TURN, turn)
        try:
            work(self._share_of(0))
        finally:
            self._settle(turn)
        if self._errors:
            errors, self._errors = self._errors, []
            raise errors[0]

    def _settle(self, turn: int) -> None:
        """Wait until nobody works any more; whatever was not taken will not be."""
        words = self._words
        words[shares.TICKET // 8] = turn << 2 * shares.ROW_BITS
        interrupt = None
        while not shares.is_done(self._base):
            try:
                time.sleep(_PAUSE)  # somebody else has the other's processor
            except KeyboardInterrupt as error:
                interrupt = error
        self._task = turn, None
        self._is_engaged = False
        if interrupt is not None:
            raise interrupt

    def _serve(self, number: int) -> None:
        """What the thread of a number does, until it is dismissed."""
        share = self._share_of(number)
        while not self._is_dismissed:
            called = self._called
            if not shares.serve(share):
                self._asleep[number] = True
                if self._called == called and not self._is_dismissed:
                    self._calls[number].get()
                self._asleep[number] = False
                continue
            turn, work = self._task
            if work is None:
                continue
            self._note(number, shares.TURN, turn)
            try:
                work(share)
            except BaseException as error:
                if self._words[self._place(number, shares.BUSY)]:  # else others have done it all
                    self._errors.append(error)
            self._note(number, shares.BUSY, 0)
            del work

    def dismiss(self) -> None:
        """Let the threads end."""
        self._is_dismissed = True
        self._words[shares.RAISED // 8] = -1 << 32  # whoever waits for work sees that it is not the same any more
        for call in self._calls:
            call.put(None)

    def see_off(self) -> None:
        """Let the threads end, and wait until they have."""
        if self.process == os.getpid():  # none are there in a process that has forked
            self.dismiss()
            for other in self._others:
                other.join(_LAST)


_crews: weakref.WeakSet[_Crew] = weakref.WeakSet()


@atexit.register
def _see_all_off() -> None:
    """A thread that still ran while Python ends would be stopped in the middle of a kernel."""
    for crew in list(_crews):
        crew.see_off()


def _per_second(base: int) -> float:
    """How often a thread that waits looks in a second."""
    shares.linger(base, 1)
    times = 1_000
    least = 1.0
    for _ in range(3):
        started = time.perf_counter()
        shares.linger(base, times)
        least = min(least, time.perf_counter() - started)
    return times / max(least, 1e-9)
