"""``amorsim grade``: points for controllers in files."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from amorsim.cli.console import compile_once, say

__all__ = ["command"]


def command(
    rubric: Annotated[Path, typer.Argument(metavar="RUBRIC.toml", help="The file of the rubric.")],
    submissions: Annotated[list[Path], typer.Argument(metavar="SUBMISSION.py ...", help="Files with controllers.")],
    out: Annotated[Path, typer.Option(metavar="DIR", help="Folder of the results, new or empty.")] = Path("grades"),
    quiet: Annotated[bool, typer.Option("--quiet", "-q", help="Print nothing but errors.")] = False,
) -> None:
    """Grade controllers: over held-out seeds and worlds, each in a process of its own that knows no truth.

    Writes grades.csv for the lecturer and a page for each submission, as each is finished. One that raises, hangs, ends
    its process or needs too much memory has no points in that run, with the reason.
    """
    from amorsim.cli.study import table
    from amorsim.grading.grade import grade
    from amorsim.grading.rubric import read_rubric
    from amorsim.runs.folder import check_free

    check_free(out)
    read = read_rubric(rubric)
    compile_once(lambda: None, quiet)
    found = grade(rubric, submissions, out, progress=None if quiet else say)
    if not quiet:
        rows = [[each.label, f"{each.total:.2f}", f"{read.points:g}"] for each in found]
        say("\n" + table(["submission", "points", "of"], rows))
        say(f"\ntable: {out / 'grades.csv'}, and a page for each in {out}")
