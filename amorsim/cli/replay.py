"""``amorsim replay``: a recorded run in the Simulator's window."""

from __future__ import annotations

from amorsim.cli.console import complain, say
from amorsim.cli.options import Host, Opened, Port, RunFolder, check_port

__all__ = ["command"]


def command(
    folder: RunFolder,
    port: Port = 0,
    host: Host = "127.0.0.1",
    open_: Opened = True,
) -> None:
    """Open a recorded run in the Simulator: its time line, events and beliefs. Nothing is simulated.

    The address is printed on a separate line and works once; then a new one is printed, for another browser. Ctrl-C
    ends it. A run that was broken off can be shown too, up to its last complete line.
    """
    from amorsim.runs.about import read_about
    from amorsim.ui.simulator.recipe import Recipe
    from amorsim.ui.simulator.show import check_extra, show

    check_extra()
    check_port(port)
    read_about(folder)  # complains before anything is started
    recipe = Recipe(name=str(folder.resolve()), is_recorded=True)
    show(recipe, out=None, host=host, port=port, browser=open_, say=say, complain=complain, notice=say)
