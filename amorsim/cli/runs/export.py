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
    to: Annotated[str, typer.Option(metavar="FORMAT", help="html, tum, kitti, csv, parquet, mcap or rosbag.")],
    out: Annotated[
        Path | None, typer.Option(metavar="DIR", help="Folder for the files. [default: export, in the run's folder]")
    ] = None,
    replica: Annotated[int | None, typer.Option(metavar="N", help="Of html: the number of another replica.")] = None,
) -> None:
    """Write a run's results in another format.

    html is a page that plays the run in any browser, without amorsim. tum, kitti and csv are trajectories, true and
    estimated; parquet has all tables; mcap opens in Foxglove; rosbag is a rosbag2, for ROS 2.
    """
    if to == "html":
        from amorsim.ui.run_page.html_file import run_page

        if out is not None:
            _make(out)
        say(str(run_page(folder, out and out / f"{folder.resolve().name}.html", replica=replica)))
        return
    from amorsim.analysis.export import FORMATS, export_run
    from amorsim.core.errors import AmorsimError

    if replica is not None:
        raise AmorsimError("--replica: is for --to html; the other formats have all replicas, or the first")
    if to not in FORMATS:
        raise AmorsimError(f"--to: expected html, {', '.join(FORMATS)}; got {to!r}")
    for path in export_run(folder, to, out):
        say(str(path))


def _make(folder: Path) -> None:
    from amorsim.core.errors import AmorsimError

    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise AmorsimError(f"--out: {folder} cannot be made: {error.strerror}") from None
