"""What the tests of the Editor's session build on: a session that is talked to by its commands."""

from __future__ import annotations

from collections.abc import Awaitable, Callable
from pathlib import Path
from typing import Any

import amorsim as am
from amorsim.ui.editor.reader import Reader
from amorsim.ui.editor.session import EditSession
from amorsim.ui.editor.work import Work
from tests.ui.aside import aside

Talk = Callable[[EditSession], Awaitable[None]]

READERS: list[Reader] = []  # the process that reads for all sessions: to start one takes a second


def talk(name: str, folder: Path, say: Talk, *, state: Path | None = None, may_run_code: bool = False) -> Work:
    """Let a session run for as long as something is said to it; returns what it has edited."""
    work = Work(name, folder, state=state)

    async def all_of_it() -> None:
        async with EditSession(work, reader=READERS[0], may_run_code=may_run_code) as session:
            await say(session)

    aside(all_of_it())
    return work


async def do(session: EditSession, **command: Any) -> dict[str, Any]:
    said = await session.request(command)
    assert said["ok"], said
    return said


async def drawn(session: EditSession) -> dict[str, Any]:
    """What is drawn, once all changes are read and all programs tried."""
    number = 0
    found: dict[str, Any] = {}
    while True:
        said = await do(session, do="document", after=number)
        number, found = said["number"], said.get("drawn", found)
        if not said["is_behind"] and not said["is_checking"]:
            return found


def own_copy(name: str, folder: Path) -> Path:
    """A bundled scenario as a user's own files."""
    file = folder / f"{name}.toml"
    am.open_document(name).save(file, copy=True)
    return file
