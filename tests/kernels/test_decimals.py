"""Lines made by the kernel are to the byte those of Python's formatting."""

from __future__ import annotations

import math
import struct

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from amorsim.kernels.text.decimals import write_lines
from amorsim.kernels.text.shortest import powers_of_ten
from amorsim.recorders.line_printer import EXACT, MISSING, NAME, NOTHING, Columns, Printer, Span
from tests.examples import settings


def by_kernel(values: list[float], decimals: int) -> list[str] | None:
    """The numbers, by the kernel alone: one a line, and all in one line; None where it gives up."""
    count = len(values)
    nobody = Columns([])
    found = []
    for lines, cells in ((count, 1), (1, count)):
        out = np.full(40 * count + 1, 255, dtype=np.uint8)
        ends = np.empty(lines, dtype=np.int64)
        table = np.array(values, dtype=np.float64).reshape(lines, cells)
        spans, words = np.array([Span(decimals, 0, 0, cells)]), np.empty(cells, dtype=np.uint64)
        which = np.arange(lines)
        if not write_lines(table, 1, which, spans, nobody.bytes, nobody.ends, powers_of_ten(), words, ends, out):
            return None
        assert (out[ends[-1] :] == 255).all()
        found.append(out[: ends[-1]].tobytes().decode().replace(",", "\n").splitlines())
    assert found[0] == found[1]
    return found[0]


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
    for scale in (1e-6, 1e-3, 1.0, 10.0, 100.0, 600.0, 1e4, 8e9):
        values = (rng.normal(size=300_000) * scale).tolist()
        values = [value for value in values if abs(value) < 9.0e9]
        assert by_kernel(values, 6) == [f"{value:.6f}" for value in values]
        halves = [(2 * n + 1) / 2e6 for n in rng.integers(0, int(scale * 1e6) + 10, 100_000).tolist()]
        halves = [value for value in halves if abs(value) < 9.0e9]
        assert by_kernel(halves, 6) == [f"{value:.6f}" for value in halves]


NAMES = ["rover", "", "räuber", "x"]
ROWS = 4
SPANS = [
    Span(0, 0, 1),
    Span(6, 4, 3, 3),
    Span(NAME, 0, 1),
    Span(6, 16, 1),
    Span(EXACT, 20, 2, 2),
    Span(NOTHING, cells=2),
    Span(EXACT, 28, 1),
    Span(9, 32, 1),
    Span(MISSING, cells=2),
    Span(6, 36, 9, 9),
    Span(NOTHING),
]
WIDTH = 72


def lines_by_python(table: np.ndarray, lines: list[int], spans: list[Span], rows: int) -> str:
    made = []
    for line in lines:
        step, row = divmod(line, rows)
        cells = []
        for kind, first, per_row, count in spans:
            for place in range(first + row * per_row, first + row * per_row + count):
                if kind == NAME:
                    cells.append(NAMES[place])
                elif kind in (NOTHING, MISSING):
                    cells.append("" if kind == NOTHING else "nan")
                else:
                    value = float(table[step, place])
                    cells.append(repr(value) if kind == EXACT else f"{value:.{kind}f}")
        made.append(",".join(cells) + "\n")
    return "".join(made)


def printed(table: np.ndarray, lines: list[int], spans: list[Span], rows: int) -> str:
    """By the printer; what it says of the lines' ends is looked at."""
    found = []
    for made in Printer().print(table, rows, np.array(lines, dtype=np.int64), Columns(spans, NAMES)):
        data = bytes(made.data)
        assert made.ends.tolist() == [i + 1 for i, c in enumerate(data) if c == ord("\n")]
        found.append(data.decode())
    return "".join(found)


@settings(max_examples=200, deadline=None)
@given(st.integers(0, 5), st.integers(0, 2**32), st.sampled_from([1.0, 1e3, 1e5, 1e12, 1e300]))
def test_lines_of_all_kinds_of_cells(steps: int, seed: int, scale: float) -> None:
    rng = np.random.default_rng(seed)
    table = rng.normal(size=(steps, WIDTH)) * scale
    table[rng.random(table.shape) < 0.1] = rng.choice([np.nan, np.inf, -np.inf, -0.0])
    lines = [line for line in range(steps * ROWS) if rng.random() < 0.8]
    assert printed(table, lines, SPANS, ROWS) == lines_by_python(table, lines, SPANS, ROWS)


def test_more_lines_than_are_made_at_once() -> None:
    table = np.random.default_rng(1).random((3000, 100)) * 9.0
    spans, lines = [Span(6, 0, 0, 100)], list(range(3000))
    assert printed(table, lines, spans, 1) == lines_by_python(table, lines, spans, 1)


def test_more_decimals_than_the_kernel_makes() -> None:
    table = np.array([[0.1, 1e-8], [0.2, 3.0]])
    made = printed(table, [0, 1], [Span(15, 0), Span(6, 1), Span(NAME, 2), Span(MISSING), Span(NOTHING)], 1)
    assert made == "0.100000000000000,0.000000,räuber,nan,\n0.200000000000000,3.000000,räuber,nan,\n"
