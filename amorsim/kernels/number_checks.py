"""Checks of numbers before they are passed on."""

from __future__ import annotations

import math

from amorsim.array_types import Array, Bools, Ints
from amorsim.kernels.compile import kernel

__all__ = ["all_finite", "all_indices", "first_late", "has_nan"]


@kernel
def all_finite(values: Array) -> bool:
    """Whether no number of these (V,) is nan or inf."""
    finite = True
    for value in values:
        finite &= math.isfinite(value)
    return finite


@kernel
def all_indices(values: Ints, count: int) -> bool:
    """Whether each of these (V,) is the index of one of `count` things, from 0 on."""
    right = True
    for value in values:
        right &= 0 <= value < count
    return right


@kernel
def has_nan(values: Array) -> bool:
    """Whether any number of these (V,) is nan."""
    found = False
    for value in values:
        found |= math.isnan(value)
    return found


@kernel
def first_late(fresh: Bools, age: Array, most: Array) -> int:
    """The first row whose reading is new (N, 1) and older than its limit (N, 1); -1 if there is none."""
    for i in range(fresh.shape[0]):
        if fresh[i, 0] and age[i, 0] > most[i, 0]:
            return i
    return -1
