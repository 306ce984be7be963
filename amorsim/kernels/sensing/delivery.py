"""When a sensor samples, and when its samples reach the robot: rates and latencies, row by row."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from amorsim.array_types import Array
from amorsim.kernels.compile import kernel

__all__ = ["TOLERANCE", "Reading", "UnderWay", "deliver", "due_rows", "take_due"]

Ticks = NDArray[np.int64]
Flags = NDArray[np.bool_]
# A component's parameter over rows, (N, 1) float64; declared as the number that it is for one row.
Column = Any

TOLERANCE = 1e-9
"""Of a sample: 0.1 s at 10 Hz is one sample, though 0.1 * 10 need not be 1."""


class Reading(NamedTuple):
    """A robot's current reading of a sensor with k values."""

    true: Array
    """(N, k)"""
    measured: Array
    """(N, k)"""
    stamp: Ticks
    """(N, 1): the tick of the sample; -1 before the first."""
    age: Array
    """(N, 1) [s], since that tick."""
    fresh: Flags
    """(N, 1): whether it arrived at this tick."""


class UnderWay(NamedTuple):
    """Samples in transit, in s slots."""

    true: Array
    """(N, s, k)"""
    measured: Array
    """(N, s, k)"""
    stamp: Ticks
    """(N, s): the tick of each sample; -1 in an empty slot."""
    arrival: Ticks
    """(N, s): the tick at which each arrives; (N, 0) where every sample takes the same time."""
    latest: Ticks
    """(N, 1): the latest arrival so far."""


@kernel
def due_rows(tick: Ticks, rate: Column, dt: float, out: Flags) -> int:
    """Write which rows sample at their `tick` (N, 1), into `out` (N, 1), and return how many.

    Those are the first ticks at or after the due times 0, 1/rate, 2/rate ... A `rate` (N, 1) [Hz] of 1/dt or more means
    every tick.
    """
    count = 0
    for i in range(tick.shape[0]):
        samples = rate[i, 0] * dt
        now = np.floor(tick[i, 0] * samples + TOLERANCE)
        before = np.floor((tick[i, 0] - 1) * samples + TOLERANCE)
        out[i, 0] = now > before or samples >= 1.0 or tick[i, 0] == 0
        count += out[i, 0]
    return count


@kernel
def take_due(due: Flags, tick: Ticks, dt: float, true: Array, measured: Array, held: Reading, out: Reading) -> None:
    """Update the robots' readings after this tick's samples of the rows `due` (N, 1), for sensors without delay."""
    for i in range(tick.shape[0]):
        source_true = true if due[i, 0] else held.true
        source_measured = measured if due[i, 0] else held.measured
        for k in range(true.shape[1]):
            out.true[i, k] = source_true[i, k]
            out.measured[i, k] = source_measured[i, k]
        out.stamp[i, 0] = tick[i, 0] if due[i, 0] else held.stamp[i, 0]
        out.age[i, 0] = (tick[i, 0] - out.stamp[i, 0]) * dt
        out.fresh[i, 0] = due[i, 0]


@kernel
def deliver(
    due: Flags,
    tick: Ticks,
    dt: float,
    true: Array,
    measured: Array,
    delay: Ticks,
    late: Column,
    under_way: UnderWay,
    held: Reading,
    out: Reading,
) -> None:
    """Put this tick's samples in transit, and write what robots hold after those that arrive now.

    The first sample of an episode is held from the start, though it arrives later. No sample overtakes an earlier one;
    of several that arrive at once the latest counts.

    Parameters
    ----------
    due
        The rows that sample now, (N, 1).
    tick, dt
        Of each row, (N, 1), and the step [s].
    true, measured
        This tick's samples, (N, k); of rows that are not due they count for nothing.
    delay
        How long each sample takes [ticks], (N, 1), where all take the same time.
    late
        How long this one takes [s], (N, 1), where that differs.
    under_way
        Changed in place.
    """
    slots = under_way.stamp.shape[1]
    varies = under_way.arrival.shape[1] > 0
    for i in range(tick.shape[0]):
        now = tick[i, 0]
        slot = now % slots
        under_way.stamp[i, slot] = now if due[i, 0] else -1
        if due[i, 0]:
            under_way.true[i, slot] = true[i]
            under_way.measured[i, slot] = measured[i]
        sent = now - delay[i, 0]
        if varies:
            if due[i, 0]:
                takes = math.ceil(max(late[i, 0], 0.0) / dt - TOLERANCE)
                arrival = max(now + int(takes), under_way.latest[i, 0])
                under_way.latest[i, 0] = arrival
                under_way.arrival[i, slot] = arrival
            sent = -1
            for s in range(slots):
                if under_way.stamp[i, s] >= 0 and under_way.arrival[i, s] <= now:
                    sent = max(sent, under_way.stamp[i, s])
                    under_way.stamp[i, s] = -1
            arrived = sent >= 0
        else:
            arrived = sent >= 0 and under_way.stamp[i, sent % slots] == sent
        out.fresh[i, 0] = arrived
        if now == 0:
            out.true[i] = true[i]
            out.measured[i] = measured[i]
            out.stamp[i, 0] = 0
        elif arrived:
            out.true[i] = under_way.true[i, sent % slots]
            out.measured[i] = under_way.measured[i, sent % slots]
            out.stamp[i, 0] = sent
        else:
            out.true[i] = held.true[i]
            out.measured[i] = held.measured[i]
            out.stamp[i, 0] = held.stamp[i, 0]
        out.age[i, 0] = (now - out.stamp[i, 0]) * dt
