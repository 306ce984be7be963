"""Tables as few bytes: what is read is what was written, to the digits that are kept."""

from __future__ import annotations

import gzip
import math

import numpy as np
import numpy.typing as npt
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

from amorsim.ui.run_page.packed_tables import SeriesWriter, read_series

NUMBERS = st.floats(-1e12, 1e12) | st.sampled_from([math.nan, math.inf, -math.inf, 0.0, -0.0])
TABLES = arrays.arrays(np.float64, st.tuples(st.integers(0, 12), st.integers(0, 4)), elements=NUMBERS)


@given(tables=st.lists(TABLES, max_size=3), digits=st.integers(1, 9), finest=st.integers(-9, 0))
def test_what_is_read_is_what_was_written(tables: list[npt.NDArray[np.float64]], digits: int, finest: int) -> None:
    writer = SeriesWriter()
    written = [writer.add(table, digits=digits, finest=finest) for table in tables]
    for table, series in zip(tables, written, strict=True):
        read = read_series(writer.data, series)
        assert read.shape == table.shape
        finite = np.isfinite(table)
        np.testing.assert_array_equal(read[~finite], table[~finite])
        largest = np.abs(np.where(finite, table, 0.0)).max(axis=0, initial=0.0)
        # Half of the last digit of the column's largest number, and what float64 itself rounds.
        leading = np.floor(np.log10(np.where(largest > 0, largest, 1.0)))
        bound = 0.5 * 10.0 ** np.maximum(leading - digits + 1, finest) + 1e-12 * largest
        apart = np.abs(np.where(finite, read, 0.0) - np.where(finite, table, 0.0))
        assert (apart <= bound).all()


def test_what_stands_still_takes_few_bytes() -> None:
    table = np.repeat(np.random.default_rng(1).normal(size=(1, 50)), 1000, axis=0)
    writer = SeriesWriter()
    writer.add(table)
    assert len(writer.data) == 4 * table.size
    assert len(gzip.compress(bytes(writer.data))) < 1500
