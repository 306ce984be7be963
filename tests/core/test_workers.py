"""Rows shared among threads: each once, errors included."""

from __future__ import annotations

import copy
import multiprocessing
import pickle
import subprocess
import sys
import threading

import pytest

from amorsim.core.execution.workers import LEAST_WORK, Workers


def workers(threads: int) -> Workers:
    """Threads that are there, however many processors are."""
    return Workers(threads, processors=threads)


@pytest.mark.parametrize("threads", [1, 2, 3, 8])
@pytest.mark.parametrize("rows", [0, 1, 2, 7, 1000])
def test_every_row_is_in_one_slice(threads: int, rows: int) -> None:
    done = [0] * rows

    def work(first: int, end: int) -> None:
        for row in range(first, end):
            done[row] += 1

    crew = workers(threads)
    for n in range(1, 5):
        crew.share(rows, LEAST_WORK, work)
        assert done == [n] * rows


def test_large_work_is_cut_and_small_work_is_not() -> None:
    barrier = threading.Barrier(2, timeout=30)
    crew = workers(2)
    crew.share(2, LEAST_WORK, lambda first, end: barrier.wait())  # passes only if two are at work at once
    calls: list[tuple[int, int]] = []
    crew.share(10, 1, lambda *slice_: calls.append(slice_))
    assert calls == [(0, 10)]


def test_there_are_no_more_threads_than_processors() -> None:
    assert Workers(8, processors=2).threads == 2
    calls: list[tuple[int, int]] = []
    Workers(8, processors=1).share(1000, LEAST_WORK, lambda *slice_: calls.append(slice_))
    assert calls == [(0, 1000)]


@pytest.mark.parametrize("bad", [0, 1])
def test_an_error_in_any_slice_is_raised_once_all_have_ended(bad: int) -> None:
    ended: list[int] = []

    def work(first: int, end: int) -> None:
        if first // 500 == bad:
            raise ZeroDivisionError("here")
        ended.append(first)

    crew = workers(2)
    with pytest.raises(ZeroDivisionError, match="here"):
        crew.share(1000, LEAST_WORK, work)
    assert ended == [500 * (1 - bad)]
    crew.share(1000, LEAST_WORK, lambda first, end: ended.append(first))  # it goes on
    assert sorted(ended[1:]) == [0, 500]


def test_a_copy_has_threads_of_its_own() -> None:
    crew = workers(2)
    crew.share(2, LEAST_WORK, lambda first, end: None)
    for other in (copy.deepcopy(crew), pickle.loads(pickle.dumps(crew))):
        assert other._asked == 2
        calls: list[int] = []
        other.share(2, LEAST_WORK, lambda first, end, calls=calls: calls.append(first))
        assert sorted(calls) in ([0], [0, 1])


def _share_in_child(crew: Workers, answer: multiprocessing.Queue[list[int]]) -> None:
    done: list[int] = []
    crew.share(2, LEAST_WORK, lambda first, end: done.append(first))
    answer.put(sorted(done))


@pytest.mark.skipif("fork" not in multiprocessing.get_all_start_methods(), reason="processes cannot fork here")
@pytest.mark.filterwarnings("ignore:.*use of fork:DeprecationWarning")
def test_threads_do_not_come_along_into_a_fork() -> None:
    crew = workers(2)
    crew.share(2, LEAST_WORK, lambda first, end: None)
    context = multiprocessing.get_context("fork")
    answer = context.Queue()
    child = context.Process(target=_share_in_child, args=(crew, answer))
    child.start()
    assert answer.get(timeout=30) == [0, 1]
    child.join(30)


def test_a_process_with_threads_ends_by_itself() -> None:
    program = (
        "from amorsim.core.execution.workers import Workers\n"
        "crew = Workers(2, processors=2)\n"
        "crew.share(1000, 1000, lambda first, end: None)\n"
    )
    ended = subprocess.run([sys.executable, "-c", program], timeout=60, capture_output=True, text=True)
    assert (ended.returncode, ended.stderr) == (0, "")
