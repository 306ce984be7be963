"""The Editor's process: it keeps a document and serves its window, and the windows of simulations, until it ends."""

from __future__ import annotations

import asyncio
import contextlib
import gc
import os
import sys
import threading
from collections.abc import Callable
from pathlib import Path

from amorsim.core.errors import AmorsimError
from amorsim.core.files.reading import is_there
from amorsim.ui.editor.journal import state_folder
from amorsim.ui.editor.session import EditSession
from amorsim.ui.editor.work import Work
from amorsim.ui.serve.launch_url import LaunchUrl
from amorsim.ui.serve.pages import Page, Pages
from amorsim.ui.serve.security import Door
from amorsim.ui.serve.server import serve
from amorsim.ui.simulator.recipe import Recipe
from amorsim.ui.simulator.session import Session

__all__ = ["edit"]

LONGEST_REST = 0.5  # [s] that the server gets to end once the simulations have

MOST_OPEN = 20
LONGEST = 8 * 1024 * 1024  # [bytes] of a window's message: a file as text, or thousands of walls that are moved

Say = Callable[[str], None]


def edit(
    name: str, *, host: str, port: int, browser: bool, allow_code: bool, say: Say, complain: Say, folder: Path
) -> None:
    """Serve the Editor's window until Ctrl-C. The process may be ended here, so do nothing after the call.

    Parameters
    ----------
    name
        A scenario's file, the name of a bundled one, or nothing for an empty page.
    host, port
        Where; port 0 takes one that is free.
    browser
        Whether to open the window in the browser.
    allow_code
        Whether scenarios with programs of a user's may be run while other machines can reach the window.
    say, complain
        Called with the addresses, and with warnings.
    folder
        Where a copy or an empty page is saved.

    Raises
    ------
    AmorsimError
        If there is no such file, or nothing can be served there.
    """
    work = Work(name, folder, state=state_folder())
    if work.steps.remark:
        complain(work.steps.remark)
    pages = Pages()
    may_run_code = allow_code or Door(host=host, port=port).is_for_this_machine
    opened = _Opened(pages, folder, may_run_code=may_run_code)
    invitation = LaunchUrl(browser=browser, say=say, complain=complain)

    async def end() -> None:
        await opened.end_runs()
        opened.forget_files()  # now: after SIGTERM, uvicorn ends the process before anything else can be done
        invitation.forget()
        rest = threading.Timer(LONGEST_REST, leave)
        rest.daemon = True
        rest.start()

    def leave() -> None:
        sys.stdout.flush()
        os._exit(0)

    async def all_of_it() -> None:
        session, _ = opened.add(work)

        def ready(door: Door) -> None:
            invitation.ready(door)
            session.start()  # whose process would take turns with this one while the user waits for the address

        try:
            await serve(pages, host=host, port=port, ready=ready, ending=end, longest_message=LONGEST)
        finally:
            await opened.close()

    with asyncio.Runner() as runner:
        try:
            with contextlib.suppress(KeyboardInterrupt):
                runner.run(all_of_it())
        finally:
            invitation.forget()
            gc.freeze()  # Python's last look for what nobody uses takes a second with all that numba holds


class _Opened:
    """The scenarios that are edited, each on a page of its own."""

    def __init__(self, pages: Pages, folder: Path, *, may_run_code: bool) -> None:
        self._pages, self._folder, self._may_run_code = pages, folder, may_run_code
        self._sessions: list[tuple[EditSession, Page, _Runs]] = []

    def add(self, work: Work) -> tuple[EditSession, Page]:
        """The session of a scenario, to be started, and its page."""
        session = EditSession(work, may_run_code=self._may_run_code, open_other=self.open)
        page = self._pages.add("edit", work.name, session)
        self._sessions.append((session, page, _Runs(session, page, self._pages)))
        return session, page

    async def open(self, name: str) -> str:
        """The path of the page of a file, of a copy of a bundled scenario, or of an empty page.

        Raises
        ------
        AmorsimError
            If there is no such scenario, or nothing more can be opened.
        """
        is_file = name.endswith(".toml")
        path = Path(os.path.abspath(self._folder / name))  # noqa: PTH100 - a link keeps the name that it was given
        for session, page, _ in self._sessions:
            if (is_file and not session.work.is_new and session.work.path == path) or (
                not is_file and session.work.is_new and session.work.name == (name or "untitled")
            ):
                return page.path
        if len(self._sessions) >= MOST_OPEN:
            raise AmorsimError(f"{MOST_OPEN} scenarios are open; end this Editor and start another")
        if is_file and not is_there(path):
            raise AmorsimError(f"there is no file {name}")
        session, page = self.add(Work(str(path) if is_file else name, self._folder, state=state_folder()))
        session.start()
        return page.path

    async def end_runs(self) -> None:
        """End all simulations."""
        for _, _, runs in self._sessions:
            await runs.close()

    def forget_files(self) -> None:
        """Remove what the sessions wrote for other processes."""
        for session, _, _ in self._sessions:
            session.forget_files()

    async def close(self) -> None:
        """End all sessions and simulations."""
        await self.end_runs()
        for session, _, _ in self._sessions:
            await session.close()


class _Runs:
    """The simulations of a document: one at a time, on the page of its name, which leads back to the Editor's."""

    def __init__(self, editing: EditSession, editing_page: Page, pages: Pages) -> None:
        self._editing, self._editing_page, self._pages = editing, editing_page, pages
        self._page: Page | None = None
        self._session: Session | None = None
        editing.run = self.start

    async def start(self, file: Path) -> str:
        """Start the simulation of a file in place of the previous one; returns the path of its page.

        Raises
        ------
        AmorsimError
            If it cannot be simulated, or has code that must not run here.
        """
        work = self._editing.work
        if not self._editing.may_run_code and self._editing.has_code:
            raise AmorsimError(
                "this scenario has programs of its own, and other machines can reach this window; start the Editor "
                "with --allow-code if they may run them, or without --host"
            )
        session = Session(Recipe(name=str(file), passing=str(file.parent)), project=work.folder)
        try:
            await session.start()
        except BaseException:
            await session.close()
            raise
        await self.close()
        self._session, self._page = session, self._pages.add("run", work.name, session)
        return f"{self._page.path}?from={self._editing_page.path}"

    async def close(self) -> None:
        """End the simulation and its page; calling it again does nothing."""
        if self._page is not None:
            self._pages.remove(self._page)
        if self._session is not None:
            await self._session.close()
        self._session = self._page = None
