"""Checks of numbers before they are passed on."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from amorsim.kernels.compile import kernel

__all__ = ["all_finite", "all_indices", "has_nan"]

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


@kernel
def all_finite(values: Floats) -> bool:
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
def has_nan(values: Floats) -> bool:
    """Whether any number of these (V,) is nan."""
    found = False
    for value in values:
        found |= math.isnan(value)
    return found
