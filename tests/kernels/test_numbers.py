"""Checks of numbers."""

from __future__ import annotations

import math

import numpy as np
import pytest

from amorsim.kernels.number_checks import all_finite, all_indices, has_nan


@pytest.mark.parametrize("place", range(4))
def test_what_is_no_number_is_found_wherever_it_is(place: int) -> None:
    values = np.array([1.0, -1e308, -0.0, 1e308])
    assert all_finite(values)
    assert not has_nan(values)
    for bad in (math.inf, -math.inf, math.nan):
        values[place] = bad
        assert not all_finite(values)
        assert has_nan(values) == math.isnan(bad)


def test_indices_begin_at_0_and_end_before_the_count() -> None:
    assert all_indices(np.array([0, 4, 2, 4]), 5)
    assert not all_indices(np.array([0, 5, 2]), 5)
    assert not all_indices(np.array([0, 2, -1]), 5)


def test_of_no_numbers_all_are_right() -> None:
    assert all_finite(np.zeros(0))
    assert all_indices(np.zeros(0, dtype=np.int64), 0)
    assert not has_nan(np.zeros(0))
