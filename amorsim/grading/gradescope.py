"""Grades in the form that Gradescope's autograder reads."""

from __future__ import annotations

import json
import os
from pathlib import Path

from amorsim.core.files.atomic_files import write_text
from amorsim.grading.results import Grade
from amorsim.grading.rubric import Rubric, read_rubric

__all__ = ["gradescope_results", "write_gradescope"]


def write_gradescope(file: Path, rubric: str | os.PathLike[str], found: Grade) -> None:
    """Write a grade as the ``results.json`` that Gradescope's autograder reads."""
    write_text(file, json.dumps(gradescope_results(read_rubric(rubric), found), indent=1) + "\n")


def gradescope_results(rubric: Rubric, found: Grade) -> dict[str, object]:
    """A grade in Gradescope's form: the score, and a test for each criterion and question."""
    problems = sorted({case.problem for case in found.cases if case.problem})
    output = f"The mean of {len(found.cases)} runs, with seeds that were drawn for this grading."
    return {
        "score": round(found.total, 4),
        "output": "\n".join([output, *(f"A run did not finish: {problem}" for problem in problems)]),
        "tests": [
            {
                "name": each.name,
                "score": round(found.points_for(each.name), 4),
                "max_score": each.points,
                "output": "none at {}, all points at {}".format(*each.in_words),
            }
            for each in rubric.parts
        ],
    }
