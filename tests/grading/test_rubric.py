"""Rubrics and seeds: what is wrong or missing is reported, all of it, before anybody is graded."""

from __future__ import annotations

from pathlib import Path

import pytest

import amorsim as am
from amorsim.grading.grade import grade
from amorsim.grading.rubric import read_rubric
from amorsim.grading.seeds import Seed, draw_seeds, read_seeds, write_seeds
from tests.grading.courses import GOOD, RUBRIC, fence_problem, graded, make_course


@pytest.fixture
def course(tmp_path: Path) -> Path:
    return make_course(tmp_path / "course")


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ('"small.toml"', '"none.toml"', "none.toml"),
        ("points = 6.0", "points = 'six'", "expected a number, got 'six'"),
        ("points = 6.0", "points = inf", "expected a number, got inf"),
        ("points = 6.0", "points = -6.0", "expected 0 or more, got -6"),
        ("full = 0.0", "full = nan", "expected a number, or two in a list, got nan"),
        ("full = 0.0", "full = [0.0, 'two']", "expected a number, or two in a list, got"),
        ("full = 0.0", "full = [0.0, 0.5]", "expected two values as for none, and between them"),
        ("none = 1.0, full = 0.0", "none = [0, 3], full = [2, 1]", "expected two values as for none, and between them"),
        ("full = 0.0", "full = 1.0", "expected another value than for none"),
        ("time_limit = 2.0", "time_limit = 0", "time_limit: expected a number > 0"),
        ("time_limit = 2.0", "memory_limit = inf", "memory_limit: expected a number > 0, got inf"),
        ("runs = 1", "practice = true\nseeds = 11", "seeds: expected a list of seeds"),
        ("runs = 1", "practice = true\nseeds = [-1]", "seeds: expected a list of seeds"),
        ("runs = 1", "practice = true\nruns = 1", "runs: for practice, give seeds in its place"),
        ("runs = 1", "practice = 1", "practice: expected true or false, got 1"),
        ("runs = 1", "seeds = [11]", "seeds: a submission can find a seed by trying"),
        ("runs = 1", "runs = 0", "runs: expected a whole number of runs from 1"),
        ("runs = 1", "runs = 1.5", "runs: expected a whole number of runs from 1"),
        ("runs = 1", "files = ['none.txt']", "none.txt: there is no such file, which the rubric gives"),
        ("runs = 1", "files = 'none.txt'", "files: expected a list of files"),
        ("runs = 1", "beside = ['../other/policy.onnx']", "beside: expected names of files without a folder"),
        ("runs = 1", "beside = [5]", "beside: expected a list of names of files"),
        ("runs = 1", "worlds = [1]", "worlds: expected a list of map files"),
        ("runs = 1", "robot = 5", "robot: expected the name of a robot, got 5"),
        ('title = "First homework"', "title = 5", "title: expected a title, got 5"),
        ('use = "turning"', 'use = "turnin"', "Did you mean 'turning'"),
        ("duration = 3.0", "length = 3.0", "length: "),
    ],
)
def test_a_wrong_rubric_is_reported_before_anybody_is_graded(course: Path, old: str, new: str, words: str) -> None:
    assert old in RUBRIC
    course.write_text(RUBRIC.replace(old, new))
    with pytest.raises(am.StudyError, match=words):
        graded(course, fence=False, good=GOOD)
    assert not (course.parent / "grades").exists()


@pytest.mark.parametrize(
    ("value", "share"),
    [(0.0, 0.0), (0.5, 0.0), (0.75, 0.5), (1.0, 1.0), (4.0, 1.0), (7.0, 0.5), (10.0, 0.0), (11.0, 0.0)],
)
def test_what_is_too_small_earns_as_little_as_what_is_too_large(course: Path, value: float, share: float) -> None:
    course.write_text(RUBRIC.replace("none = 1.0, full = 0.0", "none = [0.5, 10], full = [1, 4]"))
    criterion = read_rubric(course).criteria[-1]
    assert criterion.share(value) == share
    assert criterion.share(float("nan")) == 0.0


def test_all_that_is_missing_is_reported_at_once(course: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PATH", "")
    text = RUBRIC.replace("runs = 1", "worlds = ['a.wld', 'b.wld']\nfiles = ['gains.txt']")
    course.write_text(text)
    with pytest.raises(am.StudyError) as raised:
        grade(course, [course.parent / "ann.py", course.parent], course.parent / "grades", seeds="none.toml")
    lines = str(raised.value).splitlines()
    for words in (
        *("none.toml: there is no such file", "ann.py: there is no such file; a submission is a file of Python"),
        *("it is a folder; a submission is a file of Python", "gains.txt: there is no such file"),
        *("a.wld", "b.wld", "bubblewrap"),
    ):
        assert sum(words in line for line in lines) == 1, (words, lines)
    course.write_text("title = 5\n")
    with pytest.raises(am.StudyError) as raised:
        grade(course, [course.parent / "ann.py"], course.parent / "grades", fence=False)
    for words in (
        "format: missing",
        "title: expected",
        "scenario: expected",
        "criteria: expected",
        "ann.py: there is no",
    ):
        assert words in str(raised.value)


def test_seeds_are_drawn_from_all_that_there_are() -> None:
    drawn = draw_seeds(1000)
    assert len(set(drawn)) == 1000
    # Of 1000 numbers of n bits half are in the upper half: with odds of 1 in 10^9 less than 400 or more than 600.
    assert all(
        400 < sum(number > top / 2 for number in numbers) < 600
        for numbers, top in (([each.seed for each in drawn], 2**63), ([each.replica for each in drawn], 2**32))
    )


@pytest.mark.long
def test_a_grading_can_be_repeated(course: Path) -> None:
    course.write_text(RUBRIC.replace("runs = 1", "runs = 2"))
    (course.parent / "ann.py").write_text(GOOD)

    def values(out: str, seeds: Path | None = None) -> list[float]:
        (found,) = grade(
            course, [course.parent / "ann.py"], course.parent / out, seeds=seeds, fence=not fence_problem()
        )
        return [case.values["straight"] for case in found.cases]

    first = values("first")
    assert first[0] != first[1]
    assert values("second") != first
    assert values("third", course.parent / "first" / "seeds.toml") == first


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("format = 1\n", "runs: expected a list of runs"),
        ("format = 1\nruns = []\n", "runs: expected one run at least"),
        ("format = 1\nruns = [5]\n", "runs.0: expected a table"),
        ("format = 1\nruns = [{ seed = -1, replica = 0 }]\n", "seed: expected a whole number from 0"),
        ("format = 1\nruns = [{ seed = 1 }]\n", "replica: expected a whole number from 0"),
        ("runs = [{ seed = 1, replica = 2 }]\n", "format: missing"),
    ],
)
def test_wrong_seeds_are_refused(tmp_path: Path, text: str, words: str) -> None:
    (tmp_path / "seeds.toml").write_text(text)
    with pytest.raises(am.StudyError, match=words):
        read_seeds(tmp_path / "seeds.toml")


def test_seeds_are_read_as_written(tmp_path: Path) -> None:
    seeds = [Seed(2**63 - 1, 2**32 - 2), Seed(0)]
    write_seeds(tmp_path / "seeds.toml", seeds)
    assert read_seeds(tmp_path / "seeds.toml") == seeds
