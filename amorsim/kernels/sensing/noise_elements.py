"""The effect of noise elements on values: on each value independently, in one pass.

Values are (N, k), of N rows. A component's parameters over rows are (N, 1). To add an error, +0.0 less the error is
taken away: that keeps even the sign of a zero.
"""

from __future__ import annotations

import math
from typing import Any

from amorsim.array_types import Array, Ints
from amorsim.kernels.compile import kernel

__all__ = ["deviate", "diffuse", "slip", "spread", "wander"]

# A component's parameter over rows, (N, 1) float64; declared as the number that it is for one row.
Column = Any


@kernel
def spread(values: Array, density: Column, elapsed: Array, noise: Array) -> None:
    """Turn standard normal `noise`, in place, into values with white noise of a `density`, over times `elapsed` (N, 1).

    The standard deviation is the density over the root of the time [s], and 0 over none.
    """
    for i in range(values.shape[0]):
        time = elapsed[i, 0]
        std = density[i, 0] / math.sqrt(time) if time > 0.0 else 0.0
        for j in range(values.shape[1]):
            noise[i, j] = values[i, j] - (0.0 - noise[i, j] * std)


@kernel
def wander(
    values: Array, before: Array, elapsed: Array, std: Column, correlation_time: Column, noise: Array, out: Array
) -> None:
    """Turn standard normal `noise`, in place, into a Gauss-Markov process, and write the values with it into `out`.

    Parameters
    ----------
    before
        The process at the sample before, in standard deviations, (N, k).
    elapsed
        Since then [s], (N, 1). Over no time the process begins: nothing is kept of what was before.
    std, correlation_time
        Of the process; after this time [s] its correlation has fallen to 1/e.
    """
    for i in range(values.shape[0]):
        remembered, fresh = 0.0, 1.0
        if elapsed[i, 0] > 0.0:
            times = elapsed[i, 0] / correlation_time[i, 0]
            remembered, fresh = math.exp(-times), math.sqrt(-math.expm1(-2.0 * times))
        for j in range(values.shape[1]):
            process = before[i, j] * remembered + noise[i, j] * fresh
            noise[i, j] = process
            out[i, j] = values[i, j] - (0.0 - process * std[i, 0])


@kernel
def diffuse(travels: Array, variance: Column, noise: Array) -> None:
    """Turn standard normal `noise`, in place, into travels with noise, of a `variance` for each metre of them."""
    for i in range(travels.shape[0]):
        for j in range(travels.shape[1]):
            std = math.sqrt(abs(travels[i, j]) * variance[i, 0])
            noise[i, j] = travels[i, j] - (0.0 - std * noise[i, j])


@kernel
def deviate(headings: Array, a: Column, b: Column, c: Column, d: Column, e: Column, out: Array) -> None:
    """Headings h with a + b sin h + c cos h + d sin 2h + e cos 2h added, into `out`; what is not finite stays."""
    for i in range(headings.shape[0]):
        for j in range(headings.shape[1]):
            heading = headings[i, j] if math.isfinite(headings[i, j]) else 0.0
            once = b[i, 0] * math.sin(heading) + c[i, 0] * math.cos(heading)
            twice = d[i, 0] * math.sin(2.0 * heading) + e[i, 0] * math.cos(2.0 * heading)
            out[i, j] = headings[i, j] - (0.0 - (a[i, 0] + once + twice))


@kernel
def slip(
    travels: Array,
    steps: Ints,
    elapsed: Array,
    at: Column,
    duration: Column,
    factor: Column,
    slips: Array,
    out: Array,
) -> None:
    """The part of travels that wheels go over the ground while they slip for a time, into `out`.

    Parameters
    ----------
    steps, elapsed
        How many steps were made before this one, and how long it is [s], (N, 1).
    at, duration, factor
        When slip begins and how long it lasts [s], and what part of the travel is left by it.
    slips
        (N, k): 1 for wheels that slip, 0 for others.
    """
    for i in range(travels.shape[0]):
        # By multiplication, never by adding up: a billion steps later the time is still right.
        begin = steps[i, 0] * elapsed[i, 0]
        covered = min(begin + elapsed[i, 0], at[i, 0] + duration[i, 0]) - max(begin, at[i, 0])
        share = covered / elapsed[i, 0] if elapsed[i, 0] > 0.0 else 0.0
        share = min(max(share, 0.0), 1.0)
        lacking = (1.0 - factor[i, 0]) * share
        for j in range(travels.shape[1]):
            out[i, j] = travels[i, j] * (1.0 - lacking * slips[i, j])
