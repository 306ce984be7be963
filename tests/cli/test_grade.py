"""``amorsim grade``: what it refuses before it grades, and what it says without a fence."""

from __future__ import annotations

import io
import sys
from pathlib import Path

import pytest

from tests.cli.conftest import Command
from tests.grading.courses import make_course


def test_no_grades_are_replaced(amorsim: Command, tmp_path: Path) -> None:
    (tmp_path / "grades").mkdir()
    (tmp_path / "grades" / "grades.csv").write_text("of the first round")
    result = amorsim("grade", "rubric.toml", "ann.py")
    assert result.status == 2
    assert "grades: the folder holds files already, such as grades.csv" in result.err
    assert "rubric.toml: there is no such file" in result.err  # all at once
    assert "ann.py: there is no such file" in result.err
    assert (tmp_path / "grades" / "grades.csv").read_text() == "of the first round"


def test_with_the_lecturers_word_every_result_says_that_there_was_no_fence(
    amorsim: Command,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setenv("PATH", "")
    course = make_course(tmp_path / "course")
    (course.parent / "leaky.py").write_text("def drive(*_):\n    raise ValueError('of the rubric')\n")
    ended = amorsim("grade", course, course.parent / "leaky.py", "--no-fence")
    assert ended.status == 0
    assert "graded without a fence" in ended.out
    assert "of the rubric" in ended.out
    table = (tmp_path / "grades" / "grades.csv").read_text()
    assert table.splitlines()[0].endswith(",fence")
    assert table.splitlines()[1].endswith(",none")
    assert "of the rubric" in table
    page = (tmp_path / "grades" / "leaky.html").read_text()
    assert "Graded without a fence" in page
    assert "of the rubric" not in page  # it may have read anything


def test_what_a_terminal_cannot_show_does_not_end_the_grading(
    amorsim: Command, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    course = make_course(tmp_path / "course")
    (course.parent / "größer.py").write_text("def drive(*_):\n    return 'größer'\n", encoding="utf-8")
    shown = io.BytesIO()
    monkeypatch.setattr(sys, "stdout", io.TextIOWrapper(shown, encoding="ascii"))
    assert amorsim("grade", course, course.parent / "größer.py", "--no-fence").status == 0
    assert "gr\\xf6\\xdfer, run 1: controller 'gr\\xf6\\xdfer.py:drive'" in shown.getvalue().decode("ascii")
