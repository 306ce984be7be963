"""Grading submissions: each runs every case of a rubric, in a process of its own."""

from __future__ import annotations

import functools
import itertools
import multiprocessing
import os
import re
from collections.abc import Callable, Collection, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from pathlib import Path
from typing import Any, TypeVar

import attrs
import numpy as np

from amorsim.controllers.user import UserController
from amorsim.core.error_text import RAISED, error_in_words
from amorsim.core.errors import AmorsimError, RunError, StudyError
from amorsim.core.execution.processes import end_with_parent
from amorsim.core.files.atomic_files import write_text
from amorsim.core.files.reading import is_file
from amorsim.core.unknown_names import no_such
from amorsim.grading.fence import Fence, find_fence
from amorsim.grading.handed_in import HandedIn, hand_in, leads_through_link
from amorsim.grading.kept_cases import SEEDS, KeptCases, digest_of
from amorsim.grading.remote import Remote, SubmittedEstimator
from amorsim.grading.results import UNFENCED, Case, CaseGrade, Grade, page_of, table_of
from amorsim.grading.rubric import Rubric, read_rubric
from amorsim.grading.seeds import Seed, draw_seeds, read_seeds, write_seeds
from amorsim.grading.submitted_text import as_line
from amorsim.runs.folder import check_free
from amorsim.scenario.reading.read import load
from amorsim.scenario.spec import Scenario
from amorsim.simulation.kept_quantities import Keeper
from amorsim.simulation.simulation import Simulation
from amorsim.sweeps.chunk import episode_at, ignore_interrupts, measure_episode, without_interrupts

__all__ = ["CaseGrade", "Grade", "grade"]

T = TypeVar("T")

_LONGEST_LABEL = 100  # characters


def grade(
    rubric: str | os.PathLike[str],
    submissions: Sequence[str | os.PathLike[str]],
    out: str | os.PathLike[str],
    *,
    fence: bool = True,
    seeds: str | os.PathLike[str] | None = None,
    jobs: int = 1,
    progress: Callable[[str, int, int], None] | None = None,
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
        The folder of the results, new or empty. ``seeds.toml`` in it repeats the grading. Where a grading by the same
        rubric was interrupted in it, this goes on with it; submissions that have changed are graded again.
    fence
        Whether submissions are fenced in by bubblewrap. Without it they can read and change what this process can.
    seeds
        The path of ``seeds.toml`` of an earlier grading, whose seeds are used again.
    jobs
        How many processes grade. They are started anew, so a script needs ``if __name__ == "__main__":``.
    progress
        Called with a line about each case, how many are done, and how many there are.

    Raises
    ------
    StudyError
        With all that is missing or wrong: rubric, scenario, submissions, seeds, fence, or a folder that is not empty.
    RunError
        If a file cannot be written.
    """
    if jobs < 1:
        raise StudyError(f"jobs: expected 1 or more, got {jobs}")
    paths, folder = [Path(path) for path in submissions], Path(out)
    kept = KeptCases(folder)
    seeds = folder / SEEDS if kept.goes_on and seeds is None else seeds
    grading = _prepare(Path(rubric), paths, folder, fence, seeds, goes_on=kept.goes_on)
    name = UNFENCED if grading.fence is None else grading.fence.version
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise RunError(f"{folder}: cannot be written ({error.strerror or error})") from None
    if not kept.goes_on:
        write_seeds(folder / SEEDS, grading.seeds)
    kept.open(Path(rubric), grading.rubric.questions, grading.seeds, name)
    desk = _Desk(grading, folder, list(zip(paths, _labels(paths), strict=True)), name)
    before, digests = kept.read(case for case, _ in grading.cases), []
    todo: list[_Task] = []
    for place, path in enumerate(paths):
        handed_in, problem = _handed_in(grading, path)
        digests.append(digest_of(handed_in, problem))
        desk.left_out.append(() if handed_in is None else handed_in.left_out)
        for number, (case, _) in enumerate(grading.cases):
            found = before.get((digests[-1], case.number))
            if found is None:
                todo.append((place, number))
            else:
                desk.take(place, found)
    total = len(paths) * len(grading.cases)
    again = (Path(rubric), paths, folder, fence, folder / SEEDS)
    for done, (place, found) in enumerate(_results(grading, paths, todo, jobs, again), start=total - len(todo) + 1):
        kept.add(digests[place], found)
        desk.take(place, found)
        if progress is not None:
            line = f"{desk.submissions[place][1]}, {found.case}: {found.problem or f'{found.total:.2f} points'}"
            progress(line, done, total)
    return desk.grades


_Task = tuple[int, int]  # the places of a submission and of a case


class _Desk:
    """Where finished cases arrive: whenever a submission is finished, its page is written, and the table again."""

    def __init__(self, grading: _Grading, folder: Path, submissions: Sequence[tuple[Path, str]], fence: str) -> None:
        self._grading, self._folder, self._fence = grading, folder, fence
        self.submissions = submissions
        self.left_out: list[tuple[str, ...]] = []  # of each submission
        self._cases: list[list[CaseGrade]] = [[] for _ in submissions]
        self._grades: dict[int, Grade] = {}

    @property
    def grades(self) -> list[Grade]:
        """The grades of the finished submissions, in the order of these."""
        return [self._grades[place] for place in sorted(self._grades)]

    def take(self, place: int, found: CaseGrade) -> None:
        """Take a case of the submission at a place."""
        cases, rubric = self._cases[place], self._grading.rubric
        cases.append(found)
        if len(cases) < len(self._grading.cases):
            return
        path, label = self.submissions[place]
        grade = self._grades[place] = Grade(
            submission=path,
            label=label,
            cases=tuple(sorted(cases, key=lambda each: each.case.number)),
            of=rubric.points,
            fence=self._fence,
            left_out=self.left_out[place],
        )
        write_text(self._folder / f"{label}.html", page_of(rubric, grade).text)
        write_text(self._folder / "grades.csv", table_of(rubric, self.grades))


def _results(
    grading: _Grading, paths: Sequence[Path], todo: Sequence[_Task], jobs: int, again: tuple[Any, ...]
) -> Iterator[tuple[int, CaseGrade]]:
    """The results of cases as they come; `again` is that from which other processes prepare the same grading."""
    if jobs == 1 or len(todo) < 2:
        for place, number in todo:
            yield place, _graded(grading, paths, place, number)
        return
    context = multiprocessing.get_context("spawn")
    pool = ProcessPoolExecutor(min(jobs, len(todo)), context, _begin_worker, (again, os.getpid()))
    with without_interrupts():
        waiting = {pool.submit(_graded_by_worker, *task): task for task in todo}
    try:
        while waiting:
            for future in wait(waiting, return_when=FIRST_COMPLETED).done:
                place, _ = waiting.pop(future)
                yield place, future.result()
    except BrokenProcessPool:
        raise StudyError("a process that graded died; it may have needed more memory than there is") from None
    finally:
        pool.shutdown(wait=False, cancel_futures=True)


def _graded(grading: _Grading, paths: Sequence[Path], place: int, number: int) -> CaseGrade:
    case, scenario = grading.cases[number]
    handed_in, problem = _handed_in(grading, paths[place])
    return CaseGrade(case=case, problem=problem) if handed_in is None else _case(grading, case, scenario, handed_in)


_worker: list[tuple[_Grading, Sequence[Path]]] = []  # of a process that grades for another: what it has prepared


def _begin_worker(again: tuple[Any, ...], parent: int) -> None:
    end_with_parent(parent)
    ignore_interrupts()
    _worker[:] = [(_prepare(*again, goes_on=True), again[1])]


def _graded_by_worker(place: int, number: int) -> CaseGrade:
    return _graded(*_worker[0], place, number)


@attrs.frozen(kw_only=True)
class _Grading:
    """The input of a grading, checked.

    `private` is what no submission may read but its own; `linked` are submissions that are links.
    """

    rubric: Rubric
    seeds: Sequence[Seed]
    cases: Sequence[tuple[Case, Scenario]]
    private: Sequence[Path]
    linked: Collection[Path]
    fence: Fence | None


def _prepare(
    path: Path,
    submissions: Sequence[Path],
    out: Path,
    fence: bool,
    seeds: str | os.PathLike[str] | None,
    *,
    goes_on: bool = False,
) -> _Grading:
    """Read and check everything before anything is graded; `StudyError` lists all problems."""
    problems: list[str] = []

    def tried(make: Callable[[], T]) -> T | None:
        try:
            return make()
        except AmorsimError as error:
            if str(error) not in problems:
                problems.append(str(error))
            return None

    if not goes_on:
        tried(lambda: check_free(out))
    rubric = tried(lambda: read_rubric(path))
    drawn = None if seeds is None else tried(lambda: read_seeds(seeds))
    problems += [problem for each in submissions if (problem := _no_submission(each))]
    base = Path(os.path.commonpath([each.absolute().parent for each in (path, *submissions)]))
    linked = {each for each in submissions if leads_through_link(each, base)}
    private = [path, out]
    cases: list[tuple[Case, Scenario]] = []
    if rubric is not None:
        drawn = drawn or list(rubric.seeds) or draw_seeds(rubric.runs)
        private += [Path(each) for each in (rubric.scenario, *rubric.worlds) if each]
        problems += [
            f"{each}: there is no such file, which the rubric gives to submissions"
            for each in rubric.files
            if not is_file(each)
        ]
        for number, (world, seed) in enumerate(itertools.product(rubric.worlds, drawn), start=1):
            case = Case(number=number, seed=seed, world=world)
            scenario = tried(functools.partial(_scenario, rubric, case))
            if scenario is not None:
                cases.append((case, scenario))
    found = tried(lambda: find_fence(private)) if fence else None
    private += [each for each in submissions if each not in linked]
    if problems:
        raise StudyError("\n".join(problems))
    assert rubric is not None
    assert drawn is not None
    return _Grading(rubric=rubric, seeds=drawn, cases=cases, private=private, linked=linked, fence=found)


def _no_submission(path: Path) -> str:
    """Why a path is not a submission; empty if it may be one."""
    if path.is_dir():
        return f"{path}: it is a folder; a submission is a file of Python"
    # A link that leads nowhere is its author's mistake, and not the lecturer's.
    return (
        ""
        if path.is_file() or path.is_symlink()
        else f"{path}: there is no such file; a submission is a file of Python"
    )


def _handed_in(grading: _Grading, path: Path) -> tuple[HandedIn | None, str]:
    """The files of a submission; or None, and the reason."""
    if path in grading.linked:
        return None, "it is a symbolic link, or lies in one, and these are not followed"
    try:
        others = [each for each in grading.private if each != path]
        return hand_in(path, others, grading.rubric.files, grading.rubric.beside), ""
    except (AmorsimError, OSError) as error:
        return None, as_line(str(error))


def _labels(paths: Sequence[Path]) -> list[str]:
    """Different names for submissions, fit for files: their stems, or those of their folders too."""
    stems = [path.stem for path in paths]
    if len(set(stems)) < len(stems):
        stems = [f"{path.absolute().parent.name}-{path.stem}" for path in paths]
    labels: list[str] = []
    for stem in stems:
        plain = re.sub(r"[^\w.+-]+", "_", stem)[:_LONGEST_LABEL]
        same = (f"{plain}-{number}" for number in itertools.count(2))
        # Capital letters are not different ones in some file systems.
        labels.append(
            next(name for name in itertools.chain([plain], same) if name.lower() not in map(str.lower, labels))
        )
    return labels


def _scenario(rubric: Rubric, case: Case) -> Scenario:
    """The scenario of a case; the lecturer's own mistakes are reported before anything is graded."""
    where = f"rubric, {Path(case.world).name}" if case.world else "rubric"
    try:
        scenario = load(rubric.scenario, case.settings)
        simulation = _simulation(scenario, case.seed)
        robot = _robot(rubric, scenario)
        Keeper(simulation, _needs(rubric), 1)
    except AmorsimError as error:
        raise StudyError(f"{where}: {error}") from None
    if robot not in simulation.names:
        raise StudyError(f"rubric: robot: {no_such('robot', robot, simulation.names)}")
    return scenario


def _simulation(scenario: Scenario, seed: Seed) -> Simulation:
    return Simulation(scenario, seed=seed.seed, replicas=[seed.replica])


def _robot(rubric: Rubric, scenario: Scenario) -> str:
    if not rubric.robot and len(scenario.robots) > 1:
        names = ", ".join(robot.name for robot in scenario.robots)
        raise StudyError(f"there are several robots; say whose the submission drives with robot = one of: {names}")
    return rubric.robot or scenario.robots[0].name


def _needs(rubric: Rubric) -> tuple[str, ...]:
    return tuple(dict.fromkeys(name for each in rubric.criteria for name in each.measured.metric.needs()))


def _case(grading: _Grading, case: Case, scenario: Scenario, handed_in: HandedIn) -> CaseGrade:
    """A submission's result in a case; any error costs it this case and no other."""
    try:
        return _run(grading, case, scenario, handed_in)
    except StudyError:  # of the fence
        raise
    except RAISED as error:
        text = str(error) if isinstance(error, AmorsimError) else error_in_words(error)
        return CaseGrade(case=case, problem=as_line(text))


def _run(grading: _Grading, case: Case, scenario: Scenario, handed_in: HandedIn) -> CaseGrade:
    rubric = grading.rubric
    robot = _robot(rubric, scenario)
    remote = Remote(
        handed_in,
        rubric.function,
        rubric.role,
        time_limit=rubric.time_limit,
        memory_limit=rubric.memory_limit,
        fence=grading.fence,
    )
    with remote:
        own = next(iter(next(each for each in scenario.robots if each.name == robot).estimators), "submission")
        change: dict[str, Any] = {"estimators": {own: SubmittedEstimator(remote=remote)}}
        if rubric.role == "controller":
            source = f"{handed_in.name}:{rubric.function}"
            change = {"controller": UserController(source=source, function=remote)}
        robots = [attrs.evolve(each, **change) if each.name == robot else each for each in scenario.robots]
        simulation = _simulation(attrs.evolve(scenario, robots=robots, resolved=None), case.seed)
        steps = simulation.steps_of(scenario.duration if rubric.duration is None else rubric.duration)
        keeper = Keeper(simulation, _needs(rubric), steps + 1)
        keeper.keep()
        for _ in range(steps):
            simulation.step()
            keeper.keep()
        keeper.keep_last()
    values: dict[str, float] = {}
    points: dict[str, float] = {}
    shares: dict[str, float] = {}  # a criterion without points may be one that others are given with
    for each in rubric.criteria:
        measured = each.measured
        episode = episode_at(
            simulation, keeper.arrays, measured.metric.needs(), measured.robot or robot, np.zeros(1, np.int64), steps
        )
        values[each.name] = float(measure_episode(measured, episode)[0])
        is_given = not each.given or shares[each.given] > 0.0
        shares[each.name] = each.share(values[each.name]) if is_given else 0.0
        points[each.name] = each.points * shares[each.name]
    for question in rubric.questions:
        values[question.name] = float(question.is_right(remote.answers))
        points[question.name] = question.points * values[question.name]
    return CaseGrade(case=case, values=values, points=points)
