"""The session of the Editor: a document that several windows show and one of them changes.

It belongs to the event loop that it is started in. The document is read in a process of its own, which can be ended.
Users' programs are checked and run in others.
"""

from __future__ import annotations

import asyncio
import base64
import sys
import tempfile
import traceback
from collections.abc import Awaitable, Callable, Mapping
from pathlib import Path
from typing import Any, Self

from amorsim.core.error_text import error_in_words
from amorsim.core.errors import AmorsimError
from amorsim.plugins.manager import default_registry
from amorsim.plugins.registry import Registry
from amorsim.scenario.documents.elsewhere import named_files
from amorsim.ui.editor.changes import apply, own_table
from amorsim.ui.editor.inspectors.inspector import inspect
from amorsim.ui.editor.looking import FaultAt, Looked
from amorsim.ui.editor.reader import Reader
from amorsim.ui.editor.storage.edited_files import PROGRAM
from amorsim.ui.editor.storage.formats import written_endings
from amorsim.ui.editor.storage.passing import PassingFolder
from amorsim.ui.editor.storage.projects import ASKS, Projects
from amorsim.ui.editor.work import ChangedError, Work
from amorsim.ui.serve.wire import shown, whole
from amorsim.ui.simulator.controls import Controls
from amorsim.ui.simulator.project import place_for

__all__ = ["EditSession"]

BETWEEN_LOOKS = 1.0  # [s], at whether something else has changed the files, and whether the pen is to be passed on
LONGEST_LABEL = 80
MOST_TABLES = 2000

_NUMBER = whole(0)
_ASKS = ("document", "inspect", "image", "text", "menu", "tables", *ASKS)

Answer = dict[str, Any]
Table = Mapping[str, Any]


async def _no_run(_: Path) -> str:
    raise AmorsimError("nothing can be run here")


async def _no_other(_: str) -> str:
    raise AmorsimError("nothing else can be opened here")


class EditSession:
    """A scenario that windows edit: one of them may change it, the others watch.

    Parameters
    ----------
    work
        What is edited.
    run
        Starts the simulation of a scenario's file; returns the path of its page.
    open_other
        Opens another scenario; returns the path of its page.
    may_run_code
        Whether a user's programs may be run to check them, in a process of their own.
    reader
        The process that reads the document, which is left open then; one of its own if none is given.
    """

    def __init__(
        self,
        work: Work,
        *,
        registry: Registry | None = None,
        run: Callable[[Path], Awaitable[str]] = _no_run,
        open_other: Callable[[str], Awaitable[str]] = _no_other,
        may_run_code: bool = False,
        reader: Reader | None = None,
    ) -> None:
        self.work = work
        self.may_run_code = may_run_code
        self.reader = reader or Reader()
        self._owns_reader = reader is None
        self._checker = Reader()
        self._projects = Projects(self)
        self._registry = registry or default_registry()
        self.run = run
        self.open_other = open_other
        self._controls = Controls()
        self._looked = Looked(faults=[], things=[], still=None)
        self._code_faults: list[FaultAt] = []
        self.meant: dict[Path, str] = {}  # programs that may be tried before they are saved
        self._is_checking = False
        self._number = 1
        self._drawn = 0  # the number at which what is drawn was new
        self._is_behind = True
        self._changed_outside: list[str] = []
        self._gone_outside: list[str] = []  # those of them that were deleted
        self._news = asyncio.Event()
        self._wanted = asyncio.Event()
        self._tasks: list[asyncio.Task[None]] = []
        self._folder = PassingFolder()

    def start(self) -> None:
        """Start reading the document and watching its files."""
        self.reader.start()
        self._wanted.set()
        loop = asyncio.get_running_loop()
        self._tasks = [loop.create_task(self._look()), loop.create_task(self._watch())]

    async def close(self) -> None:
        """End the session; calling it again does nothing."""
        for task in self._tasks:
            task.cancel()
        self._checker.close()
        self._projects.close()
        if self._owns_reader:
            self.reader.close()
        await asyncio.gather(*self._tasks, return_exceptions=True)
        self.work.close()
        self.forget_files()

    def forget_files(self) -> None:
        """Remove what was written for other processes; calling it again does nothing."""
        self._folder.remove()

    async def __aenter__(self) -> Self:
        self.start()
        return self

    async def __aexit__(self, *_: object) -> None:
        await self.close()

    # --------------------------------------------------------------------------------------------------------- looking

    async def _look(self) -> None:
        while True:
            await self._wanted.wait()
            self._wanted.clear()
            try:
                asked = self.asked()
                self._looked = await asyncio.to_thread(self.reader.ask, "look", **asked)
            except (AmorsimError, OSError) as error:
                self._looked = Looked.failed(f"{self.work.name}.toml", str(error))
            self._code_faults = []
            self._is_behind = self._wanted.is_set()
            self._is_checking = not self._is_behind and self.may_run_code and self.has_code and self._are_meant
            self.tell(is_drawn=True)
            if self._is_checking:
                await self._check_code(asked)

    async def _check_code(self, asked: dict[str, Any]) -> None:
        """Try the programs that the scenario names; stop when the document changes."""
        check = asyncio.create_task(asyncio.to_thread(self._checker.ask, "check_code", **asked))
        change = asyncio.create_task(self._wanted.wait())
        await asyncio.wait((check, change), return_when=asyncio.FIRST_COMPLETED)
        if not check.done():
            self._checker.kill()
        change.cancel()
        try:
            self._code_faults = await check
        except (AmorsimError, OSError) as error:
            if not self._wanted.is_set():
                self._code_faults = Looked.failed(f"{self.work.name}.toml", str(error)).faults
        self._is_checking = False
        self.tell(is_drawn=True)

    def asked(self) -> dict[str, Any]:
        """Arguments for the reading process: the document as it is now.

        Raises
        ------
        AmorsimError, OSError
            If a file cannot be written where that process finds it.
        """
        folder = self._folder.path / "files"
        view = self.work.view(folder)
        name = f"{self.work.name}.toml"
        return {"text": view.text, "path": view.path, "shown": self.work.text, "name": name, "folder": folder}

    @property
    def has_code(self) -> bool:
        """Whether the scenario names programs."""
        document = self.work.document
        here = document.path.absolute().parent
        return any(named.kind == "program" for named in named_files(document.values, self._registry, here))

    @property
    def _are_meant(self) -> bool:
        """Whether all programs are as the user saved them or asked to run them; half typed ones are not run."""
        return all(
            held.text == self.meant.get(path)
            for path, held in self.work.files.differing.items()
            if path.suffix == PROGRAM
        )

    async def _watch(self) -> None:
        while True:
            await asyncio.sleep(BETWEEN_LOOKS)
            changed = [path.name for path in await asyncio.to_thread(lambda: self.work.files_changed)]
            gone = [path.name for path in await asyncio.to_thread(lambda: self.work.files_gone)]
            has_passed = self._controls.pass_on()
            if (changed, gone) != (self._changed_outside, self._gone_outside) or has_passed:
                self._changed_outside, self._gone_outside = changed, gone
                self.tell()

    def tell(self, *, is_drawn: bool = False) -> None:
        """Wake the windows that wait for a new state; `is_drawn` is true if the drawing is new, too."""
        self._number += 1
        if is_drawn:
            self._drawn = self._number
        news, self._news = self._news, asyncio.Event()
        news.set()

    def touched(self) -> None:
        """Read the document again after a change."""
        self._is_behind = True
        self._wanted.set()
        self.tell()

    def state(self, after: int = 0) -> Answer:
        """The state of the document, with the drawing if that is newer than `after`."""
        work, looked = self.work, self._looked
        answer: Answer = {
            "ok": True,
            "number": self._number,
            "name": f"{work.name}.toml",
            "file": "" if work.is_new else str(work.path),
            "folder": str(work.folder),
            "map": "" if work.world.file is None else work.world.file.name,
            "walls_fixed": work.world.walls_fixed,
            "cells": work.world.cells,
            "is_saved": work.is_saved,
            "is_new": work.is_new,
            "is_behind": self._is_behind,
            "is_checking": self._is_checking,
            "remark": work.steps.remark,
            "changed_outside": self._changed_outside,
            "gone_outside": self._gone_outside,
            "undo": work.steps.history.done[-1].label if work.steps.history.done else "",
            "redo": work.steps.history.undone[-1].label if work.steps.history.undone else "",
            "steps": len(work.steps.history.done),
            **self._controls.state(),
        }
        if self._drawn > after:
            answer["drawn"] = {
                "faults": [*looked.faults, *self._code_faults],
                "things": looked.things,
                "still": looked.still,
            }
        return answer

    # --------------------------------------------------------------------------------------------------------- windows

    def open_window(self, tab: str = "") -> str:
        """Add a window; returns its name. The first one holds the pen."""
        window = self._controls.open(tab)
        self.tell()
        return window

    def close_window(self, window: str) -> None:
        """Remove a window."""
        self._controls.close(window)
        self.tell()

    async def newest_frame(self, after: int = 0, window: str = "") -> bytes:
        """Never returns: nothing moves here."""
        await asyncio.Event().wait()
        return b""

    def only_asks(self, name: str) -> bool:
        """Whether a command changes nothing."""
        return name in _ASKS

    async def ask(self, window: str, command: Table) -> Answer:
        """Carry out a window's command; returns the answer."""
        try:
            name = command.get("do")
            if name not in _ASKS and name != "controls" and self._controls.holder != window:
                raise AmorsimError("another window holds the pen; this one watches")
            if name == "controls":
                answer = self._controls.carry_out(window, command)
                self.tell()
                return answer
            return await self.request(command)
        except AmorsimError as error:
            return {"ok": False, "error": str(error)}

    async def request(self, command: Table) -> Answer:
        """Carry out a command, whichever window holds the pen; returns the answer.

        ``document`` is answered by `state` once its number is above ``after``; ``inspect`` by the ``sections`` of a
        thing, ``text`` by the scenario's text, ``image`` by a picture of a map, ``menu`` by what can be added.
        ``edit`` makes a step of ``changes`` (see `amorsim.ui.editor.changes`); ``undo``, ``redo``, ``save``,
        ``save_as``, ``reload`` and ``run`` do as they are called; after ``heard``, the remark is no longer shown.
        """
        try:
            return await self._answer(command)
        except ChangedError as error:
            return {"ok": False, "error": str(error), "changed": True}
        except AmorsimError as error:
            return {"ok": False, "error": str(error)}
        except Exception as error:  # what a plugin's class may raise; the window goes on, and nothing was changed
            sys.stderr.write("".join(traceback.format_exception(error)))
            return {"ok": False, "error": f"this failed: {error_in_words(error)}"}

    async def _answer(self, command: Table) -> Answer:
        work = self.work
        match command:
            case {"do": "document", "after": after} if _NUMBER.holds(after):
                while self._number <= after:
                    await self._news.wait()
                return self.state(after)
            case {"do": "inspect", "path": str(path)}:
                return {"ok": True, "path": path, "sections": inspect(work.document, path, self._registry)}
            case {"do": "text"}:
                return {"ok": True, "text": work.text}
            case {"do": "tables", "paths": [*paths]} if len(paths) <= MOST_TABLES:
                return {"ok": True, "tables": [own_table(work, path) for path in paths], "folder": str(work.here)}
            case {"do": "menu"}:
                kinds = ("robot", "motion", "controller", "world_generator")
                names = {kind: list(self._registry.names(kind)) for kind in kinds}
                return {"ok": True, **names, "writers": written_endings(self._registry)}
            case {"do": "image", "name": str(name)}:
                picture = await asyncio.to_thread(self.reader.ask, "picture", name=name)
                return {"ok": True, "png": base64.b64encode(picture).decode()}
            case {"do": "edit", "label": str(label), "changes": changes}:
                added = work.edit(label[:LONGEST_LABEL], lambda work: apply(work, changes))
                self.touched()
                return {"ok": True, "added": added}
            case {"do": "undo" | "redo" as which}:
                label = work.undo() if which == "undo" else work.redo()
                self.touched()
                return {"ok": True, "label": label}
            case {"do": "save"}:
                file = work.save(force=command.get("force") is True)
                self._changed_outside, self._gone_outside = [], []
                self.tell()
                return {"ok": True, "file": str(file)}
            case {"do": "save_as", "name": name}:
                file = work.save_as(place_for(work.folder, name, ".toml"), overwrite=command.get("overwrite") is True)
                self.touched()
                return {"ok": True, "file": str(file)}
            case {"do": "heard"}:
                work.steps.remark = ""
                self.tell()
                return {"ok": True}
            case {"do": "reload"}:
                work.reload()
                work.steps.remark = ""
                self._changed_outside, self._gone_outside = [], []
                self.touched()
                return {"ok": True}
            case {"do": "run"}:
                return {"ok": True, "path": await self._start_run()}
        answer = await self._projects.answer(command)
        if answer is None:
            raise AmorsimError(f"there is no command {shown(dict(command))}")
        return answer

    async def _start_run(self) -> str:
        """Start a simulation of the document as it is now; returns the path of its page."""
        folder = self._folder.path
        view = self.work.view(folder / "files")
        file = Path(tempfile.mkdtemp(prefix="run-", dir=folder)) / f"{self.work.name}.toml"
        view.save(file)
        return await self.run(file)
