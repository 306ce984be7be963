"""``amorsim view``: the Simulator's window, in the browser."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from amorsim.cli.console import compile_once, complain, say
from amorsim.cli.options import Changes, Duration, Host, Lecture, Opened, Played, Port, Resolution, Seed, check_port

__all__ = ["command"]


def command(
    scenario: Played,
    out: Annotated[
        Path | None,
        typer.Option(metavar="DIR", help="Folder that the run is written into as it goes, new or empty."),
    ] = None,
    port: Port = 0,
    host: Host = "127.0.0.1",
    open_: Opened = True,
    lecture: Lecture = False,
    seed: Seed = None,
    duration: Duration = None,
    resolution: Resolution = None,
    changes: Changes = None,
) -> None:
    """Open the Simulator in the browser: what is true next to what the robot knows.

    The address is printed on a separate line. It works once, for anyone who has all of it; then a new one is printed,
    for another browser. Ctrl-C ends the Simulator; the files of --out are complete up to then. What you save in the
    window goes into the current folder. If the scenario file has faults, the window shows them until you mend it.
    """
    from amorsim.core.errors import ScenarioError
    from amorsim.ui.faults.shown_faults import FaultsError, lines_of
    from amorsim.ui.simulator.show import can_be_mended, check_extra, show

    check_extra()
    check_port(port)

    from amorsim.runs.folder import check_free
    from amorsim.runs.scenario_argument import look_up
    from amorsim.ui.simulator.recipe import Recipe

    check_free(out)
    recipe = Recipe(name=scenario, resolution=resolution, changes=changes or (), seed=seed, duration=duration)
    known = None
    try:
        cold = compile_once(
            lambda: look_up(scenario, resolution=resolution, changes=recipe.changes, seed=seed, duration=duration)
        )
    except ScenarioError as error:  # to see that, nothing needs to be compiled
        cold, known = False, FaultsError(str(error), lines_of(error))
        if not can_be_mended(recipe, known.faults):
            raise
    # Kernels that no run has needed yet (a camera's ...) are compiled later, with a message if that takes long.
    notice = None if cold else say
    was_open = show(
        recipe,
        out=out,
        host=host,
        port=port,
        browser=open_,
        say=say,
        complain=complain,
        notice=notice,
        known=known,
        lecture=lecture,
    )
    if not was_open:
        raise typer.Exit(2)
