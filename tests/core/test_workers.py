"""Rows shared among threads: all of them, each once, errors included."""

from __future__ import annotations

import threading

import pytest

from amorsim.core.workers import LEAST_WORK, Workers


@pytest.mark.parametrize("threads", [1, 2, 3, 8])
@pytest.mark.parametrize("rows", [0, 1, 2, 7, 1000])
def test_every_row_is_worked_on_once(threads: int, rows: int) -> None:
    done = [0] * rows

    def work(first: int, end: int) -> None:
        for row in range(first, end):
            done[row] += 1

    Workers(threads).share(rows, LEAST_WORK, work)
    assert done == [1] * rows


def test_large_work_is_parted_and_small_work_is_not() -> None:
    names: set[str] = set()
    barrier = threading.Barrier(2, timeout=10)

    def together(first: int, end: int) -> None:
        names.add(threading.current_thread().name)
        barrier.wait()  # passes only if two are at work at once

    workers = Workers(2)
    workers.share(2, LEAST_WORK, together)
    assert len(names) == 2
    calls: list[tuple[int, int]] = []
    workers.share(10, 1, lambda first, end: calls.append((first, end)))
    assert calls == [(0, 10)]


def test_an_error_in_any_slice_is_raised() -> None:
    def work(first: int, end: int) -> None:
        if end == 4:
            raise ValueError("the last slice")

    with pytest.raises(ValueError, match="the last slice"):
        Workers(2).share(4, LEAST_WORK, work)
