"""Grades of finished submissions are kept when grading is interrupted."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

import amorsim.grading.grade as grading
from tests.grading.courses import GOOD, make_course


@pytest.fixture
def rubric(tmp_path: Path) -> Path:
    for name in ("ann", "ben"):
        (tmp_path / f"{name}.py").write_text(GOOD)
    return make_course(tmp_path / "course")


def test_after_ctrl_c_the_table_has_all_that_were_finished(rubric: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def only_ann(_: Any, case: Any, __: Any, handed_in: Any) -> Any:
        if handed_in.name != "ann.py":
            raise KeyboardInterrupt
        return grading.CaseGrade(case=case, values={}, points={}, problem="too slow")

    monkeypatch.setattr(grading, "_case", only_ann)
    folder = rubric.parent.parent
    with pytest.raises(KeyboardInterrupt):
        grading.grade(rubric, [folder / "ann.py", folder / "ben.py"], folder / "grades", fence=False)
    table = (folder / "grades" / "grades.csv").read_text()
    assert "ann," in table
    assert "ben" not in table
