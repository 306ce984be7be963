"""A study, from its file to its table."""

from __future__ import annotations

import contextlib
import os
import time
from collections.abc import Callable, Collection, Iterator, Mapping
from pathlib import Path
from typing import Any, NamedTuple

from amorsim.core.arguments import path_of, whole
from amorsim.core.error_text import in_words
from amorsim.core.errors import AmorsimError, StudyError
from amorsim.core.execution.progress import progress_shown
from amorsim.core.parameters import ParameterError
from amorsim.runs.folder import RUNS
from amorsim.scenario.reading.read import load
from amorsim.scenario.spec import Scenario
from amorsim.simulation.kept_quantities import Keeper
from amorsim.simulation.simulation import Simulation
from amorsim.sweeps.chunk import Outcome, quantities, robot_of, with_metrics
from amorsim.sweeps.executors import Work, check_cluster, in_processes, in_this_process, on_cluster
from amorsim.sweeps.folder import StudyFolder
from amorsim.sweeps.plan import Axis, Plan
from amorsim.sweeps.read import read_plan
from amorsim.sweeps.table import Study, read_study, write_tables

__all__ = ["Progress", "sweep"]

_TRIES = 20  # values of an axis that are tried beforehand


class Progress(NamedTuple):
    """The progress of a study: finished and failed chunks, of how many, and the time left [s] or None."""

    done: int
    total: int
    failed: int
    left: float | None


def sweep(
    study: str | os.PathLike[str] | Mapping[str, Any],
    out: str | os.PathLike[str] | None = None,
    *,
    jobs: int = 1,
    dask: Any = None,
    keep: str | Collection[int] = "none",
    progress: bool | Callable[[Progress], None] | None = True,
) -> Study:
    """Run a study: its scenario at every point of its axes, in all replicas and for all seeds; measure, and tabulate.

    The same call again goes on where it stopped; results do not depend on where and how they were computed. Ctrl-C
    ends it with what is done: the table then has that, and `Study.is_complete` is false.

    Parameters
    ----------
    study
        The path of its file, or its tables.
    out
        The folder, new or of this study; without it, ``amorsim-runs/<study>``.
    jobs
        The number of processes.
    dask
        The address of a Dask scheduler, or a client, in place of `jobs`. Workers must find the study's files under the
        same paths.
    keep
        Which points leave the folders of their runs in ``runs``: ``"none"``, ``"all"``, or their numbers. Those that
        were done without are computed again, with the same results.
    progress
        Whether a bar is shown after two seconds, in a terminal or a notebook; or a function that is called at the
        beginning and after every chunk.

    Raises
    ------
    StudyError
        If the study is not right, the folder is another's, a file cannot be written, or a cluster goes away. What was
        done stays. A point that fails is not an error: its rows have the reason.
    """
    plan = read_plan(study)
    try:
        jobs = whole(jobs, "jobs", "a number of processes >= 1", least=1)
        path = Path(RUNS) / plan.name if out is None else path_of(out, "out")
    except ParameterError as error:
        raise StudyError(str(error)) from None
    if dask is not None:
        check_cluster(dask)
    kept = _kept(keep, plan)
    measured = with_metrics(plan)  # other processes load them themselves
    scenario = _checked(measured)
    folder = StudyFolder(path, measured, scenario)
    missing = folder.missing(kept)
    folder.forget_begun()

    def work_of(index: int) -> Work:
        run = folder.run_folder(index).absolute() if plan.chunk(index).point in kept else ""
        return Work(index=index, begun=str(folder.marker(index).absolute()), folder=str(run))

    status, begun, done, failed = "interrupted", time.monotonic(), plan.chunks - len(missing), 0
    with progress_shown(progress, "simulating", lambda now: now.done / now.total) as show:
        if show is not None:
            show(Progress(done, plan.chunks, failed, None))
        outcomes: Iterator[Outcome]
        if dask is not None:
            outcomes = on_cluster(plan, missing, work_of, dask)
        elif jobs > 1:
            outcomes = in_processes(plan, missing, work_of, jobs)
        else:
            outcomes = in_this_process(plan, missing, work_of)
        try:
            for count, outcome in enumerate(outcomes, start=1):
                folder.write(outcome)
                failed += bool(outcome.error)
                left = (time.monotonic() - begun) / count * (len(missing) - count)
                if show is not None:
                    show(Progress(done + count, plan.chunks, failed, left))
            status = "finished"
        except KeyboardInterrupt:
            pass
        except StudyError as error:
            error.add_note(f"what was done is in {folder.path}; the same command goes on")
            with contextlib.suppress(AmorsimError):  # the first error is the one to report
                _end(folder, plan, scenario, status)
            raise
        finally:
            outcomes.close()  # type: ignore[attr-defined]
    _end(folder, plan, scenario, status)
    return read_study(folder.path)


def _end(folder: StudyFolder, plan: Plan, scenario: Scenario, status: str) -> None:
    """Write the table of the finished chunks, and how the study ended."""
    write_tables(folder.path, plan, scenario.seed, folder.outcomes())
    folder.write_about(status)


def _kept(keep: str | Collection[int], plan: Plan) -> Collection[int]:
    if isinstance(keep, str) and keep in ("none", "all"):
        return range(plan.points) if keep == "all" else ()
    expected = f"'none', 'all', or numbers of points below {plan.points}"
    try:
        points = [whole(point, "keep", expected) for point in keep]
    except (TypeError, ParameterError):
        points = [plan.points]
    if max(points, default=0) >= plan.points:
        raise StudyError(f"keep: expected {expected}, got {in_words(keep)}")
    return frozenset(points)


# --------------------------------------------------------------------------------------------------------- beforehand


def _checked(plan: Plan) -> Scenario:
    """The scenario without the axes, after a check of all that the study names.

    An axis none of whose values can be set names nothing; so does a metric that fits none of the points looked at. A
    single value that cannot be set is a point that fails.
    """
    try:
        scenario = load(plan.scenario)
    except AmorsimError as error:
        raise StudyError(f"scenario: {error}") from None
    problems: list[AmorsimError] = []
    try:
        simulations = [_tried(plan, axis, scenario) for axis in plan.axes] or [_simulated(plan, {})]
    except StudyError:
        raise
    except AmorsimError as error:
        raise StudyError(f"scenario: {error}") from None
    for simulation in simulations:
        try:
            _check_metrics(plan, simulation)
        except AmorsimError as error:
            problems.append(error)
    if len(problems) == len(simulations):
        raise problems[0] if isinstance(problems[0], StudyError) else StudyError(f"metrics: {problems[0]}")
    return scenario


def _tried(plan: Plan, axis: Axis, scenario: Scenario) -> Simulation:
    """A simulation with one value of an axis; of one that changes the scenario, if any can be set."""
    problem: AmorsimError | None = None
    neutral = None
    places = range(min(len(axis), _TRIES))
    for place in places:
        try:
            simulation = _simulated(plan, {axis.name: place})
        except AmorsimError as error:
            problem = problem or error
            continue
        # A default may be set for anything, also for what there is not: it is left out.
        if simulation.scenario.resolved != scenario.resolved:
            return simulation
        neutral = simulation
    if neutral is not None and problem is None:
        return neutral
    firsts = {each.name: 0 for each in plan.axes}
    for place in places if neutral is None and len(plan.axes) > 1 else ():
        with contextlib.suppress(AmorsimError):  # it may need what another axis sets
            return _simulated(plan, {**firsts, axis.name: place})
    which = "" if neutral is None else " that would change the scenario"
    raise StudyError(f"no value of this axis{which} can be set: {problem}")


def _simulated(plan: Plan, places: Mapping[str, int]) -> Simulation:
    seed = None if plan.seeds[0] < 0 else plan.seeds[0]
    return Simulation(load(plan.scenario, tuple(plan.settings_of(places))), seed=seed, replicas=[0])


def _check_metrics(plan: Plan, simulation: Simulation) -> None:
    for each in plan.metrics:
        robot_of(each, simulation.names)
    Keeper(simulation, quantities(plan), 1)
