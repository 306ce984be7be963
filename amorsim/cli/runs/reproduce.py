"""``amorsim reproduce``: run a finished run again and compare."""

from __future__ import annotations

from typing import Annotated

import typer

from amorsim.cli.console import say
from amorsim.cli.options import RunFolder

__all__ = ["command"]


def command(
    folder: RunFolder,
    quiet: Annotated[bool, typer.Option("--quiet", "-q", help="Print nothing; the exit status says it.")] = False,
) -> None:
    """Repeat a run from its folder, and compare all exact results.

    The exit status is 0 if they are the same to the bit, else 1; then the first difference is named.
    """
    from amorsim.runs.reproduce import reproduce

    outcome = reproduce(folder)
    if not quiet:
        say(str(outcome))
    if not outcome.is_same:
        raise typer.Exit(1)
