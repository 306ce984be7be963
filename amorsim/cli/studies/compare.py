"""``amorsim compare``: two or more systems, or estimators, on the same seeds, worlds and noise."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import attrs
import typer

from amorsim.cli.console import compile_once, complain, say
from amorsim.cli.progress import study_progress
from amorsim.core.files.reading import is_file
from amorsim.render.words import rounded, significant, with_interval

if TYPE_CHECKING:
    from amorsim.analysis.differences import Comparison
    from amorsim.sweeps.study_set import StudySet
    from amorsim.sweeps.table import Study

__all__ = ["command"]


def command(
    systems: Annotated[
        list[str],
        typer.Argument(
            metavar="A B ...",
            help="Scenarios, which are then simulated, or folders of studies. Of one alone: its estimators.",
        ),
    ],
    axis: Annotated[
        str | None, typer.Option(metavar="NAME", help="Of one study: compare the values of this axis.")
    ] = None,
    metric: Annotated[
        list[str] | None,
        typer.Option(
            metavar="NAME",
            help="Which metric; may be given again. [default: all of the studies; position_error for scenarios]",
        ),
    ] = None,
    estimator: Annotated[
        list[str] | None,
        typer.Option(
            metavar="NAME",
            help="Whose estimates; may be given again. [default: all estimators that the systems share]",
        ),
    ] = None,
    robot: Annotated[
        str, typer.Option(metavar="NAME", help="Of scenarios: which robot, where there are several.")
    ] = "",
    replicas: Annotated[int, typer.Option(metavar="N", help="Of scenarios: how many replicas of each.")] = 100,
    seeds: Annotated[str, typer.Option(metavar="N,N", help="Of scenarios: the seeds, the same for all.")] = "1",
    duration: Annotated[float | None, typer.Option(metavar="SECONDS", help="Of scenarios: simulated time.")] = None,
    jobs: Annotated[int, typer.Option("--jobs", "-j", metavar="N", help="Of scenarios: how many processes.")] = 1,
    out: Annotated[
        Path | None,
        typer.Option(metavar="DIR", help="Folder for what is found. [default: amorsim-runs/comparison-<number>]"),
    ] = None,
) -> None:
    """Compare systems, or the estimators of one, on the same seeds, worlds and noise; print what may be claimed.

    Draws depend on seed, replica and names alone, so each system meets the same noise: differences are taken pair by
    pair. Intervals and p-values are those of the mean difference, corrected for the number of differences (Holm).
    Ctrl-C keeps what was simulated; the same command goes on where it stopped.
    """
    from amorsim.analysis.comparison import compare
    from amorsim.runs.folder import check_free, new_folder

    are_studies = [is_file(Path(name) / "study.json") for name in systems]
    if not any(are_studies) and axis is None:
        several = _several(systems, metric or ["position_error"], estimator or [], robot, replicas, seeds, duration)
        studies = _simulated(several, jobs, out)
        folder = studies[0].folder.parent
        found = compare(*studies, labels=[study.folder.name for study in studies])
        found = attrs.evolve(found, origin={**found.origin, "command": several.command})
    else:
        check_free(out)
        found = compare(*systems, axis=axis, metrics=metric or (), estimators=estimator or ())
        folder = out or new_folder("comparison")
        folder.mkdir(parents=True, exist_ok=True)
    _report(found)
    made = found.save(folder)
    if picture := _draw(found, folder):
        made.append(picture)
    say("\n" + ", ".join(map(str, made)))


def _several(
    systems: list[str],
    metrics: list[str],
    estimators: list[str],
    robot: str,
    replicas: int,
    seeds: str,
    duration: float | None,
) -> StudySet:
    """The scenarios that a user wants to simulate and compare."""
    from amorsim.core.errors import AnalysisError
    from amorsim.runs.scenario_argument import look_up
    from amorsim.sweeps.study_set import StudySet

    try:
        numbers = tuple(int(part) for part in seeds.split(","))
    except ValueError:
        raise AnalysisError(f"--seeds: expected whole numbers, as 1,2,3, got {seeds!r}") from None
    for name in systems:
        look_up(name)
    compile_once(lambda: None)
    several = StudySet(
        scenarios=tuple(systems),
        metrics=tuple(metrics),
        estimators=tuple(estimators),
        robot=robot,
        replicas=replicas,
        seeds=numbers,
        duration=duration,
    )
    if len(systems) == 1 and len(several.measured) < 2:
        raise AnalysisError(
            f"{systems[0]}: one scenario alone is compared by its estimators, and these metrics judge one only: "
            f"{', '.join(several.measured)}. Name another scenario, or one with several estimators"
        )
    return several


def _simulated(several: StudySet, jobs: int, out: Path | None) -> list[Study]:
    """The study of each scenario, with the same seeds and replicas; continues what was begun before."""
    from amorsim.analysis.differences import ABOUT
    from amorsim.core.errors import AnalysisError

    folder = several.folder(out, "comparison", ended=ABOUT)
    studies = []
    for place, label in enumerate(several.labels):
        say(f"{label}: {len(several.seeds)} x {several.replicas} replicas")
        with study_progress() as progress:
            study = several.sweep(place, folder, jobs=jobs, progress=progress)
        if not study.is_complete:
            complain(f"interrupted; what is done is in {folder}. The same command goes on")
            raise typer.Exit(130)
        for _, error in study.failures[:1]:
            raise AnalysisError(f"{label}: {error}")
        studies.append(study)
    return studies


def _report(found: Comparison) -> None:
    from amorsim.analysis.differences import metric_of_estimator, p_in_words
    from amorsim.cli.studies.study import table

    head = ["metric", "system", "mean", "95 % from", "to", "median", "values"]
    rows = []
    for system in found.summaries:
        figures = with_interval(system.mean, system.low, system.high)
        median = rounded(system.median, 0.5 * (system.high - system.low))
        what = metric_of_estimator(system.metric, system.estimator) + (f" [{system.unit}]" if system.unit else "")
        rows.append([what, system.label, *figures, median, str(system.count)])
    say(table(head, rows))
    head = ["difference", "of", "mean", "95 % from", "to", "unpaired from", "to", "p (Holm)", "d", "gain of pairing"]
    rows = []
    for each in found.differences:
        _, *unpaired = with_interval(each.mean, each.unpaired_low, each.unpaired_high)
        rows.append(
            [
                f"{each.second} - {each.first}",
                metric_of_estimator(each.metric, each.estimator),
                *with_interval(each.mean, each.low, each.high),
                *unpaired,
                p_in_words(each.p_corrected).removeprefix("= "),
                f"{each.effect:.2f}",
                significant(each.gain, 2),
            ]
        )
    say("\n" + table(head, rows) + "\n")
    for each in found.differences:
        say(str(each))
    for each in found.differences:
        if each.left_out:
            complain(f"{each.metric}: {each.left_out} pairs of {each.first} and {each.second} have no value")


def _draw(found: Comparison, folder: Path) -> Path | None:
    try:
        from amorsim.analysis.plots.comparison_plots import draw_comparison
        from amorsim.analysis.plots.figures import save_figure
    except ModuleNotFoundError as error:
        if (error.name or "").partition(".")[0] != "matplotlib":
            raise
        complain('comparison.png is left out: plots need matplotlib: python -m pip install "amorsim[plot]"')
        return None
    path = folder / "comparison.png"
    save_figure(draw_comparison(found), path, dpi=110, within=folder)
    return path
