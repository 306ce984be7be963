"""``amorsim plot``: the pictures of a run, from its files."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from amorsim.cli.console import complain, say
from amorsim.cli.options import RobotName, RunFolder
from amorsim.core.errors import AmorsimError

__all__ = ["command"]


def command(
    folder: RunFolder,
    out: Annotated[
        Path | None, typer.Option(metavar="DIR", help="Folder for the pictures. [default: plots, in the run's folder]")
    ] = None,
    robot: RobotName = None,
    replica: Annotated[
        int | None, typer.Option(metavar="N", help="Which replica. [default: all of them together]")
    ] = None,
) -> None:
    """Draw a run: path, speeds, wheels, heading and every sensor; a colour each for true, measured, estimated.

    Of several replicas it draws all together, unless one is named. Files and titles name run, robot and seed.
    """
    try:
        from amorsim.analysis.plots.plot import plot_run, unfinished
        from amorsim.analysis.run_files import RunFiles
    except ModuleNotFoundError as error:
        if (error.name or "").partition(".")[0] != "matplotlib":
            raise
        raise AmorsimError('plots need matplotlib: python -m pip install "amorsim[plot]"') from None
    if ending := unfinished(RunFiles(folder)):
        complain(f"{folder}: this run {ending}")
    for path in plot_run(folder, out=out, robot=robot, replica=replica):
        say(str(path))
