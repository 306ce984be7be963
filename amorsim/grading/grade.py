"""Grading submissions: each runs every case of a rubric, in a process of its own."""

from __future__ import annotations

import csv
import io
import math
import os
import re
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import attrs
import numpy as np

from amorsim.controllers.user import UserController
from amorsim.core.errors import AmorsimError, RunError, StudyError
from amorsim.core.whole_files import write_text
from amorsim.grading.guard import memory_hidden
from amorsim.grading.remote import Remote, SubmittedEstimator
from amorsim.grading.rubric import Case, Rubric, read_rubric
from amorsim.reports.page import Page
from amorsim.scenario.read import load
from amorsim.scenario.spec import Scenario
from amorsim.simulation.keeping import Keeper
from amorsim.simulation.simulation import Simulation
from amorsim.sweeps.chunk import episode_at, measure_episode
from amorsim.sweeps.plan import Measured

__all__ = ["CaseGrade", "Grade", "grade"]


@attrs.frozen(kw_only=True)
class CaseGrade:
    """What a submission did in one case: values and points by criterion, or why it has none."""

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
    """What a submission earned: the mean of its cases."""

    submission: Path
    label: str
    cases: tuple[CaseGrade, ...]

    @property
    def total(self) -> float:
        """Its points."""
        return math.fsum(case.total for case in self.cases) / len(self.cases)

    def points_for(self, criterion: str) -> float:
        """Its points for a criterion."""
        return math.fsum(case.points.get(criterion, 0.0) for case in self.cases) / len(self.cases)


def grade(
    rubric: str | os.PathLike[str],
    submissions: Sequence[str | os.PathLike[str]],
    out: str | os.PathLike[str],
    *,
    progress: Callable[[str], None] | None = None,
) -> list[Grade]:
    """Grade controllers or estimators in files; write ``grades.csv`` for the lecturer and a page for each submission.

    A submission runs in a process that has neither the simulation nor the truth: it gets what a controller or an
    estimator gets, and answers. If it raises, hangs, ends its process or needs too much memory, it has no points in
    that case, with the reason; other submissions are not affected.

    Parameters
    ----------
    rubric
        The path of its file.
    submissions
        The paths of Python files, each with the function or class that the rubric names.
    out
        The folder of the results, made if it is not there.
    progress
        Called with a line about each case.

    Raises
    ------
    StudyError
        If the rubric is not right, or there is no such submission.
    RunError
        If a file cannot be written.
    """
    read = read_rubric(rubric)
    paths = [Path(path) for path in submissions]
    for path in paths:
        if path.is_dir():
            raise StudyError(f"{path}: it is a folder; a submission is a file of Python")
        if not path.is_file():
            raise StudyError(f"{path}: there is no such file; a submission is a file of Python")
    folder = Path(out)
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise RunError(f"{folder}: cannot be written ({error.strerror or error})") from None
    scenarios = {case: _scenario(read, case) for case in read.cases}
    grades = []
    secret = [Path(rubric), folder, *(Path(case.world) for case in read.cases if case.world)]
    for path, label in zip(paths, _labels(paths), strict=True):
        hidden = [*secret, *(each for each in paths if each != path)]
        cases = []
        for case in read.cases:
            with memory_hidden():
                cases.append(_case(read, case, scenarios[case], path, hidden))
            if progress is not None:
                progress(f"{label}, {case}: {cases[-1].problem or f'{cases[-1].total:.2f} points'}")
        grades.append(Grade(submission=path, label=label, cases=tuple(cases)))
        write_text(folder / f"{label}.html", _page(read, grades[-1]).text)
        write_text(folder / "grades.csv", _table(read, grades))  # each time, so that Ctrl-C loses none
    return grades


def _labels(paths: Sequence[Path]) -> list[str]:
    """Names that tell submissions apart, fit for files: their stems, or those of their folders too."""
    stems = [path.stem for path in paths]
    if len(set(stems)) < len(stems):
        stems = [f"{path.absolute().parent.name}-{path.stem}" for path in paths]
    plain = [re.sub(r"[^\w.+-]+", "_", stem) for stem in stems]
    return [name if plain.count(name) == 1 else f"{name}-{i}" for i, name in enumerate(plain, start=1)]


def _scenario(rubric: Rubric, case: Case) -> Scenario:
    """The scenario of a case; the lecturer's own mistakes are reported before anything is graded."""
    try:
        scenario = load(rubric.scenario, case.settings)
        simulation = Simulation(scenario, seed=case.seed)
        robot = _robot(rubric, scenario)
        Keeper(simulation, _needs(rubric), 1)
    except AmorsimError as error:
        raise StudyError(f"rubric, {case}: {error}") from None
    if robot not in simulation.names:
        raise StudyError(f"rubric: robot: there is no robot {robot!r}, but: {', '.join(simulation.names)}")
    return scenario


def _robot(rubric: Rubric, scenario: Scenario) -> str:
    if not rubric.robot and len(scenario.robots) > 1:
        names = ", ".join(robot.name for robot in scenario.robots)
        raise StudyError(f"there are several robots; say whose the submission drives with robot = one of: {names}")
    return rubric.robot or scenario.robots[0].name


def _needs(rubric: Rubric) -> tuple[str, ...]:
    return tuple(dict.fromkeys(name for each in rubric.criteria for name in each.measured.metric.needs()))


def _case(rubric: Rubric, case: Case, scenario: Scenario, path: Path, hidden: Sequence[Path]) -> CaseGrade:
    robot = _robot(rubric, scenario)
    try:
        remote = Remote(
            path.absolute(),
            rubric.function,
            rubric.role,
            time_limit=rubric.time_limit,
            memory_limit=rubric.memory_limit,
            hidden=hidden,
        )
        with remote:
            change: dict[str, Any] = {"estimators": {"submission": SubmittedEstimator(remote=remote)}}
            if rubric.role == "controller":
                source = f"{path.name}:{rubric.function}"
                change = {"controller": UserController(source=source, function=remote)}
            robots = [attrs.evolve(each, **change) if each.name == robot else each for each in scenario.robots]
            simulation = Simulation(attrs.evolve(scenario, robots=robots, resolved=None), seed=case.seed)
            steps = simulation.steps_of(scenario.duration if rubric.duration is None else rubric.duration)
            keeper = Keeper(simulation, _needs(rubric), steps + 1)
            keeper.keep()
            for _ in range(steps):
                simulation.step()
                keeper.keep()
    except AmorsimError as error:
        return CaseGrade(case=case, problem=str(error))
    values, points = {}, {}
    for each in rubric.criteria:
        measured: Measured = each.measured
        episode = episode_at(
            simulation, keeper.arrays, measured.metric.needs(), measured.robot or robot, np.zeros(1, np.int64), steps
        )
        values[measured.name] = float(measure_episode(measured, episode)[0])
        points[measured.name] = each.points * each.share(values[measured.name])
    return CaseGrade(case=case, values=values, points=points)


def _table(rubric: Rubric, grades: Sequence[Grade]) -> str:
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    names = [each.measured.name for each in rubric.criteria]
    writer.writerow(["submission", "total", "of", *names, "cases", "without points", "first reason"])
    for each in grades:
        problems = [case.problem for case in each.cases if case.problem]
        row = [
            each.label,
            f"{each.total:.4g}",
            f"{rubric.points:g}",
            *(f"{each.points_for(name):.4g}" for name in names),
        ]
        writer.writerow([*row, len(each.cases), len(problems), problems[0] if problems else ""])
    return text.getvalue()


def _page(rubric: Rubric, found: Grade) -> Page:
    page = Page(f"{rubric.title}: {found.label}", f"{found.total:.3g} of {rubric.points:g} points")
    page.heading("Criteria")
    page.table(
        ["criterion", "points", "of", "none at", "all at"],
        [
            [
                f"{each.measured.name}{f' [{unit}]' if (unit := each.measured.metric.unit) else ''}",
                f"{found.points_for(each.measured.name):.3g}",
                f"{each.points:g}",
                f"{each.none:g}",
                f"{each.full:g}",
            ]
            for each in rubric.criteria
        ],
    )
    page.heading("Runs")
    names = [each.measured.name for each in rubric.criteria]
    page.table(
        ["run", *names, "points", "what happened"],
        [
            [
                str(number),  # which seed and world it was stays with the lecturer
                *(f"{case.values[name]:.4g}" if name in case.values else "-" for name in names),
                f"{case.total:.3g}",
                case.problem or "ran to its end",
            ]
            for number, case in enumerate(found.cases, start=1)
        ],
    )
    page.paragraph("Points are the mean over all runs. Seeds and worlds of the runs stay with the lecturer.")
    return page
