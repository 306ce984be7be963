"""``amorsim grade``: points for controllers in files."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from amorsim.cli.console import compile_once, complain, say
from amorsim.cli.progress import case_progress
from amorsim.core.errors import RunError

__all__ = ["command"]


def command(
    rubric: Annotated[Path, typer.Argument(metavar="RUBRIC.toml", help="The file of the rubric.")],
    submissions: Annotated[list[Path], typer.Argument(metavar="SUBMISSION.py ...", help="Files with controllers.")],
    out: Annotated[Path, typer.Option(metavar="DIR", help="Folder of the results, new or empty.")] = Path("grades"),
    seeds: Annotated[
        Path | None, typer.Option(metavar="SEEDS.toml", help="Repeat a grading: the seeds.toml in its folder.")
    ] = None,
    no_fence: Annotated[
        bool, typer.Option("--no-fence", help="Grade without bubblewrap; a submission can do what you can.")
    ] = False,
    gradescope: Annotated[
        Path | None,
        typer.Option("--gradescope", metavar="FILE", help="Also write Gradescope's results.json, of one submission."),
    ] = None,
    jobs: Annotated[int, typer.Option("--jobs", "-j", metavar="N", help="How many processes grade.")] = 1,
    quiet: Annotated[bool, typer.Option("--quiet", "-q", help="Print nothing but errors.")] = False,
) -> None:
    """Grade controllers or estimators, fenced in by bubblewrap, over seeds and worlds that they do not know.

    Writes grades.csv for the lecturer and a page for each submission, as each is finished. One that raises, hangs, ends
    its process or needs too much memory has no points in that run, with the reason. The same command goes on with a
    grading that was interrupted.
    """
    from amorsim.cli.studies.study import table
    from amorsim.grading.grade import grade
    from amorsim.grading.gradescope import write_gradescope
    from amorsim.grading.results import UNFENCED
    from amorsim.grading.rubric import read_rubric

    def look() -> None:
        read_rubric(rubric)

    if gradescope is not None and len(submissions) != 1:
        raise RunError(f"--gradescope is for one submission, got {len(submissions)}")
    compile_once(look, quiet)
    try:
        with case_progress(quiet) as progress:
            found = grade(rubric, submissions, out, fence=not no_fence, seeds=seeds, jobs=jobs, progress=progress)
    except KeyboardInterrupt:
        complain(f"interrupted; what is graded is in {out}. The same command goes on")
        raise typer.Exit(130) from None
    if gradescope is not None:
        write_gradescope(gradescope, rubric, found[0])
    if quiet:
        return
    head, rows = ["submission", "points", "of"], [[each.label, f"{each.total:.2f}", f"{each.of:g}"] for each in found]
    say("\n" + table(head, rows))
    if any(each.fence == UNFENCED for each in found):
        say("\ngraded without a fence: a submission could read and change what you can")
    say(f"\ntable: {out / 'grades.csv'}, and a page for each in {out}")
