"""The session of a page that shows the faults of a scenario's file, until it is mended.

The server reads the file itself, for nothing of a user's runs when a document is read. Whether the mended file can be
simulated is found by starting its simulation, in the process that all simulations have.
"""

from __future__ import annotations

import asyncio
import base64
import contextlib
import itertools
import sys
import traceback
from collections.abc import Awaitable, Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple, TypedDict

from amorsim.core.error_text import error_in_words
from amorsim.core.errors import AmorsimError, DocumentError, Fault, ScenarioError
from amorsim.scenario.documents.document import open_document
from amorsim.scenario.reading.read import check_words
from amorsim.ui.faults.changed_files import BETWEEN_LOOKS, Stamps, change_of, stamps_of
from amorsim.ui.faults.shown_faults import FaultLine, FaultsError, fault_lines
from amorsim.ui.scene.still import StillBuilder
from amorsim.ui.scene.wire import Still
from amorsim.ui.serve.wire import shown, whole

__all__ = ["FaultyFile", "Mending"]

_NUMBER = whole(0)


class FaultyFile(TypedDict):
    """The state of a scenario's file: the answer to ``document``."""

    ok: bool
    number: int  # of this answer; greater than of those before
    # "reading" before what can be drawn is known, "faulty", "starting" where it has no faults, or "open" once its
    # simulation is to be seen.
    status: str
    file: str
    faults: list[FaultLine]
    still: Still | None  # none before it is read, or if nothing of it can be
    path: str  # of the simulation's page, if there is one; while the file is faulty, that of the file as it was


class _Looked(NamedTuple):
    faults: list[FaultLine]
    builder: StillBuilder | None
    stamps: Stamps


class Mending:
    """A scenario with faults, as windows see it; they are notified as soon as its file has changed.

    All of it is for the event loop in which it is started.

    Parameters
    ----------
    name, changes
        The file, as the user names it, and the changes of its content: settings as of ``--set``.
    faults
        Why it cannot be.
    open_page
        Starts the simulation, and returns the path of its page.
    path
        Of the page of a simulation that goes on meanwhile, if there is one. Its place is taken by the new one only
        while somebody looks at the faults.
    """

    def __init__(
        self,
        name: str,
        faults: list[FaultLine],
        *,
        changes: Sequence[str] = (),
        open_page: Callable[[], Awaitable[str]],
        path: str = "",
    ) -> None:
        self._name = name
        self._changes = changes
        self._file = Path(name).absolute()
        self._known = faults
        self._open_page = open_page
        self._path = path
        self._builder: StillBuilder | None = None
        self._news = asyncio.Event()
        self._numbers = itertools.count(1)
        self._windows: set[str] = set()
        self._watching: asyncio.Task[None] | None = None
        self._shown = self._faulty_file(1, "reading", faults)

    def start(self) -> None:
        """Watch the file from now on."""
        self._watching = asyncio.get_running_loop().create_task(self._watch())

    async def close(self) -> None:
        """Watch it no more."""
        if self._watching is not None:
            self._watching.cancel()
            with contextlib.suppress(asyncio.CancelledError):
                await self._watching

    # ---------------------------------------------------------------------------------------------------- the file

    async def _watch(self) -> None:
        """Look at the file whenever it has changed, until it can be simulated."""
        stamps = stamps_of([self._file])
        while True:
            looked = await asyncio.to_thread(self._look, stamps)
            faults, self._known = self._known or looked.faults, []
            self._builder = looked.builder
            if not faults:
                while self._path and not self._windows:
                    await asyncio.sleep(BETWEEN_LOOKS)
                self._show("starting", [])
                try:
                    self._path = await self._open_page()
                except FaultsError as error:
                    faults = error.faults
                except AmorsimError as error:
                    faults = fault_lines([Fault(file="", path="", message=str(error))])
                else:
                    self._show("open", [])
                    return
            self._show("faulty", faults)
            stamps = await change_of(looked.stamps)

    def _look(self, stamps: Stamps) -> _Looked:
        """Read the file, and its content as far as possible."""
        seen = {self._file: stamps[self._file]}
        builder = None
        try:
            document = open_document(self._name)
            seen |= stamps_of(file for file in document.files() if file != self._file)
            partial = document.partial()
            faults = partial.faults
            if self._changes:  # which may mend, or cause, what is wrong
                faults = self._faults_with_changes()
            builder = StillBuilder(partial, self._file.stem)
        except DocumentError as error:
            message = str(error).removeprefix(f"{self._name}: ")
            faults = (Fault(file=self._name, path="", message=message),)
        except ScenarioError as error:  # of another program's file
            faults = error.faults
        except Exception as error:  # what a plugin's loader may raise; it must not end the watch
            sys.stderr.write("".join(traceback.format_exception(error)))
            faults = (Fault(file=self._name, path="", message=f"cannot be read: {error_in_words(error)}"),)
        return _Looked(fault_lines(faults), builder, seen)

    def _faults_with_changes(self) -> tuple[Fault, ...]:
        try:
            check_words(self._name, self._changes)
        except ScenarioError as error:
            return error.faults
        return ()

    def _faulty_file(self, number: int, status: str, faults: list[FaultLine]) -> FaultyFile:
        return {
            "ok": True,
            "number": number,
            "status": status,
            "file": self._name,
            "faults": faults,
            "still": None if self._builder is None else self._builder.still,
            "path": self._path,
        }

    def _show(self, status: str, faults: list[FaultLine]) -> None:
        """Send all windows the state of the file."""
        self._shown = self._faulty_file(self._shown["number"] + 1, status, faults)
        news, self._news = self._news, asyncio.Event()
        news.set()

    # ----------------------------------------------------------------------------------------------------- windows

    def open_window(self, tab: str = "") -> str:
        """A new window's name."""
        name = f"window-{next(self._numbers)}"
        self._windows.add(name)
        return name

    def close_window(self, window: str) -> None:
        """A window has gone."""
        self._windows.discard(window)

    async def newest_frame(self, after: int = 0, window: str = "") -> bytes:
        """Never returns, since nothing moves."""
        await asyncio.Event().wait()
        return b""

    def only_asks(self, name: str) -> bool:
        """True: here all commands only ask."""
        return True

    async def ask(self, window: str, command: Mapping[str, Any]) -> dict[str, Any]:
        """The answer to a window's command.

        ``document`` is answered by `FaultyFile` as soon as its number is above ``after``; ``image`` by ``png`` in
        base64, of the picture of a ``name``.
        """
        match command:
            case {"do": "document", "after": after} if _NUMBER.holds(after):
                while self._shown["number"] <= after:
                    await self._news.wait()
                return dict(self._shown)
            case {"do": "image", "name": str(name)} if self._builder is not None:
                with contextlib.suppress(LookupError):
                    picture = await asyncio.to_thread(self._builder.picture, name)
                    return {"ok": True, "png": base64.b64encode(picture).decode()}
                return {"ok": False, "error": f"there is no picture {shown(name)}"}
        return {"ok": False, "error": f"expected a command, 'document' or 'image', got {shown(dict(command))}"}
