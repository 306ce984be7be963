"""Rows shared among threads: all of them, each once, errors included, and whatever else threads may meet."""

from __future__ import annotations

import copy
import gc
import multiprocessing
import os
import pickle
import subprocess
import sys
import threading
import time

import numpy as np
import pytest

from amorsim.core.workers import ALONE, LEAST_WORK, Workers
from amorsim.kernels.compile import kernel
from amorsim.kernels.shares import offer, spread, take_rows


@kernel
def _count(share: int, out: np.ndarray) -> None:
    spread(share, out.shape[0], offer(_add, (out,)))


@kernel
def _add(share: int, out: np.ndarray) -> None:
    """Add 1 to each row, the slower the later it is."""
    first, end = take_rows(share, out.shape[0], 0)
    while first < end:
        for i in range(first, end):
            x = 1.0
            for _ in range(i % 1000):
                x = 0.5 * x + 0.5
            out[i] += x
        first, end = take_rows(share, out.shape[0], end)


def workers(threads: int) -> Workers:
    """Threads that are there, however many processors are."""
    return Workers(threads, processors=threads)


def until(what: object) -> None:
    """Wait for what will be so some time."""
    for _ in range(3000):
        if what():
            return
        time.sleep(0.01)
    raise AssertionError("it did not come to pass in 30 s")


@pytest.mark.parametrize("threads", [1, 2, 3, 8])
@pytest.mark.parametrize("rows", [0, 1, 2, 7, 1000])
def test_every_row_is_worked_on_once(threads: int, rows: int) -> None:
    crew, out = workers(threads), np.zeros(rows)
    for n in range(1, 30):
        crew.share(rows, LEAST_WORK, lambda share: _count(share, out))
        assert (out == n).all()


@pytest.mark.parametrize("threads", [1, 2, 5])
@pytest.mark.parametrize("rows", [0, 1, 2, 7, 1000])
def test_every_row_is_in_one_slice(threads: int, rows: int) -> None:
    done = [0] * rows

    def work(first: int, end: int) -> None:
        for row in range(first, end):
            done[row] += 1

    workers(threads).share_slices(rows, LEAST_WORK, work)
    assert done == [1] * rows


@pytest.mark.parametrize("rows", [(1 << 21) - 1, (1 << 21) + 5, 3 << 22])
def test_there_may_be_more_rows_than_a_ticket_counts(rows: int) -> None:
    out = np.zeros(rows, dtype=np.uint8)

    def work(first: int, end: int) -> None:
        out[first:end] += 1

    workers(2).share_slices(rows, 1, work)
    assert (out == 1).all()


def test_large_work_is_parted_and_small_work_is_not() -> None:
    names: set[str] = set()
    barrier = threading.Barrier(2, timeout=30)

    def together(first: int, end: int) -> None:
        if len(names) < 2:
            names.add(threading.current_thread().name)
            barrier.wait()  # passes only if two are at work at once

    crew = workers(2)
    crew.share_slices(2, LEAST_WORK, together)
    assert len(names) == 2
    calls: list[int] = []
    crew.share(10, 1, calls.append)
    assert calls == [ALONE]


def test_there_are_no_more_threads_than_processors() -> None:
    assert Workers(8, processors=2).threads == 2
    calls: list[int] = []
    Workers(8, processors=1).share(1000, LEAST_WORK, calls.append)
    assert calls == [ALONE]


@pytest.mark.parametrize("bad", ["the caller", "another"])
def test_an_error_in_any_thread_is_raised_and_the_next_work_is_done(bad: str) -> None:
    crew, both, met = workers(2), threading.Barrier(2, timeout=30), set[str]()

    def work(first: int, end: int) -> None:
        is_other = threading.current_thread() is not threading.main_thread()
        name = threading.current_thread().name
        if name not in met:
            met.add(name)
            both.wait()  # else one might take all rows before the other has begun
        if is_other == (bad == "another"):
            raise ValueError(bad)

    with pytest.raises(ValueError, match=bad):
        crew.share_slices(4, LEAST_WORK, work)
    out = np.zeros(100)
    crew.share(100, LEAST_WORK, lambda share: _count(share, out))
    assert (out == 1).all()


@kernel
def _nothing(share: int, out: np.ndarray) -> None:
    pass


@kernel
def _spread_nothing(share: int, out: np.ndarray) -> None:
    spread(share, out.shape[0], offer(_nothing, (out,)))


def test_work_that_takes_no_rows_is_an_error() -> None:
    crew, out = workers(2), np.zeros(100)
    with pytest.raises(RuntimeError, match="until none are left"):
        crew.share(100, LEAST_WORK, lambda share: _spread_nothing(share, out))
    crew.share(100, LEAST_WORK, lambda share: _count(share, out))
    assert (out == 1).all()


def test_work_within_work_is_done_by_who_asks() -> None:
    crew, out = workers(2), np.zeros((8, 50))

    def outer(first: int, end: int) -> None:
        for row in range(first, end):
            crew.share(50, LEAST_WORK, lambda share, mine=out[row]: _count(share, mine))

    crew.share_slices(8, LEAST_WORK, outer)
    assert (out == 1).all()


def test_an_interrupt_is_raised_when_the_others_have_done_their_rows(monkeypatch: pytest.MonkeyPatch) -> None:
    crew, began, interrupted, done = workers(2), threading.Event(), threading.Event(), []
    sleep = time.sleep

    def work(first: int, end: int) -> None:
        if threading.current_thread() is threading.main_thread():
            assert began.wait(30)
        else:
            began.set()
            assert interrupted.wait(30)
        done.extend(range(first, end))

    def pause(seconds: float) -> None:
        if not interrupted.is_set():
            interrupted.set()
            raise KeyboardInterrupt
        sleep(seconds)

    monkeypatch.setattr("amorsim.core.workers.time.sleep", pause)
    with pytest.raises(KeyboardInterrupt):
        crew.share_slices(8, LEAST_WORK, work)
    assert sorted(done) == list(range(8))


def test_many_crews_work_at_once() -> None:
    sums: dict[int, float] = {}

    def run(number: int) -> None:
        crew, out = workers(2), np.zeros(300)
        for _ in range(50):
            crew.share(300, LEAST_WORK, lambda share: _count(share, out))
        sums[number] = float(out.sum())

    callers = [threading.Thread(target=run, args=(number,)) for number in range(4)]
    for caller in callers:
        caller.start()
    for caller in callers:
        caller.join(60)
    assert sums == dict.fromkeys(range(4), 300 * 50.0)


def test_threads_end_with_who_made_them() -> None:
    crew, out = workers(3), np.zeros(100)
    crew.share(100, LEAST_WORK, lambda share: _count(share, out))
    mine = list(crew._crew._others)
    assert all(thread.is_alive() for thread in mine)
    del crew
    gc.collect()
    until(lambda: not any(thread.is_alive() for thread in mine))


@pytest.mark.parametrize("copied", [copy.deepcopy, lambda it: pickle.loads(pickle.dumps(it))])
def test_a_copy_has_threads_of_its_own(copied: object) -> None:
    crew, out = workers(2), np.zeros(100)
    crew.share(100, LEAST_WORK, lambda share: _count(share, out))
    other = copied(crew)
    assert other._crew is None
    other.share(100, LEAST_WORK, lambda share: _count(share, out))
    assert (out == 2).all()


@pytest.mark.skipif(not hasattr(os, "fork"), reason="there is no fork here")
@pytest.mark.filterwarnings("ignore:.*fork.*:DeprecationWarning")
def test_a_fork_has_threads_of_its_own() -> None:
    crew, out = workers(2), np.zeros(100)
    crew.share(100, LEAST_WORK, lambda share: _count(share, out))

    def run() -> None:
        crew.share(100, LEAST_WORK, lambda share: _count(share, out))
        raise SystemExit(0 if (out == 2).all() else 1)

    child = multiprocessing.get_context("fork").Process(target=run)
    child.start()
    child.join(60)
    assert child.exitcode == 0


def test_a_process_ends_though_threads_wait_for_work() -> None:
    code = (
        "import numpy as np\n"
        "from amorsim.core.workers import Workers\n"
        "crew = Workers(2, processors=2)\n"
        "crew.share_slices(100, 10**6, lambda first, end: None)\n"
        "print('done')\n"
    )
    told = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=120, check=False)
    assert (told.returncode, told.stdout, told.stderr) == (0, "done\n", "")
