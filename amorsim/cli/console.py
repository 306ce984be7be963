"""What all commands say, and where."""

from __future__ import annotations

import sys
from collections.abc import Callable

from amorsim.kernels import COMPILING

__all__ = ["compile_all", "compile_once", "complain", "say"]


def say(text: str) -> None:
    """A line for the user."""
    sys.stdout.write(text + "\n")
    sys.stdout.flush()


def complain(text: str) -> None:
    """A line about what went wrong."""
    sys.stderr.write(text + "\n")
    sys.stderr.flush()


def compile_once(look: Callable[[], None], quiet: bool = False) -> bool:
    """Compile what nearly every command needs, if that was not done before, and show how far it is; whether it was due.

    `look` raises what is wrong with the user's words, as far as that is known without compiling. It is called only
    where something is to be compiled; elsewhere the command itself finds it as soon.
    """
    from amorsim.kernels.cache_folder import is_cold

    if not is_cold():
        return False
    look()
    compile_all(quiet)
    return True


def compile_all(quiet: bool = False, more: bool = False) -> None:
    """Compile what usual runs need, and show how far it is; see `amorsim.runs.warm`."""
    from amorsim.runs.warm import compile_kernels

    if quiet:
        compile_kernels(more=more)
        return
    say(COMPILING)
    if not sys.stdout.isatty():
        compile_kernels(more=more)
        return
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TimeElapsedColumn

    with Progress(BarColumn(), MofNCompleteColumn(), TimeElapsedColumn(), transient=True) as bar:
        task = bar.add_task("")
        compile_kernels(lambda done, total: bar.update(task, completed=done, total=total), more=more)
