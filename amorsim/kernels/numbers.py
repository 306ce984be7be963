"""Checks of numbers: what must not pass on."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from amorsim.kernels.compile import kernel

__all__ = ["all_finite", "has_nan"]

Floats = NDArray[np.float64]


@kernel
def all_finite(values: Floats) -> bool:
    """Whether no number of these (V,) is nan or inf."""
    finite = True
    for value in values:
        finite &= math.isfinite(value)
    return finite


@kernel
def has_nan(values: Floats) -> bool:
    """Whether any number of these (V,) is nan."""
    found = False
    for value in values:
        found |= math.isnan(value)
    return found
