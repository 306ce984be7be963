"""Checks of numbers."""

from __future__ import annotations

import math

import numpy as np
import pytest

from amorsim.kernels.numbers import all_finite, has_nan


@pytest.mark.parametrize("place", range(4))
def test_what_is_no_number_is_found_wherever_it_is(place: int) -> None:
    values = np.array([1.0, -1e308, -0.0, 1e308])
    assert all_finite(values)
    assert not has_nan(values)
    for bad in (math.inf, -math.inf, math.nan):
        values[place] = bad
        assert not all_finite(values)
        assert has_nan(values) == math.isnan(bad)


def test_of_no_numbers_all_are_finite() -> None:
    assert all_finite(np.zeros(0))
    assert not has_nan(np.zeros(0))
