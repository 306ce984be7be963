"""The pages of a server: each shows one session, and has an address of its kind and the session's name."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, Protocol

import attrs

from amorsim.core.errors import AmorsimError

__all__ = ["KINDS", "SIMULATOR_STYLES", "WEB", "Page", "Pages", "Talks"]

WEB = Path(__file__).parent.parent / "web"
LOOK = "shared/look.css"
SIMULATOR_STYLES = ("vendor/uplot/uPlot.min.css", LOOK, "simulator/page.css")
KINDS: Mapping[str, tuple[str, tuple[str, ...]]] = {
    "run": ("simulator/main.js", SIMULATOR_STYLES),
    "edit": ("editor/editor.js", (LOOK, "editor/page.css")),
    "faults": ("faults/faults.js", (LOOK, "faults/page.css")),
}  # the script that starts a kind of page, and its styles; in `WEB`

_ODD = re.compile(r"[^A-Za-z0-9_.-]+")


class Talks(Protocol):
    """The interface that a server needs of a session; see `amorsim.ui.simulator.session.Session`."""

    def open_window(self, tab: str = "") -> str:
        """A new window's name; `tab` is the same for the windows that one tab shows after one another."""

    def close_window(self, window: str) -> None:
        """A window has gone."""

    async def newest_frame(self, after: int = 0, window: str = "") -> bytes:
        """A window's newest frame, as soon as its number is above `after`; empty if none will come."""

    def only_asks(self, name: str) -> bool:
        """Whether a command only asks: such are answered at once, others in the order in which they came."""

    async def ask(self, window: str, command: Mapping[str, Any]) -> dict[str, Any]:
        """The answer to a command."""


@attrs.frozen(kw_only=True)
class Page:
    """A page of a kind, for the session of a name."""

    kind: str
    name: str
    session: Talks

    @property
    def path(self) -> str:
        """Where it is served."""
        return f"/{self.kind}/{self.name}"


class Pages:
    """Pages by kind and name, in the order in which they were added.

    Attributes
    ----------
    first
        The page that is shown where none is named: the one that was added first, unless another was chosen; None
        where there is none.
    """

    def __init__(self) -> None:
        self._pages: dict[tuple[str, str], Page] = {}
        self.first: Page | None = None

    def __iter__(self) -> Iterator[Page]:
        return iter(self._pages.values())

    def add(self, kind: str, name: str, session: Talks) -> Page:
        """A new page. Its name is of letters that need no quoting in an address, with a number where it is taken.

        Raises
        ------
        AmorsimError
            If there is no such kind of page.
        """
        if kind not in KINDS:
            raise AmorsimError(f"expected a kind of page, {', '.join(map(repr, KINDS))}; got {kind!r}")
        plain = _ODD.sub("-", name).strip("-.") or "session"
        free, number = plain, 1
        while (kind, free) in self._pages:
            number += 1
            free = f"{plain}-{number}"
        page = self._pages[kind, free] = Page(kind=kind, name=free, session=session)
        self.first = self.first or page
        return page

    def replace(self, page: Page, session: Talks) -> Page:
        """Show another session in the place of a page's, from the next window on."""
        new = attrs.evolve(page, session=session)
        self._pages[page.kind, page.name] = new
        self.first = new if self.first is page else self.first
        return new

    def remove(self, page: Page) -> None:
        """Show a page no more; its name is free again."""
        self._pages.pop((page.kind, page.name), None)
        if self.first is page:
            self.first = next(iter(self), None)

    def find(self, kind: str, name: str) -> Page | None:
        """The page of a kind and name, or None."""
        return self._pages.get((kind, name))
