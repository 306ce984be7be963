"""Sorting by keys, and equal ones by number."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from amorsim.kernels.sorting import sort


@given(st.lists(st.sampled_from([0.0, 0.5, 1.0, np.inf])), st.randoms(use_true_random=False))
def test_equal_keys_are_in_order_of_their_numbers(keys, random):
    numbers = list(range(len(keys)))
    random.shuffle(numbers)
    expected = sorted(zip(keys, numbers, strict=True))
    sorted_keys, sorted_numbers = np.array(keys, dtype=np.float64), np.array(numbers, dtype=np.int64)
    sort(sorted_keys, sorted_numbers)
    assert list(zip(sorted_keys.tolist(), sorted_numbers.tolist(), strict=True)) == expected
