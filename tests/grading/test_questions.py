"""Questions: answers in a submission's file earn points, whatever else it sends counts as no answer."""

from __future__ import annotations

from pathlib import Path

import pytest

import amorsim as am
from amorsim.grading.questions import Question, answers_from, read_questions
from tests.grading.courses import GOOD, RUBRIC, graded, make_course

ANSWERS = """\
format = 1

[questions]
1 = { answer = 0.5, tolerance = 0.01, unit = "m" }
2 = { answer = "Left", points = 2.0 }
"""


@pytest.fixture
def course(tmp_path: Path) -> Path:
    return make_course(tmp_path / "course")


@pytest.mark.long
def test_a_right_answer_earns_its_points(course: Path) -> None:
    course.write_text(RUBRIC.replace("runs = 1", 'runs = 1\nquestions = "answers.toml"'))
    (course.parent / "answers.toml").write_text(ANSWERS)
    right = f"ANSWERS = {{1: 0.505, 2: ' left'}}\n{GOOD}"
    wrong = f"ANSWERS = {{1: 0.52, 2: 'right', 3: 1}}\n{GOOD}"
    found = graded(course, fence=False, right=right, wrong=wrong, none=GOOD)
    assert found["right"].of == 13.0
    assert found["right"].points_for("question 1") == 1.0
    assert found["right"].points_for("question 2") == 2.0
    assert found["right"].total == pytest.approx(found["none"].total + 3.0)
    assert found["wrong"].total == pytest.approx(found["none"].total)
    page = (course.parent / "grades" / "wrong.html").read_text()
    assert "question 2" in page
    assert "Left" not in page


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("answer = 0.5", "answer = [0.5]", "expected a number or a word"),
        ("answer = 0.5, ", "", "expected a number or a word"),
        ("tolerance = 0.01", "tolerance = -1", "tolerance: expected a number, 0 or more"),
        ("points = 2.0", "tolerance = 1.0", "a word is right or wrong"),
        ("points = 2.0", "points = 'two'", "points: expected a number, 0 or more"),
        ('unit = "m"', "unit = 1", "unit: expected a unit"),
        ("points = 2.0", "worth = 2.0", "worth"),
        ("1 = {", "1 = 0.5 #", "expected a table"),
        (ANSWERS[ANSWERS.index("1 =") :], "", "expected one question at least"),
    ],
)
def test_a_wrong_file_of_questions_is_reported(tmp_path: Path, old: str, new: str, words: str) -> None:
    file = tmp_path / "answers.toml"
    assert old in ANSWERS
    file.write_text(ANSWERS.replace(old, new))
    with pytest.raises(am.StudyError, match=words):
        read_questions(file)


@pytest.mark.parametrize(("name", "words"), [("'none.toml'", "none.toml"), ("5", "expected the name of a file")])
def test_a_rubric_names_a_file_that_is_there(course: Path, name: str, words: str) -> None:
    course.write_text(RUBRIC.replace("runs = 1", f"runs = 1\nquestions = {name}"))
    with pytest.raises(am.StudyError, match=words):
        graded(course, fence=False, good=GOOD)


@pytest.mark.parametrize(
    "sent",
    [
        None,
        [],
        5,
        {"1": None, "2": True},
        {"1": [0.5]},
        {"1": float("nan")},
        {"2": "x" * 1000},
        {str(n): 1 for n in range(999)},
    ],
)
def test_what_is_not_an_answer_counts_as_none(sent: object) -> None:
    assert dict(answers_from(sent)) == {}


def test_a_number_is_right_within_its_tolerance() -> None:
    question = Question(number="1", answer=2.0, tolerance=0.1)
    given = {0.0: False, 1.95: True, 2.05: True, 2.2: False}
    assert {value: question.is_right(answers_from({"1": value})) for value in given} == given
    assert question.is_right(answers_from({"1": 2}))
    assert not question.is_right(answers_from({"1": "2.0"}))
    assert not question.is_right({})


@pytest.mark.long
def test_a_criterion_earns_nothing_without_the_one_that_it_is_given_with(course: Path) -> None:
    course.write_text(RUBRIC.replace("full = 0.0", 'full = 0.0, given = "arrived"'))
    lazy = "def drive(readings, estimate, clock):\n    import amorsim as am\n    return am.Twist(0.0, 0.0)\n"
    found = graded(course, fence=False, good=GOOD, lazy=lazy)
    assert found["good"].points_for("straight") > 0.0
    assert found["lazy"].cases[0].problem == ""
    assert found["lazy"].total == 0.0
    course.write_text(
        RUBRIC.replace("points = 6.0", "points = 0.0").replace("full = 0.0", 'full = 0.0, given = "arrived"')
    )
    (course.parent / "grades").rename(course.parent / "before")
    assert graded(course, fence=False, good=GOOD)["good"].points_for("straight") > 0.0
    for name in ('"straight"', '"none"', '""', "false"):
        course.write_text(RUBRIC.replace("full = 0.0", f"full = 0.0, given = {name}"))
        with pytest.raises(am.StudyError, match="expected the name of a criterion above it"):
            graded(course, fence=False, good=GOOD)
