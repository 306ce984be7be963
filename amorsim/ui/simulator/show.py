"""The window's process: keeps a session and serves its window until it is asked to end."""

from __future__ import annotations

import asyncio
import contextlib
import gc
import importlib.util
import json
import os
import signal
import sys
import threading
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from amorsim.core.errors import AmorsimError
from amorsim.core.files.reading import is_file
from amorsim.runs.folder import next_folder
from amorsim.ui.faults.shown_faults import FaultLine, FaultsError
from amorsim.ui.serve.launch_url import LaunchUrl
from amorsim.ui.simulator.process.orphan import stay
from amorsim.ui.simulator.recipe import Recipe

if TYPE_CHECKING:
    from amorsim.ui.faults.changed_files import Stamps
    from amorsim.ui.faults.mending import Mending
    from amorsim.ui.serve.pages import Page, Pages
    from amorsim.ui.simulator.session import Session

__all__ = ["can_be_mended", "check_extra", "main", "show"]

LONGEST_REST = 0.5  # [s] that the server gets to end once the simulation has
NEVER_OPEN = 2  # the exit status where faults were never mended: that of a user's mistake

Say = Callable[[str], None]


def check_extra() -> None:
    """Raise an error that states what to install if the window's own libraries are missing."""
    if any(importlib.util.find_spec(name) is None for name in ("starlette", "uvicorn", "websockets")):
        raise AmorsimError('the window needs the extra "ui": python -m pip install "amorsim[ui]"')


def can_be_mended(recipe: Recipe, faults: list[FaultLine]) -> bool:
    """Whether a change of the scenario's file, or of one that it names, may remove its faults."""
    return _is_own_file(recipe) and any(not fault["file"].startswith("--set ") for fault in faults)


def _is_own_file(recipe: Recipe) -> bool:
    """Whether a scenario is the user's own file, which may change."""
    return not recipe.passing and Path(recipe.name).suffix in ("", ".toml") and is_file(recipe.name)


def show(
    recipe: Recipe,
    *,
    out: Path | None,
    host: str,
    port: int,
    browser: bool,
    say: Say,
    complain: Say,
    notice: Say | None,
    known: FaultsError | None = None,
    lecture: bool = False,
) -> bool:
    """Serve the window of a simulation until Ctrl-C; returns whether there was a simulation to be seen.

    Of a scenario's file with faults, the window shows the faults until the file is mended, and then the simulation.
    The process is not to do anything more afterwards: it may be ended here.

    Parameters
    ----------
    recipe, out, notice
        As for `Session`.
    host, port
        Where; port 0 takes one that is free.
    browser
        Whether to open the window in the browser.
    say, complain
        Called with the addresses and where the results are, and with warnings.
    known
        Why the scenario cannot be simulated, where that is known already.
    lecture
        Whether the window opens large, for a class.

    Raises
    ------
    AmorsimError
        If it cannot be simulated, and no change of its file would help; or if nothing can be served there.
    """
    from amorsim.ui.serve.pages import Pages
    from amorsim.ui.serve.server import serve

    pages = Pages()
    shown = _Shown(recipe, pages, out=out, say=say, complain=complain, notice=notice)
    last_word = threading.Lock()  # printed once: here, or by the timer that waits for nothing
    invitation = LaunchUrl(browser=browser, say=say, complain=complain, fragment="#lecture" if lecture else "")

    def tell() -> None:
        if last_word.acquire(blocking=False) and shown.folder:
            say(f"results: {shown.folder}")

    def leave() -> None:
        tell()
        sys.stdout.flush()
        os._exit(0 if shown.is_open else NEVER_OPEN)

    async def end() -> None:
        await shown.close()
        invitation.forget()
        # The files are whole. What the server still does (a GIF that is being made) shall not hold up the end.
        rest = threading.Timer(LONGEST_REST, leave)
        rest.daemon = True
        rest.start()

    with asyncio.Runner() as runner:
        try:
            runner.run(shown.begin(known))
            with contextlib.suppress(KeyboardInterrupt):
                runner.run(serve(pages, host=host, port=port, ready=invitation.ready, ending=end))
        finally:
            runner.run(shown.close())
            invitation.forget()
            # Python's last look for what nobody uses takes a second with all that numba holds.
            gc.freeze()
    tell()
    return shown.is_open


class _Shown:
    """The content of the pages: a simulation, or the faults of its scenario's file, or both."""

    def __init__(
        self, recipe: Recipe, pages: Pages, *, out: Path | None, say: Say, complain: Say, notice: Say | None
    ) -> None:
        self._recipe, self._pages = recipe, pages
        self._out, self._say, self._complain, self._notice = out, say, complain, notice
        self._session: Session | None = None
        self._starting: Session | None = None
        self._mending: Mending | None = None
        self._page: Page | None = None  # the simulation's
        self._faults_page: Page | None = None
        self._watching: asyncio.Task[None] | None = None
        self._loading = asyncio.Lock()

    @property
    def is_open(self) -> bool:
        """Whether there was a simulation to be seen."""
        return self._session is not None

    @property
    def folder(self) -> str:
        """The folder that the run is written into, or nothing."""
        return "" if self._session is None else self._session.folder

    async def begin(self, known: FaultsError | None) -> None:
        """Open the simulation's page, or that of the faults as long as there are any.

        Raises
        ------
        AmorsimError
            If there cannot be a simulation, and no change of the file would help.
        """
        try:
            if known is not None:
                raise known
            await self._open()
        except FaultsError as error:
            if not can_be_mended(self._recipe, error.faults):
                raise
            self._complain(str(error))
            self._say(f"{self._recipe.name} has faults; the window shows them, and the simulation once they are mended")
            await self._show_faults(error)

    async def _open(self) -> str:
        """Start the simulation, in the place of the one that there is; returns the path of its page."""
        from amorsim.ui.faults.changed_files import stamps_of
        from amorsim.ui.simulator.session import Session

        async with self._loading:
            own = [Path(self._recipe.name).absolute()] if _is_own_file(self._recipe) else []
            stamps = stamps_of(own)
            out = self._out if self._session is None or self._out is None else next_folder(self._out)
            session = self._starting = Session(self._recipe, out=out, notice=self._notice)
            await session.start()
            for remark in session.remarks:
                self._complain(remark)
            before, self._session, self._starting = self._session, session, None
            if self._page is None:
                self._page = self._pages.add("run", Path(self._recipe.name).stem, session)
            else:
                self._page = self._pages.replace(self._page, session)
            self._pages.first = self._page
            if before is not None:
                before.moved = self._page.path  # which its windows ask for
                folder = before.folder
                await before.close()
                if folder:
                    self._say(f"results: {folder}")
            elif self._mending is not None:
                self._say(f"{self._recipe.name} is mended; the window shows the simulation")
            if own:
                session.reload = self._reload
                if self._watching is not None:
                    self._watching.cancel()
                self._watching = asyncio.create_task(self._watch(session, stamps))
            return self._page.path

    async def _watch(self, session: Session, stamps: Stamps) -> None:
        """Note when the file has changed that a session simulates."""
        from amorsim.ui.faults.changed_files import change_of, stamps_of_scenario

        await change_of({**await asyncio.to_thread(stamps_of_scenario, self._recipe.name), **stamps})
        session.changed = True

    async def _reload(self) -> str:
        """Load the file again; returns the path of the page to go to. The simulation goes on if there are faults."""
        try:
            return await self._open()
        except FaultsError as error:
            return await self._show_faults(error)

    async def _show_faults(self, error: FaultsError) -> str:
        """Open the page of the faults, until they are mended; returns its path."""
        from amorsim.ui.faults.mending import Mending

        if self._mending is not None:
            await self._mending.close()
        name, changes = self._recipe.name, self._recipe.changes
        path = "" if self._page is None else self._page.path
        self._mending = Mending(name, error.faults, changes=changes, open_page=self._open, path=path)
        if self._faults_page is None:
            self._faults_page = self._pages.add("faults", Path(name).stem, self._mending)
        else:
            self._faults_page = self._pages.replace(self._faults_page, self._mending)
        self._mending.start()
        return self._faults_page.path

    async def close(self) -> None:
        """End it all, with whole files; again if one likes."""
        if self._watching is not None:
            self._watching.cancel()
        if self._mending is not None:
            await self._mending.close()
        for session in (self._starting, self._session):
            if session is not None:
                await session.close()


def main() -> None:
    """Read the order as a line of standard input, and show that until the end of standard input.

    Answers are lines: ``say``, ``complain`` or ``error``, and a text.
    """
    order = json.loads(sys.stdin.readline())
    answers = sys.stdout
    sys.stdout = sys.stderr

    def tell(kind: str) -> Say:
        def answer(text: str) -> None:
            answers.write(json.dumps([kind, text]) + "\n")
            answers.flush()

        return answer

    def watch() -> None:
        sys.stdin.read()
        signal.raise_signal(signal.SIGINT)

    threading.Thread(target=watch, name="amorsim-end", daemon=True).start()
    stay()
    try:
        show(
            Recipe.from_json(order["recipe"]),
            out=Path(order["out"]) if order["out"] else None,
            host=order["host"],
            port=order["port"],
            browser=order["browser"],
            say=tell("say"),
            complain=tell("complain"),
            notice=tell("say"),
        )
    except AmorsimError as error:
        tell("error")(str(error))
    except KeyboardInterrupt:  # before there was a window
        os._exit(0)
