"""Arguments and options that several commands take, each with the same words everywhere."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

__all__ = ["Changes", "Duration", "Played", "Resolution", "RobotName", "RunFolder", "Seed", "Studied"]

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
