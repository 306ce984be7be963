"""Ranges as shares of the longest: the kernel against NumPy, whatever a sensor measures."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from amorsim.kernels.sensing.readings import shares_of_range

RANGES = arrays(np.float64, st.tuples(st.integers(0, 4), st.integers(0, 5)), elements=st.floats(width=64))


@pytest.mark.parametrize("own", [False, True])
@given(ranges=RANGES, longest=st.floats(1e-3, 1e6))
def test_shares_are_those_of_numpy(own: bool, ranges: np.ndarray, longest: float) -> None:
    rows, beams = ranges.shape
    most = longest * (1.0 + np.arange(rows if own else 1))[:, None]
    out = np.full((rows, beams + 3), 7.0)
    shares_of_range(ranges, most, 2, out)
    with np.errstate(all="ignore"):
        np.testing.assert_array_equal(out[:, 2:-1], np.maximum(np.fmin(ranges / most, 1.0), 0.0))
    assert (out[:, :2] == 7.0).all()
    assert (out[:, -1] == 7.0).all()
