"""``amorsim grade``: what it refuses before it grades."""

from __future__ import annotations

from pathlib import Path

from tests.cli.conftest import Command


def test_no_grades_are_replaced(amorsim: Command, tmp_path: Path) -> None:
    (tmp_path / "grades").mkdir()
    (tmp_path / "grades" / "grades.csv").write_text("of the first round")
    (tmp_path / "ann.py").touch()
    result = amorsim("grade", "rubric.toml", "ann.py")
    assert result.status == 2
    assert "grades: the folder holds files already, such as grades.csv" in result.err
    assert (tmp_path / "grades" / "grades.csv").read_text() == "of the first round"
