"""Text that a submission sent harms no terminal, table or page."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from amorsim.grading.submitted_text import as_line, csv_cell


@pytest.mark.parametrize(
    ("text", "line"),
    [
        ("ValueError: no way", "ValueError: no way"),
        ("first\n\n  second \nthird\n", "first / second ..."),
        ("one\x1b[2Jtwo\x00", "one\\x1b[2Jtwo\\x00"),
        ("left \u202e right", "left \\u202e right"),
        ("half \ud800", "half \\ud800"),
        ("größer als 5 €", "größer als 5 €"),
    ],
)
def test_a_text_becomes_a_line(text: str, line: str) -> None:
    assert as_line(text) == line


def test_a_long_text_keeps_its_beginning_and_its_end() -> None:
    line = as_line("begin " + "x" * 2000 + " end")
    assert len(line) == 400
    assert line.startswith("begin x")
    assert line.endswith("x end")


@given(st.text(st.characters()))
def test_every_text_becomes_one_printable_line(text: str) -> None:
    line = as_line(text)
    assert line.isprintable()
    assert len(line) <= 400
    line.encode()


@pytest.mark.parametrize("text", ["=1+1", "+1", "-1", "@SUM(1)", "  =1+1", "\t=1"])
def test_no_cell_is_a_formula(text: str) -> None:
    assert csv_cell(text) == f"'{text}"


def test_other_cells_stay_as_they_are() -> None:
    assert csv_cell("ann: 1 = 1") == "ann: 1 = 1"
