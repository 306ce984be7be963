"""Grades of finished submissions are kept when grading is interrupted."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

import amorsim.grading.grade as grading
from tests.grading.test_grade import GOOD, RUBRIC, SCENARIO
from tests.studies import make_study


@pytest.fixture
def rubric(tmp_path: Path) -> Path:
    make_study(tmp_path / "course")
    (tmp_path / "course" / "small.toml").write_text(SCENARIO)
    (tmp_path / "course" / "rubric.toml").write_text(RUBRIC)
    for name in ("ann", "ben"):
        (tmp_path / f"{name}.py").write_text(GOOD)
    return tmp_path / "course" / "rubric.toml"


def test_after_ctrl_c_the_table_has_all_that_were_finished(rubric: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def only_ann(_: Any, case: Any, __: Any, path: Path, *more: Any) -> Any:
        if path.stem != "ann":
            raise KeyboardInterrupt
        return grading.CaseGrade(case=case, values={}, points={}, problem="too slow")

    monkeypatch.setattr(grading, "_case", only_ann)
    folder = rubric.parent.parent
    with pytest.raises(KeyboardInterrupt):
        grading.grade(rubric, [folder / "ann.py", folder / "ben.py"], folder / "grades")
    table = (folder / "grades" / "grades.csv").read_text()
    assert "ann," in table
    assert "ben" not in table
