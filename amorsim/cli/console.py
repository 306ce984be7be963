"""The output of all commands, and where it goes."""

from __future__ import annotations

import contextlib
import re
import sys
from collections.abc import Callable, Iterable, Iterator
from typing import TYPE_CHECKING

from amorsim.kernels import COMPILING

if TYPE_CHECKING:
    from amorsim.contracts import Planner

__all__ = ["compile_all", "compile_once", "compile_planners_once", "complain", "say"]


def say(text: str) -> None:
    """A line for the user."""
    sys.stdout.write(text + "\n")
    sys.stdout.flush()


def complain(text: str) -> None:
    """Print a line about something that went wrong."""
    sys.stderr.write(text + "\n")
    sys.stderr.flush()


def compile_once(look: Callable[[], None], quiet: bool = False) -> bool:
    """Compile what nearly every command needs, with a bar, unless it is compiled; returns whether it was not.

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
    """Compile what usual runs need, with a bar; see `amorsim.runs.warm`."""
    from amorsim.runs.warm import compile_kernels

    if quiet:
        compile_kernels(more=more)
        return
    say(COMPILING)
    with _bar() as progress:
        compile_kernels(progress, more=more)


def compile_planners_once(planners: Iterable[Planner], quiet: bool = False) -> None:
    """Compile what these planners need, with a bar, unless it is compiled."""
    from amorsim.runs.warm import cold_planners, compile_planner

    cold = cold_planners(planners)
    if not cold:
        return
    if not quiet:
        names = ", ".join(re.sub("(?<!^)(?=[A-Z])", "_", kind.__name__).lower() for kind in cold)
        say(f"compiling the kernels of the planner {names}, once after installing (up to a minute) ...")
    with contextlib.nullcontext() if quiet else _bar() as progress:
        for done, kind in enumerate(cold):
            if progress is not None:
                progress(done, len(cold))
            compile_planner(kind)


@contextlib.contextmanager
def _bar() -> Iterator[Callable[[int, int], None] | None]:
    """A function that shows how much of how much is done; None if nobody looks."""
    if not sys.stdout.isatty():
        yield None
        return
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TimeElapsedColumn

    with Progress(BarColumn(), MofNCompleteColumn(), TimeElapsedColumn(), transient=True) as bar:
        task = bar.add_task("")
        yield lambda done, total: bar.update(task, completed=done, total=total)
