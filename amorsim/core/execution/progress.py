"""A bar for work that takes long, in a terminal and in a notebook."""

from __future__ import annotations

import contextlib
import sys
import time
from collections.abc import Callable, Iterator
from typing import Any, TypeVar

from amorsim.core.error_text import in_words
from amorsim.core.parameters import ParameterError

__all__ = ["Show", "progress_shown"]

Show = Callable[[float], None]
"""Takes the share done, between 0 and 1."""
T = TypeVar("T")

_AFTER = 2.0  # [s] after which there is a bar: shorter work needs none
_EVERY = 0.1  # [s] between two drawings


@contextlib.contextmanager
def progress_shown(
    progress: bool | Callable[[T], None] | None, what: str, share: Callable[[T], float]
) -> Iterator[Callable[[T], None] | None]:
    """A function to call as work goes on; None for nothing.

    Parameters
    ----------
    progress
        A function that is called itself; True for a bar, which appears after two seconds where a person looks: in a
        notebook, or where standard error is a terminal; False or None for nothing.
    what
        The word before the bar.
    share
        The share done, of what the function is called with.

    Raises
    ------
    ParameterError
        If `progress` is neither.
    """
    if callable(progress):
        yield progress
        return
    try:
        is_wanted = bool(progress)
    except (TypeError, ValueError):
        raise ParameterError("progress", f"expected True or False, got {in_words(progress)}") from None
    make = _bar_here() if is_wanted and not _shown else None
    if make is None:
        yield None
        return
    bar = _Late(make, what)
    _shown.append(bar)
    try:
        yield lambda now: bar.show(share(now))
    finally:
        _shown.remove(bar)
        bar.close()


_shown: list[_Late] = []  # the bar of the outermost work, if there is one: what is within that has none


class _Late:
    """A bar that is made when work has gone on for a while."""

    def __init__(self, make: Callable[[str], contextlib.AbstractContextManager[Show]], what: str) -> None:
        self._make, self._what = make, what
        self._next = time.monotonic() + _AFTER
        self._stack = contextlib.ExitStack()
        self._draw: Show | None = None

    def show(self, share: float) -> None:
        now = time.monotonic()
        if now < self._next:
            return
        self._next = now + _EVERY
        if self._draw is None:
            self._draw = self._stack.enter_context(self._make(self._what))
        self._draw(share)

    def close(self) -> None:
        self._stack.close()


def _bar_here() -> Callable[[str], contextlib.AbstractContextManager[Show]] | None:
    """The bar that fits where the program runs; None if nobody looks."""
    if _is_notebook():
        return _in_notebook
    return _in_terminal if sys.stderr is not None and sys.stderr.isatty() else None


def _is_notebook() -> bool:
    """Whether the program runs in a kernel of IPython with a page in front of it."""
    if "IPython" not in sys.modules:
        return False
    from IPython import get_ipython

    return type(get_ipython()).__name__ == "ZMQInteractiveShell"


@contextlib.contextmanager
def _in_terminal(what: str) -> Iterator[Show]:
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn, TimeRemainingColumn

    columns = (TextColumn(what), BarColumn(), TaskProgressColumn(), TimeRemainingColumn())
    with Progress(*columns, console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task(what, total=1.0)
        yield lambda share: bar.update(task, completed=share)


@contextlib.contextmanager
def _in_notebook(what: str) -> Iterator[Show]:
    # An element of HTML: bars of other libraries need a further package here.
    from IPython.display import HTML, display

    def element(share: float) -> Any:
        return HTML(f'{what} <progress value="{share:.3f}" aria-label="{what}"></progress> {100.0 * share:.0f} %')

    handle = display(element(0.0), display_id=True)
    try:
        yield lambda share: handle.update(element(share))
    finally:
        handle.update(HTML(""))
