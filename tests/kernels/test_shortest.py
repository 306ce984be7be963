"""The shortest decimals are to the byte those of Python's ``repr``."""

from __future__ import annotations

import math
import struct
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from amorsim.kernels.text.shortest import powers_of_ten
from amorsim.recorders.line_printer import EXACT, Columns, Printer, Span
from tests.examples import settings


def shortest(values: list[float]) -> list[str]:
    table = np.array(values, dtype=np.float64).reshape(-1, 1)
    made = Printer().print(table, 1, np.arange(len(values)), Columns([Span(EXACT)]))
    return "".join(bytes(lines.data).decode() for lines in made).splitlines()


def bits(pattern: int) -> float:
    return float(struct.unpack("<d", struct.pack("<Q", pattern))[0])


@settings(max_examples=1500, deadline=None)
@given(
    st.one_of(
        st.floats(-20.0, 20.0),
        st.integers(0, 2**64 - 1).map(bits),
        st.integers(0, 2**53).map(bits),  # of few bits, and the smallest others
        st.integers(-(2**60), 2**60).map(float),
        st.builds(
            lambda digits, power: float(f"{digits}e{power}"), st.integers(-(10**6), 10**6), st.integers(-330, 303)
        ),
    )
)
@example(0.0)
@example(-0.0)
@example(math.inf)
@example(-math.inf)
@example(math.nan)
@example(5e-324)
@example(0.0001)
@example(0.00001)
@example(1e15)
@example(1e16)
@example(1e22)
@example(1e23)
@example(9999999999999998.0)
@example(1.7976931348623157e308)
def test_a_number_is_written_as_python_writes_it(value: float) -> None:
    assert shortest([value]) == [repr(value)]


def test_powers_of_two_and_their_neighbours() -> None:
    powers = 2.0 ** np.arange(-1074, 1024)  # below each the doubles are twice as dense
    values = np.concatenate([powers, np.nextafter(powers, 0.0), np.nextafter(powers, np.inf)]).tolist()
    assert shortest(values) == [repr(value) for value in values]


@pytest.mark.long
def test_millions_of_numbers() -> None:
    rng = np.random.default_rng(0)
    for values in (rng.normal(size=500_000), rng.integers(0, 2**64, 1_500_000, dtype=np.uint64).view(np.float64)):
        assert shortest(values.tolist()) == [repr(value) for value in values.tolist()]


def test_powers_of_ten_are_rounded_up() -> None:
    for exponent, (upper, lower) in zip(range(-292, 325), powers_of_ten().tolist(), strict=True):
        whole = (upper << 64) | lower
        assert whole.bit_length() == 128
        power = Fraction(10) ** exponent
        size = math.floor(math.log2(10) * exponent)  # no power but 1 is near one of two
        exact = power * Fraction(2) ** (127 - size)
        assert whole - 1 < exact <= whole
