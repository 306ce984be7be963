"""What tasks for learners observe: the kernels against NumPy, whatever a sensor measures and wherever a goal is."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from amorsim.kernels.sensing.readings import range_and_bearing, shares_of_range

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


NUMBERS = st.floats(-1e6, 1e6)


@given(
    poses=arrays(np.float64, (4, 3), elements=NUMBERS),
    places=arrays(np.float64, (4, 2), elements=NUMBERS),
    farthest=st.floats(1e-3, 1e7),
)
def test_range_and_bearing_are_those_of_numpy(poses: np.ndarray, places: np.ndarray, farthest: float) -> None:
    out = np.full((4, 5), 7.0)
    range_and_bearing(poses, places, farthest, out)
    east, north = (places - poses[:, :2]).T
    bearing = np.arctan2(north, east) - poses[:, 2]
    np.testing.assert_allclose(out[:, 0], np.minimum(np.hypot(east, north), farthest), rtol=1e-15)
    # An angle of a million radians has an error of 1e-10 of its own.
    np.testing.assert_allclose(out[:, 1:3], np.column_stack((np.cos(bearing), np.sin(bearing))), atol=1e-9)
    assert (out[:, 3:] == 7.0).all()
