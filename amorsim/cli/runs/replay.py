"""``amorsim replay``: a recorded run in the Simulator's window, or as a film."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from amorsim.cli.console import complain, say
from amorsim.cli.films import Force, Gif, GifRate, GifSize, GifSpeed, Mp4, Wanted, in_options
from amorsim.cli.options import Host, Lecture, Opened, Port, RunFolder, check_port

__all__ = ["command"]


def command(
    folder: RunFolder,
    port: Port = 0,
    host: Host = "127.0.0.1",
    open_: Opened = True,
    lecture: Lecture = False,
    gif: Gif = None,
    mp4: Mp4 = None,
    gif_size: GifSize = Wanted.SIZE,
    gif_rate: GifRate = Wanted.RATE,
    gif_speed: GifSpeed = None,
    force: Force = False,
    replica: Annotated[
        int | None, typer.Option(metavar="N", help="Of moving pictures: the number of another replica.")
    ] = None,
) -> None:
    """Open a recorded run in the Simulator: its time line, events and beliefs. Nothing is simulated.

    The address is printed on a separate line and works once; then a new one is printed, for another browser. Ctrl-C
    ends it. A run that was broken off can be shown too, up to its last complete line. With --gif or --mp4 the run
    becomes a moving picture instead, and no window opens.
    """
    from amorsim.core.errors import AmorsimError
    from amorsim.runs.manifest import read_about

    wanted = Wanted(gif=gif, mp4=mp4, size=gif_size, rate=gif_rate, speed=gif_speed, force=force)
    wanted.check()
    if wanted.files:
        _film(folder, wanted, replica)
        return
    if replica is not None:
        raise AmorsimError("--replica: is for --gif and --mp4; in the window, This run lets you choose one")
    from amorsim.ui.simulator.recipe import Recipe
    from amorsim.ui.simulator.show import check_extra, show

    check_extra()
    check_port(port)
    read_about(folder, needs_truth=False)  # complains before anything is started
    recipe = Recipe(name=str(folder.resolve()), is_recorded=True)
    show(
        recipe,
        out=None,
        host=host,
        port=port,
        browser=open_,
        say=say,
        complain=complain,
        notice=say,
        lecture=lecture,
    )


def _film(folder: Path, wanted: Wanted, replica: int | None) -> None:
    from amorsim.ui.simulator.sources.recorded_film import film_recorded

    for kind, file in wanted.files.items():
        with in_options():
            film_recorded(folder, file, replica=replica, noted=complain, **wanted.settings(kind))
        say(f"moving picture: {file}")
