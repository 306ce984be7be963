"""``amorsim view``: the Simulator's window, in the browser."""

from __future__ import annotations

import contextlib
import gc
import importlib.util
import os
import sys
import threading
import webbrowser
from pathlib import Path
from typing import Annotated

import typer

from amorsim.cli.console import compile_once, complain, say

__all__ = ["command"]

LONGEST_REST = 0.5  # [s] that the server gets to end once the simulation has


def command(
    scenario: Annotated[
        str,
        typer.Argument(
            metavar="SCENARIO",
            help="A scenario file (.toml), the name of a bundled scenario (such as demo), or a map alone (such as "
            "lab.wld or plan.bmp), in which a Pioneer 2DX then wanders.",
        ),
    ],
    out: Annotated[
        Path | None,
        typer.Option(metavar="DIR", help="Folder that the run is written into as it goes, new or empty."),
    ] = None,
    port: Annotated[int, typer.Option(metavar="N", help="Port to serve the window on; 0 takes one that is free.")] = 0,
    host: Annotated[
        str,
        typer.Option(
            metavar="ADDRESS", help="Address to serve the window on; only this machine can reach the default."
        ),
    ] = "127.0.0.1",
    open_: Annotated[bool, typer.Option("--open/--no-open", help="Whether to open the window in the browser.")] = True,
    seed: Annotated[
        int | None, typer.Option(metavar="N", help="Seed of all random draws, in place of the scenario's.")
    ] = None,
    duration: Annotated[
        float | None, typer.Option(metavar="SECONDS", help="Simulated time, in place of the scenario's.")
    ] = None,
    resolution: Annotated[
        float | None,
        typer.Option(metavar="METRES", help="For a map alone: the side of a cell (of a picture: of a pixel)."),
    ] = None,
    changes: Annotated[
        list[str] | None,
        typer.Option(
            "--set",
            metavar="KEY=VALUE",
            help="Change a value of the scenario, as in robots.0.errors.drive.track.scale=1.02; may be given again.",
        ),
    ] = None,
) -> None:
    """Open the Simulator in the browser: what is true beside what the robot knows.

    Its address is printed on a line of its own; whoever has it, token included, can drive. Ctrl-C ends it, with the
    files of --out whole. What is saved in the window goes into the present folder.
    """
    from amorsim.core.errors import AmorsimError

    if importlib.util.find_spec("nicegui") is None:
        raise AmorsimError('the window needs the extra "ui"; install it with: pip install "amorsim[ui]"')
    if not 0 <= port < 65536:
        raise AmorsimError(f"--port: expected a whole number from 0 to 65535, got {port}")

    from amorsim.runs.asked import look_up
    from amorsim.ui.recipe import Recipe
    from amorsim.ui.server import serve
    from amorsim.ui.session import Session

    look_up(scenario)
    cold = compile_once()
    recipe = Recipe(name=scenario, resolution=resolution, changes=changes or (), seed=seed, duration=duration)
    # What no run has needed yet (a camera's kernels ...) is compiled later: that is told when it takes long.
    session = Session(recipe, out=out, notice=None if cold else say)
    told = threading.Lock()  # the last word, once

    def tell() -> None:
        if told.acquire(blocking=False) and session.folder:
            say(f"results: {session.folder}")

    def leave() -> None:
        tell()
        sys.stdout.flush()
        os._exit(0)

    def end() -> None:
        session.close()
        # The files are whole. What the server still does (a GIF that is being made) shall not hold up the end.
        rest = threading.Timer(LONGEST_REST, leave)
        rest.daemon = True
        rest.start()

    try:
        session.start()
        for remark in session.remarks:
            complain(remark)

        def ready(address: str) -> None:
            say(address)
            if open_:
                # Some browsers hold up whoever opens them.
                threading.Thread(target=webbrowser.open, args=(address,), daemon=True).start()

        with contextlib.suppress(KeyboardInterrupt):
            serve(session, host=host, port=port, ready=ready, ending=end)
    finally:
        session.close()
        # Python's last look for what nobody uses takes a second with all that NiceGUI and numba hold.
        gc.freeze()
    tell()
