"""The session of the Editor: a document that windows see and one of them changes.

All of it is for the event loop in which it is started. No code of a user's runs in it; runs are processes of their own.
"""

from __future__ import annotations

import asyncio
import base64
import contextlib
import sys
import tempfile
import traceback
from collections.abc import Awaitable, Callable, Mapping
from pathlib import Path
from typing import Any, Self

from amorsim.core.errors import AmorsimError
from amorsim.core.trouble import error_in_words
from amorsim.plugins.manager import default_registry
from amorsim.plugins.registry import Registry
from amorsim.ui.editor.changes import apply, own_table
from amorsim.ui.editor.inspector import inspect
from amorsim.ui.editor.looking import Looked, look
from amorsim.ui.editor.work import ChangedError, Work
from amorsim.ui.serve.wire import shown, whole
from amorsim.ui.simulator.controls import Controls
from amorsim.ui.simulator.project import place_for

__all__ = ["EditSession"]

BETWEEN_LOOKS = 1.0  # [s], at whether something else has changed the files
LONGEST_LABEL = 80
MOST_TABLES = 2000

_NUMBER = whole(0)
_ASKS = ("document", "inspect", "image", "text", "menu", "tables")

Answer = dict[str, Any]
Table = Mapping[str, Any]


async def _no_run(_: Path) -> str:
    raise AmorsimError("nothing can be run here")


class EditSession:
    """A scenario that is being edited, for windows: one of them holds the pen, the others watch.

    Parameters
    ----------
    work
        What is edited.
    run
        Starts the simulation of a scenario's file; returns the path of its page.
    """

    def __init__(
        self,
        work: Work,
        *,
        registry: Registry | None = None,
        run: Callable[[Path], Awaitable[str]] = _no_run,
    ) -> None:
        self.work = work
        self._registry = registry or default_registry()
        self._run = run
        self._controls = Controls()
        self._looked = Looked(faults=[], things=[], builder=None)
        self._number = 1
        self._drawn = 0  # the number at which what is drawn was new
        self._is_behind = True
        self._changed_outside: list[str] = []
        self._news = asyncio.Event()
        self._wanted = asyncio.Event()
        self._tasks: list[asyncio.Task[None]] = []
        self._folder = tempfile.TemporaryDirectory(prefix="amorsim-edit-", ignore_cleanup_errors=True)

    def start(self) -> None:
        """Read the document, and look whether something else changes its files, from now on."""
        self._wanted.set()
        loop = asyncio.get_running_loop()
        self._tasks = [loop.create_task(self._look()), loop.create_task(self._watch())]

    async def close(self) -> None:
        """End it; again if one likes."""
        for task in self._tasks:
            task.cancel()
        await asyncio.gather(*self._tasks, return_exceptions=True)
        self.work.close()
        self._folder.cleanup()

    async def __aenter__(self) -> Self:
        self.start()
        return self

    async def __aexit__(self, *_: object) -> None:
        await self.close()

    # --------------------------------------------------------------------------------------------------------- looking

    async def _look(self) -> None:
        folder = Path(self._folder.name) / "maps"
        while True:
            await self._wanted.wait()
            self._wanted.clear()
            work = self.work
            name = f"{work.name}.toml"
            try:
                view, text, values = work.view(folder), work.text, work.document.values
            except (AmorsimError, OSError) as error:
                self._looked = Looked.failed(name, str(error))
            else:
                self._looked = await asyncio.to_thread(look, view, text, values, name, folder)
            self._is_behind = self._wanted.is_set()
            self._tell(is_drawn=True)

    async def _watch(self) -> None:
        while True:
            await asyncio.sleep(BETWEEN_LOOKS)
            changed = [path.name for path in await asyncio.to_thread(lambda: self.work.files_changed)]
            if changed != self._changed_outside:
                self._changed_outside = changed
                self._tell()

    def _tell(self, *, is_drawn: bool = False) -> None:
        self._number += 1
        if is_drawn:
            self._drawn = self._number
        news, self._news = self._news, asyncio.Event()
        news.set()

    def _touched(self) -> None:
        """The document is another: it is read again."""
        self._is_behind = True
        self._wanted.set()
        self._tell()

    def state(self, after: int = 0) -> Answer:
        """How the document stands; with what is drawn where that is newer than a number."""
        work, looked = self.work, self._looked
        answer: Answer = {
            "ok": True,
            "number": self._number,
            "name": f"{work.name}.toml",
            "file": "" if work.is_new else str(work.path),
            "folder": str(work.folder),
            "map": "" if work.map is None else work.map.name,
            "walls_fixed": work.walls_fixed,
            "is_saved": work.is_saved,
            "is_new": work.is_new,
            "is_behind": self._is_behind,
            "remark": work.remark,
            "changed_outside": self._changed_outside,
            "undo": work.history.done[-1].label if work.history.done else "",
            "redo": work.history.undone[-1].label if work.history.undone else "",
            "steps": len(work.history.done),
            **self._controls.told(),
        }
        if self._drawn > after:
            answer["drawn"] = {
                "faults": looked.faults,
                "things": looked.things,
                "still": None if looked.builder is None else looked.builder.still,
            }
        return answer

    # --------------------------------------------------------------------------------------------------------- windows

    def open_window(self, tab: str = "") -> str:
        """A new window's name; the first holds the pen."""
        window = self._controls.open(tab)
        self._tell()
        return window

    def close_window(self, window: str) -> None:
        """A window has gone."""
        self._controls.close(window)
        self._tell()

    async def newest_frame(self, after: int = 0, window: str = "") -> bytes:
        """Nothing, for nothing moves: it never returns."""
        await asyncio.Event().wait()
        return b""

    def only_asks(self, name: str) -> bool:
        """Whether a command only asks."""
        return name in _ASKS

    async def ask(self, window: str, command: Table) -> Answer:
        """The answer to a window's command."""
        try:
            name = command.get("do")
            if name not in _ASKS and name != "controls" and self._controls.holder != window:
                raise AmorsimError("another window holds the pen; this one watches")
            if name == "controls":
                answer = self._controls.carry_out(window, command)
                self._tell()
                return answer
            return await self.request(command)
        except AmorsimError as error:
            return {"ok": False, "error": str(error)}

    async def request(self, command: Table) -> Answer:
        """The answer to a command, whoever holds the pen.

        ``document`` is answered by `state` once its number is above ``after``; ``inspect`` by the ``sections`` of a
        thing, ``text`` by the scenario's text, ``image`` by a picture of a map, ``menu`` by what can be added.
        ``edit`` makes a step of ``changes`` (see `amorsim.ui.editor.changes`); ``undo``, ``redo``, ``save``,
        ``save_as``, ``reload`` and ``run`` do what they say; after ``heard``, the remark is told no more.
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
                return {"ok": True, "tables": [own_table(work, path) for path in paths]}
            case {"do": "menu"}:
                names = {kind: list(self._registry.names(kind)) for kind in ("robot", "motion", "controller")}
                return {"ok": True, **names}
            case {"do": "image", "name": str(name)} if self._looked.builder is not None:
                with contextlib.suppress(LookupError):
                    picture = await asyncio.to_thread(self._looked.builder.picture, name)
                    return {"ok": True, "png": base64.b64encode(picture).decode()}
                raise AmorsimError(f"there is no picture {shown(name)}")
            case {"do": "edit", "label": str(label), "changes": changes}:
                added = work.edit(label[:LONGEST_LABEL], lambda work: apply(work, changes))
                self._touched()
                return {"ok": True, "added": added}
            case {"do": "undo" | "redo" as which}:
                label = work.undo() if which == "undo" else work.redo()
                self._touched()
                return {"ok": True, "label": label}
            case {"do": "save"}:
                file = work.save(force=command.get("force") is True)
                self._changed_outside = []
                self._tell()
                return {"ok": True, "file": str(file)}
            case {"do": "save_as", "name": name}:
                file = work.save_as(place_for(work.folder, name, ".toml"), overwrite=command.get("overwrite") is True)
                self._touched()
                return {"ok": True, "file": str(file)}
            case {"do": "heard"}:
                work.remark = ""
                self._tell()
                return {"ok": True}
            case {"do": "reload"}:
                work.reload()
                work.remark = ""
                self._changed_outside = []
                self._touched()
                return {"ok": True}
            case {"do": "run"}:
                return {"ok": True, "path": await self._start_run()}
        raise AmorsimError(f"there is no command {shown(dict(command))}")

    async def _start_run(self) -> str:
        """Let the simulation of the document as it is now begin."""
        folder = Path(self._folder.name)
        view = self.work.view(folder / "maps")
        file = Path(tempfile.mkdtemp(prefix="run-", dir=folder)) / f"{self.work.name}.toml"
        view.save(file)
        return await self._run(file)
