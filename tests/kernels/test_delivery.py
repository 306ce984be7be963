"""Rates and latencies, against a queue of samples for each row."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from amorsim.kernels.sensing.delivery import TOLERANCE, Reading, UnderWay, deliver, due_rows, take_due
from tests.examples import settings

DT = 0.1
VALUES = 3


def nothing(rows: int) -> Reading:
    """What is held before the first sample."""
    return Reading(
        np.full((rows, VALUES), np.nan),
        np.full((rows, VALUES), np.nan),
        np.full((rows, 1), -1),
        np.zeros((rows, 1)),
        np.zeros((rows, 1), dtype=bool),
    )


def empty(rows: int) -> Reading:
    """Room for a reading."""
    shapes = ((rows, VALUES), (rows, VALUES), (rows, 1), (rows, 1), (rows, 1))
    kinds = (np.float64, np.float64, np.int64, np.float64, np.bool_)
    return Reading(*(np.empty(shape, dtype=kind) for shape, kind in zip(shapes, kinds, strict=True)))


def sample(tick: int, rows: int) -> tuple[np.ndarray, np.ndarray]:
    """A sample that tells row and tick."""
    true = tick + 0.01 * np.arange(rows)[:, None] + 0.1 * np.arange(VALUES)
    return true, -true


def column(numbers: list[float]) -> np.ndarray:
    return np.array(numbers, dtype=np.float64)[:, None]


@given(st.lists(st.sampled_from([0.3, 1.0, 3.0, 4.0, 7.0, 10.0, 25.0, math.inf]), min_size=1, max_size=5))
@settings(deadline=None)
def test_a_row_samples_first_at_or_after_each_due_time(rates: list[float]) -> None:
    rows = len(rates)
    due = np.zeros((rows, 1), dtype=bool)
    times: list[list[int]] = [[] for _ in rates]
    for tick in range(100):
        assert due_rows(np.full((rows, 1), tick), column(rates), DT, due) == due.sum()
        for i in np.flatnonzero(due).tolist():
            times[i].append(tick)
    for rate, found in zip(rates, times, strict=True):
        if rate * DT >= 1.0 - TOLERANCE:
            assert found == list(range(100))
        else:
            expected = [math.ceil(n / rate / DT - 1e-6) for n in range(math.ceil(100 * DT * rate) + 1)]
            assert found == [tick for tick in expected if tick < 100]


@given(st.data(), st.integers(1, 4))
@settings(deadline=None)
def test_what_is_not_due_stays(data: st.DataObject, rows: int) -> None:
    held, seen = nothing(rows), [-1] * rows
    for tick in range(12):
        due = np.array(data.draw(st.lists(st.booleans(), min_size=rows, max_size=rows)))[:, None]
        due |= tick == 0
        out = empty(rows)
        take_due(due, np.full((rows, 1), tick), DT, *sample(tick, rows), held, out)
        for i in range(rows):
            seen[i] = tick if due[i] else seen[i]
            np.testing.assert_array_equal(out.true[i], sample(seen[i], rows)[0][i])
            np.testing.assert_array_equal(out.measured[i], sample(seen[i], rows)[1][i])
            assert (out.stamp[i], out.age[i], out.fresh[i]) == (seen[i], (tick - seen[i]) * DT, due[i])
        held = out


@given(st.data(), st.lists(st.integers(0, 4), min_size=1, max_size=4), st.booleans())
@settings(deadline=None)
def test_samples_arrive_when_their_latency_is_over(data: st.DataObject, delays: list[int], varies: bool) -> None:
    rows, slots = len(delays), 8
    under_way = UnderWay(
        np.zeros((rows, slots, VALUES)),
        np.zeros((rows, slots, VALUES)),
        np.full((rows, slots), -1),
        np.zeros((rows, slots if varies else 0), dtype=np.int64),
        np.zeros((rows, 1), dtype=np.int64),
    )
    held = nothing(rows)
    queues: list[list[tuple[int, int]]] = [[] for _ in delays]  # of (sampled, arrives)
    for tick in range(20):
        due = np.array(data.draw(st.lists(st.booleans(), min_size=rows, max_size=rows)))[:, None]
        due |= tick == 0
        extra = data.draw(st.lists(st.integers(-1, 2), min_size=rows, max_size=rows)) if varies else [0] * rows
        takes = [max(0, delay + more) for delay, more in zip(delays, extra, strict=True)]
        out = empty(rows)
        late = column([(delay + more) * DT for delay, more in zip(delays, extra, strict=True)])
        ticks = np.full((rows, 1), tick)
        deliver(due, ticks, DT, *sample(tick, rows), np.array(delays)[:, None], late, under_way, held, out)
        for i in range(rows):
            if due[i]:
                last = queues[i][-1][1] if queues[i] else 0
                queues[i].append((tick, max(tick + takes[i], last)))
            here = [sampled for sampled, arrives in queues[i] if arrives == tick]
            assert bool(out.fresh[i]) == bool(here)
            there = [sampled for sampled, arrives in queues[i] if arrives <= tick]
            stamp = max(there, default=0)
            assert out.stamp[i] == stamp
            assert out.age[i] == pytest.approx((tick - stamp) * DT)
            np.testing.assert_array_equal(out.true[i], sample(stamp, rows)[0][i])
            np.testing.assert_array_equal(out.measured[i], sample(stamp, rows)[1][i])
        held = out
