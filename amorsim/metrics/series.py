"""One number of a series over time; the same bits for any number of rows."""

from __future__ import annotations

import numpy as np

from amorsim.array_types import Array

__all__ = ["AT", "at", "total"]


AT = ("end", "mean", "rms", "max", "median")
"""The ways in which a metric may sum up a series over time."""


def total(values: Array) -> Array:
    """The sum over the first axis, in order; zero for no values."""
    if not len(values):
        return np.zeros(values.shape[1:])
    return np.asarray(np.add.accumulate(values, axis=0)[-1])


def at(values: Array, what: str) -> Array:
    """The ``end``, ``mean``, ``rms``, ``max`` or ``median`` of values `(S, R)` over time, `(R,)`."""
    if what == "end":
        return np.array(values[-1])
    if what == "mean":
        return total(values) / len(values)
    if what == "rms":
        return np.sqrt(total(values * values) / len(values))
    return np.asarray(np.max(values, axis=0) if what == "max" else np.median(values, axis=0))
