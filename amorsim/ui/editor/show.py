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
from amorsim.scenario.elsewhere import named_files
from amorsim.ui.editor.journal import state_folder
from amorsim.ui.editor.session import EditSession
from amorsim.ui.editor.work import Work
from amorsim.ui.serve.inviting import Invitation
from amorsim.ui.serve.pages import Page, Pages
from amorsim.ui.serve.security import Door
from amorsim.ui.serve.server import serve
from amorsim.ui.simulator.recipe import Recipe
from amorsim.ui.simulator.session import Session

__all__ = ["edit"]

LONGEST_REST = 0.5  # [s] that the server gets to end once the simulations have

LONGEST = 8 * 1024 * 1024  # [bytes] of a window's message: a file as text, or thousands of walls that are moved

Say = Callable[[str], None]


def edit(
    name: str, *, host: str, port: int, browser: bool, allow_code: bool, say: Say, complain: Say, folder: Path
) -> None:
    """Serve the Editor's window until Ctrl-C. The process is not to do anything more afterwards: it may be ended here.

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
        Told the addresses, and what the user should know before.
    folder
        Where a copy or an empty page is saved.

    Raises
    ------
    AmorsimError
        If there is no such file, or nothing can be served there.
    """
    work = Work(name, folder, state=state_folder())
    if work.remark:
        complain(work.remark)
    pages = Pages()
    runs = _Runs(work, pages, may_run_code=allow_code or Door(host=host, port=port).is_for_this_machine)
    invitation = Invitation(browser=browser, say=say, complain=complain)

    async def end() -> None:
        await runs.close()
        invitation.forget()
        rest = threading.Timer(LONGEST_REST, leave)
        rest.daemon = True
        rest.start()

    def leave() -> None:
        sys.stdout.flush()
        os._exit(0)

    async def all_of_it() -> None:
        session = EditSession(work, run=runs.start)
        pages.add("edit", work.name, session)
        session.start()
        try:
            await serve(pages, host=host, port=port, ready=invitation.ready, ending=end, longest_message=LONGEST)
        finally:
            await runs.close()
            await session.close()

    with asyncio.Runner() as runner:
        try:
            with contextlib.suppress(KeyboardInterrupt):
                runner.run(all_of_it())
        finally:
            invitation.forget()
            gc.freeze()  # Python's last look for what nobody uses takes a second with all that numba holds


class _Runs:
    """The simulations of the document: one at a time, on the page of its name."""

    def __init__(self, work: Work, pages: Pages, *, may_run_code: bool) -> None:
        self._work, self._pages, self._may_run_code = work, pages, may_run_code
        self._page: Page | None = None
        self._session: Session | None = None

    async def start(self, file: Path) -> str:
        """Start the simulation of a file in place of the one before; returns the path of its page.

        Raises
        ------
        AmorsimError
            If it cannot be simulated, or has code that must not run here.
        """
        if not self._may_run_code and self._has_code():
            raise AmorsimError(
                "this scenario has programs of its own, and other machines can reach this window; start the Editor "
                "with --allow-code if they may run them, or without --host"
            )
        session = Session(Recipe(name=str(file), passing=str(file.parent)), project=self._work.folder)
        try:
            await session.start()
        except BaseException:
            await session.close()
            raise
        await self.close()
        self._session, self._page = session, self._pages.add("run", self._work.name, session)
        return self._page.path

    def _has_code(self) -> bool:
        document = self._work.document
        here = document.path.absolute().parent
        return any(named.kind == "program" for named in named_files(document.values, self._work.registry, here))

    async def close(self) -> None:
        """End the simulation, and its page; again if one likes."""
        if self._page is not None:
            self._pages.remove(self._page)
        if self._session is not None:
            await self._session.close()
        self._session = self._page = None
