"""``amorsim compile``: compile the kernels ahead of the first run."""

from __future__ import annotations

from typing import Annotated

import typer

from amorsim.cli.console import compile_all

__all__ = ["command"]


def command(
    quiet: Annotated[bool, typer.Option("--quiet", "-q", help="Print nothing but errors.")] = False,
) -> None:
    """Compile what usual runs, the bundled scenarios, avoiders, generated worlds and planners need, ahead of the first.

    It takes two to three minutes, once after installing or updating. What is compiled already is kept.
    """
    compile_all(quiet, more=True)
