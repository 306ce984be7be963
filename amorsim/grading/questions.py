"""Questions with known answers, which a submission gives in its ``ANSWERS``, by their numbers."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import attrs

from amorsim.core.numbers import is_number
from amorsim.grading.toml_tables import read_tables
from amorsim.scenario.reading.faults import Node, shown

__all__ = ["ANSWERS", "Answers", "Question", "answers_from", "read_questions"]

ANSWERS = "ANSWERS"
"""The variable of a submission's file that holds its answers: a dict, by the numbers of the questions."""
Answers = Mapping[str, float | str]

_LARGEST = 1e15  # larger numbers are taken for mistakes
_MOST = 200  # answers, and characters of one


@attrs.frozen(kw_only=True)
class Question:
    """A question: the right answer, and its points.

    Attributes
    ----------
    number
        By which the handout and the answers name it.
    answer
        A number, or a word; capital letters do not matter.
    tolerance
        How far a number may be off.
    unit
        Of the number, for people.
    points
        For a right answer.
    """

    number: str
    answer: float | str
    tolerance: float = 0.0
    unit: str = ""
    points: float = 1.0

    @property
    def name(self) -> str:
        """Its name in tables."""
        return f"question {self.number}"

    @property
    def in_words(self) -> tuple[str, str]:
        """What earns no points and what earns all, without the right answer."""
        return "a wrong answer", "the right one"

    def is_right(self, answers: Answers) -> bool:
        """Whether the answer among these is right."""
        found = answers.get(self.number)
        if isinstance(self.answer, str):
            return isinstance(found, str) and found.strip().lower() == self.answer.lower()
        return isinstance(found, float) and abs(found - self.answer) <= self.tolerance


def read_questions(path: str | os.PathLike[str]) -> tuple[Question, ...]:
    """The questions in a file: a table ``questions`` of numbers or words, by the numbers of the questions.

    Raises
    ------
    StudyError
        With all that is wrong with it.
    """
    return read_tables(path, ("format", "questions"), _read)


def answers_from(sent: Any) -> Answers:
    """The answers in a submission: finite numbers and short words, by name; anything else is not an answer."""
    found: dict[str, float | str] = {}
    if isinstance(sent, dict) and len(sent) <= _MOST:
        for name, value in sent.items():
            if is_number(value, below=_LARGEST):
                found[name] = float(value)
            elif isinstance(value, str) and len(value) <= _MOST:
                found[name] = value
    return found


def _read(top: Node, _: Path) -> tuple[Question, ...]:
    questions = top.child("questions")
    if not questions.expect_table("a table of questions, as in 1 = { answer = 0.5, tolerance = 0.01 }"):
        return ()
    if not questions.value:
        questions.fault("expected one question at least, got none")
    return tuple(_question(number, child) for number, child in questions.children())


def _question(number: str, child: Node) -> Question:
    nothing = Question(number=number, answer="")
    if not child.expect_table("a table, as in { answer = 0.5, tolerance = 0.01 }"):
        return nothing
    child.refuse_unknown(("answer", "tolerance", "unit", "points"))
    answer, unit = child.value.get("answer"), child.value.get("unit", "")
    if not isinstance(answer, str) and not is_number(answer, below=_LARGEST):
        child.child("answer").fault(f"expected a number or a word, got {shown(answer)}")
        return nothing
    numbers = {}
    for key, default in (("tolerance", 0.0), ("points", 1.0)):
        value = child.value.get(key, default)
        if not is_number(value, below=_LARGEST) or value < 0:
            child.child(key).fault(f"expected a number, 0 or more, got {shown(value)}")
            value = default
        numbers[key] = float(value)
    if not isinstance(unit, str):
        child.child("unit").fault(f"expected a unit, as in 'm', got {shown(unit)}")
        unit = ""
    if isinstance(answer, str) and "tolerance" in child:
        child.child("tolerance").fault("a word is right or wrong; a tolerance is for numbers")
    return Question(number=number, answer=answer if isinstance(answer, str) else float(answer), unit=unit, **numbers)
