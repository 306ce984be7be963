"""The progress of a study: a bar in a terminal, else a line from time to time."""

from __future__ import annotations

import contextlib
import sys
import time
from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING

from amorsim.cli.console import say

if TYPE_CHECKING:
    from amorsim.sweeps.sweep import Progress

__all__ = ["case_progress", "study_progress"]

_EVERY = 30.0  # [s] between lines about the progress where there is no terminal


@contextlib.contextmanager
def study_progress(quiet: bool = False) -> Iterator[Callable[[Progress], None] | None]:
    """The function that `sweep` calls with the progress of a study; None if nothing is to be shown."""
    if quiet:
        yield None
        return
    if not sys.stdout.isatty():
        yield _Lines()
        return
    from rich.progress import BarColumn, MofNCompleteColumn, TextColumn
    from rich.progress import Progress as Bar

    columns = (TextColumn("simulating"), BarColumn(), MofNCompleteColumn(), TextColumn("{task.fields[left]}"))
    with Bar(*columns, transient=True) as bar:
        task = bar.add_task("simulating", total=1, left="")

        def draw(progress: Progress) -> None:
            bar.update(task, completed=progress.done, total=progress.total, left=_words(progress))

        yield draw


@contextlib.contextmanager
def case_progress(quiet: bool = False) -> Iterator[Callable[[str, int, int], None] | None]:
    """The function that `grade` calls with a line on each case; in a terminal it prints it above a bar."""
    if quiet or not sys.stdout.isatty():
        yield None if quiet else lambda line, *_: say(line)
        return
    from rich.markup import escape
    from rich.progress import BarColumn, MofNCompleteColumn, TextColumn, TimeRemainingColumn
    from rich.progress import Progress as Bar

    with Bar(TextColumn("grading"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn(), transient=True) as bar:
        task = bar.add_task("grading", total=None)

        def draw(line: str, done: int, total: int) -> None:
            bar.console.print(escape(line), highlight=False)
            bar.update(task, completed=done, total=total)

        yield draw


class _Lines:
    """Lines in place of a bar, where there is no terminal."""

    def __init__(self) -> None:
        self._said_at = time.monotonic()

    def __call__(self, progress: Progress) -> None:
        if progress.left is None and progress.done and progress.done < progress.total:
            say(f"{progress.done} of {progress.total} were done before")
        elif (now := time.monotonic()) - self._said_at > _EVERY and progress.done < progress.total:
            say(", ".join(filter(None, (f"{progress.done} of {progress.total} done", _words(progress)))))
            self._said_at = now


def _words(progress: Progress) -> str:
    """The time left, and how many have failed, in words."""
    failed = f", {progress.failed} failed" if progress.failed else ""
    if progress.left is None:
        return failed.removeprefix(", ")
    seconds = round(progress.left)
    left = f"{seconds} s" if seconds < 120 else f"{seconds // 60} min" if seconds < 7200 else f"{seconds / 3600:.1f} h"
    return f"about {left} left{failed}"
