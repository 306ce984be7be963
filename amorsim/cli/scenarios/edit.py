"""``amorsim edit``: the Editor's window, in the browser."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from amorsim.cli.console import complain, say
from amorsim.cli.options import Host, Opened, Port, check_port

__all__ = ["command"]


def command(
    scenario: Annotated[
        str,
        typer.Argument(
            metavar="[SCENARIO]",
            help="A scenario's file, faulty or not, a bundled scenario, or a map or another program's file, for which "
            "a new scenario is made.",
        ),
    ] = "",
    port: Port = 0,
    host: Host = "127.0.0.1",
    open_: Opened = True,
    allow_code: Annotated[
        bool,
        typer.Option("--allow-code", help="With another --host: also run scenarios that have components in files."),
    ] = False,
) -> None:
    """Open the Editor in the browser: draw a world, place robots and other things, and run it.

    Without a scenario it begins with an empty page. A bundled scenario is copied, and the copy is saved in the current
    folder. The address is printed on a separate line and works once; then a new one is printed, for another browser.
    Ctrl-C ends the Editor.
    """
    from amorsim.ui.simulator.show import check_extra

    check_extra()
    check_port(port)

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
