"""``amorsim export``: a run's results in the formats of other programs."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from amorsim.cli.console import say
from amorsim.cli.options import RunFolder

__all__ = ["command"]


def command(
    folder: RunFolder,
    to: Annotated[str, typer.Option(metavar="FORMAT", help="tum, kitti, csv, parquet, mcap or rosbag.")],
    out: Annotated[
        Path | None, typer.Option(metavar="DIR", help="Folder for the files. [default: export, in the run's folder]")
    ] = None,
) -> None:
    """Write a run's results in another format.

    tum, kitti and csv are trajectories, true and estimated; parquet has all tables; mcap opens in Foxglove; rosbag is a
    rosbag2, for ROS 2.
    """
    from amorsim.analysis.export import export_run

    for path in export_run(folder, to, out):
        say(str(path))
