"""``amorsim sweep``: a study, from its file to its table."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from amorsim.cli.console import compile_once, complain, say
from amorsim.cli.progress import study_progress

if TYPE_CHECKING:
    from amorsim.sweeps.table import Study

__all__ = ["command"]


def command(
    study: Annotated[Path, typer.Argument(metavar="STUDY.toml", help="The file of a study.")],
    out: Annotated[
        Path | None,
        typer.Option(metavar="DIR", help="Folder of the results. [default: amorsim-runs/<study>]"),
    ] = None,
    jobs: Annotated[int, typer.Option("--jobs", "-j", metavar="N", help="How many processes share the work.")] = 1,
    dask: Annotated[
        str | None,
        typer.Option(metavar="ADDRESS", help="A Dask scheduler that shares the work out, as tcp://host:8786."),
    ] = None,
    keep: Annotated[
        str, typer.Option(metavar="WHICH", help="Points that leave folders of their runs: none, all, or as 0,7,12.")
    ] = "none",
    quiet: Annotated[bool, typer.Option("--quiet", "-q", help="Print nothing but errors.")] = False,
) -> None:
    """Run a scenario over axes, seeds and replicas, measure each, and write one table.

    The same command goes on where it stopped. Results do not depend on the number of processes or machines. The exit
    status is 1 if points failed; the table gives the reasons.
    """
    from amorsim.core.errors import StudyError
    from amorsim.sweeps.read import read_plan

    compile_once(lambda: _look(study), quiet)
    chosen: Any = keep
    if keep not in ("none", "all"):
        try:
            chosen = [int(part) for part in keep.split(",")]
        except ValueError:
            raise StudyError(f"--keep: expected none, all, or numbers of points as 0,7,12, got {keep!r}") from None
    plan = read_plan(study)
    if not quiet:
        count = f"{plan.points} point{'s' if plan.points > 1 else ''} x {len(plan.seeds)} seed"
        say(f"{study}: {count}{'s' if len(plan.seeds) > 1 else ''} x {plan.replicas} replicas")
    from amorsim.sweeps.sweep import sweep

    with study_progress(quiet) as progress:
        found = sweep(study, out, jobs=jobs, dask=dask, keep=chosen, progress=progress)
    if not quiet:
        _report(found)
    if not found.is_complete:
        complain(f"interrupted; {len(found['point'])} rows are done. The same command goes on")
        raise typer.Exit(130)
    if found.failures:
        raise typer.Exit(1)


def _look(study: Path) -> None:
    from amorsim.scenario.reading.read import check_words
    from amorsim.sweeps.read import read_plan

    check_words(read_plan(study).scenario)


def _report(found: Study) -> None:
    import numpy as np

    from amorsim.cli.studies.study import table
    from amorsim.render.words import significant
    from amorsim.sweeps.table import counted

    points, first = np.unique(found["point"], return_index=True)
    shown = points[:20]
    head = ["point", *found.axes, *(f"{name} {_unit(found, name)}".strip() for name in found.metrics)]
    rows = []
    for point, row in zip(shown.tolist(), first.tolist(), strict=False):
        of = found["point"] == point
        cells = [str(point), *(str(found[axis][row]) for axis in found.axes)]
        for name in found.metrics:
            values = found[name][of]
            there = values[~np.isnan(values)]
            cells.append(counted(significant(float(np.mean(there))), values) if len(there) else "-")
        rows.append(cells)
    say("means over replicas and seeds:")
    say(table(head, rows))
    if len(points) > len(shown):
        say(f"... and {len(points) - len(shown)} more")
    for point, error in found.failures[:10]:
        complain(f"point {point} failed: {error}")
    where = next(found.folder.glob("table.*"), found.folder)
    say(f"{len(found['point'])} rows: {where}")


def _unit(found: Study, name: str) -> str:
    unit = found.about["metrics"][name]["unit"]
    return f"[{unit}]" if unit else ""
