"""``amorsim lab``: a student lists, begins and checks a lab; a lecturer makes one."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from amorsim.grading import score
from amorsim.grading.rubric import read_rubric
from amorsim.labs import find_lab, find_labs, own_lab, start_lab
from tests.cli.conftest import Command, amorsim
from tests.grading.courses import fence_problem

__all__ = ["amorsim"]


def test_labs_are_listed(amorsim: Command) -> None:
    said = amorsim("lab").out
    for lab in find_labs():
        assert f"{lab.number:>2}  {lab.title}" in said
        assert lab.about in said


def test_a_lab_is_begun_in_a_folder_of_its_own(amorsim: Command) -> None:
    said = amorsim("lab", "start", "6").out
    assert "lab-6" in said
    assert "amorsim lab check lab-6" in said
    names = {path.name for path in Path("lab-6").iterdir()}
    assert names == {"expected.png", "filter.py", "handout.ipynb", "handout.md", "lab.toml", "room.wld", "rubric.toml"}
    assert "questions" not in Path("lab-6/rubric.toml").read_text(encoding="utf-8")
    handout = Path("lab-6/handout.md").read_text(encoding="utf-8")
    assert "](../" not in handout
    assert amorsim("check", "lab-6/lab.toml").status == 0
    assert "there is something in it" in amorsim("lab", "start", "6", "lab-6").err
    assert "known labs: 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13" in amorsim("lab", "start", "99", "other").err
    assert not Path("other").exists()
    assert amorsim("lab", "2").out == amorsim("lab", "start", "2", "again").out.replace("again", "lab-2")
    Path("empty").mkdir()
    assert "not the folder of a lab" in amorsim("lab", "check", "empty").err


def test_a_lecturer_begins_with_a_copy(amorsim: Command) -> None:
    assert amorsim("lab", "new", "mine", "--from", "4").status == 0
    assert Path("mine/solutions/good.py").exists()
    assert own_lab(Path("mine")).title == find_lab(4).title
    assert read_rubric(Path("mine/rubric.toml")).questions
    assert amorsim("lab", "notebook", "mine").status == 0
    assert "Lab 4" in Path("mine/handout.ipynb").read_text(encoding="utf-8")
    (Path("mine") / "handout.md").write_text("# Mine\n\nAbout it.\n", encoding="utf-8")
    assert "expected a section that begins with '## 2.'" in amorsim("lab", "notebook", "mine").err


@pytest.mark.long
def test_a_student_sees_what_a_file_earns(amorsim: Command, tmp_path: Path) -> None:
    start_lab(find_lab(5), tmp_path / "lab")
    good = find_lab(5).folder / "solutions" / "good.py"
    (tmp_path / "lab" / "heading.py").write_bytes(good.read_bytes())
    fence = ["--no-fence"] if fence_problem() else []
    said = amorsim("lab", "check", "lab", *fence).out
    assert "of 10 points, the mean of 3 runs" in said
    results = tmp_path / "results.json"
    graded = amorsim(
        "grade", "lab/rubric.toml", "lab/heading.py", "--out", "grades", "--gradescope", results, "--quiet", *fence
    )
    assert graded.status == 0, graded.err
    found = json.loads(results.read_text(encoding="utf-8"))
    assert found["score"] >= 9.0
    assert found["score"] == pytest.approx(sum(test["score"] for test in found["tests"]), abs=1e-3)
    assert score(5, good).total >= 9.0
    two = amorsim("grade", "lab/rubric.toml", good, "lab/heading.py", "--out", "two", "--gradescope", results)
    assert "one submission" in two.err
