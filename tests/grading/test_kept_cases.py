"""A grading that was interrupted goes on where it stopped, and several processes give the same grades as one."""

from __future__ import annotations

from pathlib import Path

import pytest

import amorsim as am
from amorsim.grading.grade import Grade, grade
from tests.grading.courses import GOOD, LAZY, RUBRIC, make_course

TOTAL = 4  # cases: two submissions in two runs


@pytest.fixture
def course(tmp_path: Path) -> Path:
    path = make_course(tmp_path / "course")
    path.write_text(RUBRIC.replace("runs = 1", "runs = 2").replace("time_limit = 2.0", "time_limit = 20.0"))
    (path.parent / "ann.py").write_text(GOOD)
    (path.parent / "ben.py").write_text(LAZY)
    return path


def graded(course: Path, out: str, *, stop: int = TOTAL + 1, **options: object) -> tuple[list[Grade], list[str]]:
    """The grades, and the lines of progress; interrupted at the line of a number."""
    lines: list[str] = []

    def progress(line: str, done: int, total: int) -> None:
        lines.append(line)
        assert total == TOTAL
        if done >= stop:
            raise KeyboardInterrupt

    papers = [course.parent / name for name in ("ann.py", "ben.py")]
    return grade(course, papers, course.parent / out, fence=False, progress=progress, **options), lines  # type: ignore[arg-type]


def table(course: Path, out: str) -> str:
    return (course.parent / out / "grades.csv").read_text()


@pytest.mark.long
def test_what_was_graded_is_not_graded_again(course: Path) -> None:
    with pytest.raises(KeyboardInterrupt):
        graded(course, "out", stop=3)
    assert table(course, "out").count("\n") == 2  # ann is finished
    kept = course.parent / "out" / "cases.jsonl"
    kept.write_text(kept.read_text() + '{"submission": "half a li')
    grades, lines = graded(course, "out")
    assert [line.partition(":")[0] for line in lines] == ["ben, run 2"]
    assert [one.label for one in grades] == ["ann", "ben"]
    whole, _ = graded(course, "whole", seeds=course.parent / "out" / "seeds.toml")
    assert table(course, "whole") == table(course, "out")
    assert [one.total for one in whole] == [one.total for one in grades]
    _, lines = graded(course, "out")
    assert lines == []
    (course.parent / "ben.py").write_text(GOOD)
    grades, lines = graded(course, "out")
    assert len(lines) == 2
    assert grades[1].total == grades[0].total > 5.0


def test_a_grading_by_another_rubric_is_left_alone(course: Path) -> None:
    graded(course, "out")
    before = table(course, "out")
    course.write_text(course.read_text().replace("points = 4.0", "points = 5.0"))
    with pytest.raises(am.StudyError, match="by another rubric"):
        graded(course, "out")
    assert table(course, "out") == before


@pytest.mark.long
def test_a_grading_that_was_killed_before_its_first_case_goes_on(course: Path) -> None:
    graded(course, "whole")
    (course.parent / "out").mkdir()
    seeds = (course.parent / "whole" / "seeds.toml").read_bytes()
    (course.parent / "out" / "seeds.toml").write_bytes(seeds)
    graded(course, "out")
    assert (course.parent / "out" / "seeds.toml").read_bytes() == seeds
    assert table(course, "out") == table(course, "whole")
    (course.parent / "other").mkdir()
    (course.parent / "other" / "seeds.toml").write_bytes(seeds)
    (course.parent / "other" / "mine.txt").touch()
    with pytest.raises(am.StudyError, match="other"):
        graded(course, "other")


@pytest.mark.long
def test_several_processes_give_the_grades_of_one(course: Path) -> None:
    one, _ = graded(course, "one")
    two, lines = graded(course, "two", seeds=course.parent / "one" / "seeds.toml", jobs=2)
    assert len(lines) == TOTAL
    assert table(course, "two") == table(course, "one")
    assert repr([each.cases for each in two]) == repr([each.cases for each in one])  # with nan


def test_fewer_processes_than_one_are_refused(course: Path) -> None:
    with pytest.raises(am.StudyError, match="expected 1 or more"):
        graded(course, "out", jobs=0)
    assert not (course.parent / "out").exists()
