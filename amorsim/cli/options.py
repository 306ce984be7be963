"""Arguments and options that several commands take, each with the same words everywhere."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

__all__ = [
    "Changes",
    "Duration",
    "Host",
    "Opened",
    "Played",
    "Port",
    "Resolution",
    "RobotName",
    "RunFolder",
    "Seed",
    "Studied",
    "check_port",
]

Played = Annotated[
    str,
    typer.Argument(
        metavar="SCENARIO",
        help="A scenario file (.toml), the name of a bundled scenario (such as demo), another program's file (.world "
        "of Stage, .map of MobileSim), or a map alone (such as lab.wld or plan.bmp), where a Pioneer 2DX then wanders.",
    ),
]
Studied = Annotated[
    str,
    typer.Argument(metavar="SCENARIO", help="A scenario file (.toml), the name of a bundled one, or a map alone."),
]
Changes = Annotated[
    list[str] | None,
    typer.Option(
        "--set",
        metavar="KEY=VALUE",
        help="Change a value of the scenario, as in robots.0.errors.drive.track.scale=1.02; may be given again. "
        "`amorsim check SCENARIO --resolved` prints all there are.",
    ),
]
Seed = Annotated[int | None, typer.Option(metavar="N", help="Seed of all random draws, in place of the scenario's.")]
Duration = Annotated[float | None, typer.Option(metavar="SECONDS", help="Simulated time, in place of the scenario's.")]
Resolution = Annotated[
    float | None,
    typer.Option(metavar="METRES", help="For a map alone: the side of a cell (of a picture: of a pixel)."),
]
RobotName = Annotated[str | None, typer.Option(metavar="NAME", help="Which robot. [default: the first]")]
RunFolder = Annotated[Path, typer.Argument(metavar="FOLDER", help="The folder of a run.")]
Port = Annotated[int, typer.Option(metavar="N", help="Port to serve the window on; 0 takes one that is free.")]
Host = Annotated[
    str,
    typer.Option(
        metavar="ADDRESS",
        help="Address to serve the window on; only this machine can reach the default. Nothing is encrypted.",
    ),
]
Lecture = Annotated[bool, typer.Option("--lecture", help="Open it large, for a class: two panes and a plot.")]
Opened = Annotated[bool, typer.Option("--open/--no-open", help="Whether to open the window in the browser.")]


def check_port(port: int) -> None:
    """Raise an error for a port that there cannot be."""
    from amorsim.core.errors import AmorsimError

    if not 0 <= port < 65536:
        raise AmorsimError(f"--port: expected a whole number from 0 to 65535, got {port}")
