"""Lines made by the kernel are to the byte those of Python's formatting."""

from __future__ import annotations

import math
import struct

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from amorsim.kernels.decimals import write_lines
from amorsim.recorders.lines import EXACT, NAME, NOTHING, Names, as_lines

NOBODY = Names([])


def by_kernel(values: list[float], decimals: int) -> list[str] | None:
    """The numbers one a line, by the kernel alone; None where it gives up."""
    out = np.full(40 * len(values) + 1, 255, dtype=np.uint8)
    ends = np.empty(len(values), dtype=np.int64)
    nothing = np.zeros(1, dtype=np.uint8)
    column = np.array(values, dtype=np.float64)[:, None]
    if not write_lines(column, np.array([decimals]), NOBODY.bytes, NOBODY.ends, nothing, ends, out):
        return None
    assert (out[ends[-1] :] == 255).all()
    return out[: ends[-1]].tobytes().decode().splitlines()


def bits(pattern: int) -> float:
    return float(struct.unpack("<d", struct.pack("<Q", pattern))[0])


SPECIAL = [0.0, -0.0, math.inf, -math.inf, math.nan, -math.nan, 5e-324, -5e-324, 5e-7, 1.5e-6, -2.5e-6, 0.9999995]


@settings(max_examples=1500, deadline=None)
@given(
    st.one_of(
        st.floats(-20.0, 20.0),
        st.floats(-9.0e9, 9.0e9),
        st.integers(0, 2**64 - 1).map(bits),
        st.sampled_from(SPECIAL),
        # Halves of the last decimal, as near as a double gets, and its neighbours.
        st.builds(
            lambda n, to: math.nextafter((2 * n + 1) / 2e6, to),
            st.integers(-(10**13), 10**13),
            st.sampled_from([-math.inf, 0.0, math.inf]),
        ),
        # Halves that a double is exactly, of up to six decimals and so of seven binary places.
        st.integers(-(2**40), 2**40).map(lambda n: n / 128.0),
    ),
    st.integers(0, 13),
)
@example(value=0.0000005, decimals=6)
@example(value=2.5, decimals=0)
@example(value=0.5, decimals=0)
@example(value=9007199254.740991, decimals=6)
def test_a_number_is_written_as_python_writes_it(value: float, decimals: int) -> None:
    made = by_kernel([value], decimals)
    if made is None:
        assert abs(value) * 10.0**decimals >= 2.0**53
    else:
        assert made == [f"{value:.{decimals}f}"]


def test_exact_halves_go_to_the_even_one() -> None:
    values = [n / 128.0 for n in range(-4096, 4096)]  # 1/128 = 0.0078125
    assert by_kernel(values, 6) == [f"{value:.6f}" for value in values]
    assert by_kernel([0.0078125, 0.0234375], 6) == ["0.007812", "0.023438"]


@pytest.mark.long
def test_millions_of_numbers() -> None:
    rng = np.random.default_rng(0)
    for scale in (1e-6, 1e-3, 1.0, 10.0, 1e4, 8e9):
        values = (rng.normal(size=300_000) * scale).tolist()
        values = [value for value in values if abs(value) < 9.0e9]
        assert by_kernel(values, 6) == [f"{value:.6f}" for value in values]
        halves = [(2 * n + 1) / 2e6 for n in rng.integers(0, int(scale * 1e6) + 10, 100_000).tolist()]
        halves = [value for value in halves if abs(value) < 9.0e9]
        assert by_kernel(halves, 6) == [f"{value:.6f}" for value in halves]


def lines_by_python(values: np.ndarray, kinds: list[int], names: list[str]) -> str:
    lines = []
    for row in values.tolist():
        cells = []
        for value, kind in zip(row, kinds, strict=True):
            if kind == NAME:
                cells.append(names[int(value)])
            elif kind == NOTHING:
                cells.append("")
            else:
                cells.append(repr(value) if kind == EXACT else f"{value:.{kind}f}")
        lines.append(",".join(cells) + "\n")
    return "".join(lines)


KINDS = [0, 6, NAME, 6, EXACT, NOTHING, EXACT, 9, NOTHING]


@settings(max_examples=200, deadline=None)
@given(st.integers(0, 5), st.integers(0, 2**32), st.sampled_from([1.0, 1e5, 1e12, 1e300]))
def test_lines_of_all_kinds_of_cells(rows: int, seed: int, scale: float) -> None:
    rng = np.random.default_rng(seed)
    names = ["rover", "", "räuber", "x"]
    values = rng.normal(size=(rows, len(KINDS))) * scale
    values[:, 0] = rng.integers(0, 1000, rows)
    values[:, 2] = rng.integers(0, len(names), rows)
    values[rng.random(values.shape) < 0.1] = rng.choice([np.nan, np.inf, -np.inf, -0.0])
    values[:, 2] = np.where(np.isfinite(values[:, 2]), values[:, 2], 0.0)
    made = as_lines(values, KINDS, Names(names))
    assert made.data.decode() == lines_by_python(values, KINDS, names)
    assert [0, *made.ends.tolist()] == [i + 1 if i >= 0 else 0 for i in line_ends(made.data)]


def line_ends(data: bytes) -> list[int]:
    return [-1] + [i for i, c in enumerate(data) if c == ord("\n")]


def test_more_lines_than_are_made_at_once() -> None:
    values = np.random.default_rng(1).random((3000, 100)) * 9.0
    made = as_lines(values, [6] * 100, NOBODY)
    assert made.data.decode() == lines_by_python(values, [6] * 100, [])
    assert made.ends.tolist() == [i + 1 for i in line_ends(made.data)[1:]]


def test_more_decimals_than_the_kernel_makes() -> None:
    values = np.array([[0.1, 1e-8], [0.2, 3.0]])
    assert as_lines(values, [15, 6], NOBODY).data == b"0.100000000000000,0.000000\n0.200000000000000,3.000000\n"
