"""``amorsim edit``: the Editor's window, in the browser."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from amorsim.cli.console import complain, say

__all__ = ["command"]


def command(
    scenario: Annotated[
        str, typer.Argument(metavar="[SCENARIO]", help="A scenario's file, faulty or not, or a bundled scenario.")
    ] = "",
    port: Annotated[int, typer.Option(metavar="N", help="Port to serve the window on; 0 takes one that is free.")] = 0,
    host: Annotated[
        str,
        typer.Option(
            metavar="ADDRESS",
            help="Address to serve the window on; only this machine can reach the default. Nothing is encrypted.",
        ),
    ] = "127.0.0.1",
    open_: Annotated[bool, typer.Option("--open/--no-open", help="Whether to open the window in the browser.")] = True,
    allow_code: Annotated[
        bool,
        typer.Option(
            "--allow-code", help="With another --host: let scenarios run that have programs of their own all the same."
        ),
    ] = False,
) -> None:
    """Open the Editor in the browser: draw a world, place robots and other things, and run it.

    Without a scenario it begins with an empty page. Of a bundled scenario, a copy is edited, which is saved in the
    present folder. The address is printed on a line of its own, and works once; then another one is printed, for
    another browser. Ctrl-C ends it.
    """
    from amorsim.core.errors import AmorsimError
    from amorsim.ui.simulator.show import check_extra

    check_extra()
    if not 0 <= port < 65536:
        raise AmorsimError(f"--port: expected a whole number from 0 to 65535, got {port}")

    from amorsim.ui.editor.show import edit

    edit(
        scenario,
        host=host,
        port=port,
        browser=open_,
        allow_code=allow_code,
        say=say,
        complain=complain,
        folder=Path.cwd(),
    )
