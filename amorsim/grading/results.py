"""The results of a grading, and how they are written: a table for the lecturer, and a page for each student."""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Sequence
from pathlib import Path

import attrs

from amorsim.grading.rubric import Rubric
from amorsim.grading.seeds import Seed
from amorsim.grading.submitted_text import as_line, csv_cell
from amorsim.reports.page import Page
from amorsim.scenario.toml.literals import as_toml

__all__ = ["UNFENCED", "Case", "CaseGrade", "Grade", "page_of", "table_of"]

UNFENCED = "none"
"""The fence of a grading without one."""


@attrs.frozen(kw_only=True)
class Case:
    """One run of a submission: its number from 1, its seed, and a world or the scenario's own."""

    number: int
    seed: Seed
    world: str = ""

    def __str__(self) -> str:
        return f"run {self.number}" + (f", {Path(self.world).name}" if self.world else "")

    @property
    def settings(self) -> tuple[str, ...]:
        """The settings of this case."""
        return (f"world.map={as_toml(self.world)}",) if self.world else ()


@attrs.frozen(kw_only=True)
class CaseGrade:
    """A submission's result in one case: values and points by criterion, or why it has none."""

    case: Case
    values: dict[str, float] = attrs.field(factory=dict)
    points: dict[str, float] = attrs.field(factory=dict)
    problem: str = ""

    @property
    def total(self) -> float:
        """Its points in this case."""
        return math.fsum(self.points.values())


@attrs.frozen(kw_only=True)
class Grade:
    """A submission's points: the mean of its cases.

    `of` is what could be earned; `fence` is what it was fenced in by, or ``"none"``; `left_out` are files that it did
    not get, because they are links.
    """

    submission: Path
    label: str
    cases: tuple[CaseGrade, ...]
    of: float
    fence: str
    left_out: tuple[str, ...] = ()

    @property
    def total(self) -> float:
        """Its points."""
        return math.fsum(case.total for case in self.cases) / len(self.cases)

    def points_for(self, criterion: str) -> float:
        """Its points for a criterion."""
        return math.fsum(case.points.get(criterion, 0.0) for case in self.cases) / len(self.cases)


def table_of(rubric: Rubric, grades: Sequence[Grade]) -> str:
    """The table of all submissions, as CSV."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    names = [each.name for each in rubric.parts]
    writer.writerow(
        ["submission", "total", "of", *names, "cases", "without points", "first reason", "left out", "fence"]
    )
    for each in grades:
        problems = [case.problem for case in each.cases if case.problem]
        numbers = [each.total, *map(each.points_for, names)]
        total, *parts = (f"{number:.4g}" for number in numbers)
        texts = [problems[0] if problems else "", as_line("; ".join(each.left_out)), each.fence]
        counts = [len(each.cases), len(problems)]
        writer.writerow([csv_cell(each.label), total, f"{rubric.points:g}", *parts, *counts, *map(csv_cell, texts)])
    return text.getvalue()


def page_of(rubric: Rubric, found: Grade) -> Page:
    """The page of a submission, for its author."""
    page = Page(f"{rubric.title}: {found.label}", f"{found.total:.3g} of {rubric.points:g} points")
    page.heading("Criteria")
    page.table(
        ["criterion", "points", "of", "none at", "all at"],
        [
            [
                f"{each.name}{f' [{each.unit}]' if each.unit else ''}",
                f"{found.points_for(each.name):.3g}",
                f"{each.points:g}",
                *each.in_words,
            ]
            for each in rubric.parts
        ],
    )
    page.heading("Runs")
    names = [each.name for each in rubric.parts]
    page.table(
        ["run", *names, "points", "what happened"],
        [
            [
                str(case.case.number),  # which seed and world it was stays with the lecturer
                *(f"{case.values[name]:.4g}" if name in case.values else "-" for name in names),
                f"{case.total:.3g}",
                _what_happened(case, found.fence),
            ]
            for case in found.cases
        ],
    )
    page.paragraph("Points are the mean over all runs. Seeds and worlds of the runs stay with the lecturer.")
    if rubric.practice:
        page.paragraph("For practice: the seeds are known, so these are not marks.")
    if found.fence == UNFENCED:
        page.paragraph("Graded without a fence: the submission could read and change what the lecturer can.")
    return page


def _what_happened(case: CaseGrade, fence: str) -> str:
    """How a case ended, for the submission's author."""
    if not case.problem:
        return "ran to its end"
    # Without a fence, an error's text may hold what the submission has read elsewhere.
    return "had to be stopped; the lecturer has the reason" if fence == UNFENCED else case.problem
