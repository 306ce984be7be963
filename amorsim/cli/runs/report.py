"""``amorsim report``: one HTML file about a run, a study or a comparison."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from amorsim.cli.console import say

__all__ = ["command"]


def command(
    folder: Annotated[Path, typer.Argument(metavar="FOLDER", help="The folder of a run, a study or a comparison.")],
    out: Annotated[
        Path | None, typer.Option(metavar="FILE", help="The file. [default: report.html, in the folder]")
    ] = None,
) -> None:
    """Write a report: one HTML file with figures, pictures, versions and the command that repeats it.

    It opens offline, and is the same whenever it is made of the same files.
    """
    from amorsim.reports.report import report

    say(str(report(folder, out)))
