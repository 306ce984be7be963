"""Commands about the project: other scenarios, worlds and models as files, programs, pictures, differences."""

from __future__ import annotations

import asyncio
import base64
import io
import re
import zipfile
from collections.abc import Mapping
from importlib import resources
from pathlib import Path
from typing import TYPE_CHECKING, Any

from amorsim.core.errors import AmorsimError
from amorsim.core.files.temporary_folders import temporary_folder
from amorsim.core.numbers import is_number
from amorsim.plugins.manager import default_registry
from amorsim.ui.editor.reader import Reader
from amorsim.ui.editor.storage.disk_differences import differing_lines
from amorsim.ui.editor.storage.edited_files import PROGRAM
from amorsim.ui.editor.storage.formats import map_files
from amorsim.ui.editor.storage.line_ends import with_line_ends
from amorsim.ui.editor.storage.recent import recent_files
from amorsim.ui.editor.storage.world_map import take_map
from amorsim.ui.editor.work import Work
from amorsim.ui.serve.wire import shown
from amorsim.ui.simulator.project import place_for

if TYPE_CHECKING:
    from amorsim.ui.editor.session import EditSession

__all__ = ["ASKS", "Projects"]

ASKS = (
    *("difference", "others", "card", "manual", "zip", "picture", "preview", "histogram"),
    *("starts", "clearance", "code", "worlds"),
)
MOST_LISTED = 200  # files of the project that are listed
LONGEST_BENCH = 240.0  # [s] of an experiment, or of writing a world: their kernels may have to be compiled
LONGEST_CODE = 1_000_000  # letters

Answer = dict[str, Any]


class Projects:
    """The commands of a session that are about more than its document."""

    def __init__(self, session: EditSession) -> None:
        self._session = session
        self._bench = Reader(LONGEST_BENCH)

    def close(self) -> None:
        """End experiments; calling it again does nothing."""
        self._bench.close()

    async def answer(self, command: Mapping[str, Any]) -> Answer | None:
        """The answer to a command; None if the command is unknown here."""
        work = self._session.work
        match command:
            case {"do": "difference"}:
                return {"ok": True, "text": "\n".join(await asyncio.to_thread(differing_lines, work))}
            case {"do": "others"}:
                return {"ok": True, **await asyncio.to_thread(self._others)}
            case {"do": "open", "name": str(name)}:
                return {"ok": True, "path": await self._session.open_other(self._openable(name))}
            case {"do": "card", "kind": str(kind), "name": str(name)}:
                asked = {"kind": kind, "name": name, "folder": work.folder}
                return {"ok": True, **await asyncio.to_thread(self._bench.ask, "card", **asked)}
            case {"do": "manual", "kind": str(kind), "name": str(name)}:
                return {"ok": True, "manual": await asyncio.to_thread(self._bench.ask, "manual", kind=kind, name=name)}
            case {"do": "zip"}:
                return {"ok": True, "zip": await asyncio.to_thread(self._zip)}
            case {"do": "picture", "kind": "png" | "svg" as kind}:
                picture = await self._ask("picture_of_world", kind=kind, title=work.name)
                return {"ok": True, "data": picture}
            case {"do": "worlds"}:
                return {"ok": True, "files": await asyncio.to_thread(self._maps)}
            case {"do": "write_world", "name": name, "is_trial": bool(is_trial)}:
                return await self._write_world(name, is_trial, use=command.get("use") is True)
            case {"do": "make_lines", "is_trial": bool(is_trial)}:
                return await self._make_lines(is_trial)
            case {"do": "save_model", "path": str(path), "name": name}:
                sensor = command.get("sensor", "")
                parent = self._parent(path, str(sensor))
                file = place_for(work.folder, name, ".toml")
                asked = {"thing": path, "sensor": str(sensor), "target": file, "parent": parent}
                return {"ok": True, "file": file.name, "text": await self._ask("save_model", **asked)}
            case {"do": "preview", "robot": str(robot)}:
                return {"ok": True, **await self._experiment("square", robot=robot)}
            case {"do": "histogram", "robot": str(robot), "sensor": str(sensor)}:
                return {"ok": True, **await self._experiment("noise", robot=robot, sensor=sensor)}
            case {"do": "clearance", "x": x, "y": y} if is_number(x, below=1e6) and is_number(y, below=1e6):
                gap = await asyncio.to_thread(self._session.reader.ask, "clearance", x=float(x), y=float(y))
                return {"ok": True, "gap": gap}
            case {"do": "starts"}:
                return {
                    "ok": True,
                    "starts": await asyncio.to_thread(self._bench.ask, "starts", **self._session.asked()),
                }
            case {"do": "code", "file": name}:
                held = work.program(self._program(name))
                return {"ok": True, "text": held.text or _template(), "is_saved": held.text == held.saved}
            case {"do": "write_code", "file": name, "text": str(text)} if len(text) <= LONGEST_CODE:
                program = self._program(name)
                self._write_code(program, text, command.get("controller"))
                return {"ok": True, "file": program}
            case {"do": "save_code", "file": name, "text": str(text)} if len(text) <= LONGEST_CODE:
                program = self._program(name)
                self._session.meant[work.here / program] = self._write_code(program, text)
                is_saved = work.save_program(program)
                self._session.touched()
                return {"ok": True, "file": program, "is_saved": is_saved}
        return None

    # --------------------------------------------------------------------------------------------------------- reading

    async def _ask(self, name: str, **arguments: Any) -> Any:
        """Call a function of the reading process on the document as it is now."""
        reader = self._session.reader
        await asyncio.to_thread(reader.ask, "look", **self._session.asked())
        return await asyncio.to_thread(reader.ask, name, **arguments)

    async def _experiment(self, name: str, **arguments: Any) -> Answer:
        if self._session.has_code:
            raise AmorsimError("this scenario has programs of its own, which are not run for a preview")
        asked = self._session.asked()
        found: Answer = await asyncio.to_thread(
            self._bench.ask, name, text=asked["text"], path=asked["path"], **arguments
        )
        return found

    # ----------------------------------------------------------------------------------------------------------- files

    def _others(self) -> Answer:
        """Scenarios that can be opened: recent ones, those of the project, and the bundled ones."""
        work = self._session.work
        state = work.state
        files = sorted(work.folder.glob("*.toml"))[:MOST_LISTED]
        return {
            "recent": [] if state is None else recent_files(state),
            "files": [path.name for path in files if _is_scenario(path)],
            "bundled": list(default_registry().names("scenario")),
        }

    def _openable(self, name: str) -> str:
        """The documents a window may open: an empty page, a bundled scenario, a recent one, or one of the project."""
        work = self._session.work
        if not name or name in default_registry().names("scenario"):
            return name
        if work.state is not None and name in recent_files(work.state):
            return name
        return str(place_for(work.folder, name, ".toml"))

    def _maps(self) -> list[str]:
        """Files of the project that may be maps."""
        return map_files(self._session.work.folder, default_registry())

    def _zip(self) -> str:
        """The scenario as it is now, with all files that it names, in base 64."""
        work = self._session.work
        data = io.BytesIO()
        with temporary_folder("zip") as folder:
            asked = self._session.asked()
            top = folder / work.name
            top.mkdir()
            work.view(asked["folder"]).save(top / f"{work.name}.toml", copy=True)
            with zipfile.ZipFile(data, "w", zipfile.ZIP_DEFLATED) as archive:
                for file in sorted(top.rglob("*")):
                    if file.is_file():
                        archive.write(file, file.relative_to(folder).as_posix())
        return base64.b64encode(data.getvalue()).decode()

    async def _write_world(self, name: Any, is_trial: bool, *, use: bool) -> Answer:
        """Write the world in the format of a name's ending; `use` lets the scenario name that file."""
        work = self._session.work
        target = place_for(work.folder, name)
        await asyncio.to_thread(self._bench.ask, "look", **self._session.asked())
        found = await asyncio.to_thread(self._bench.ask, "write_world", target=target, is_trial=is_trial, force=False)
        if use and not is_trial:
            work.edit(
                f"take {target.name} as the world", lambda work: take_map(work.document, target, found["options"])
            )
            self._session.touched()
        return {"ok": True, "file": target.name, **found}

    async def _make_lines(self, is_trial: bool) -> Answer:
        """Make the world's walls a line world that can be drawn in, as one step; a save writes it."""
        work = self._session.work
        if not work.world.walls_fixed:
            raise AmorsimError("walls can be drawn in this world as it is")
        path = work.world.free_file()
        await asyncio.to_thread(self._bench.ask, "look", **self._session.asked())
        with temporary_folder("world") as folder:
            target = folder / path.name
            found = await asyncio.to_thread(self._bench.ask, "write_world", target=target, is_trial=False, force=False)
            text = await asyncio.to_thread(target.read_text, encoding="utf-8")
        if not is_trial:
            work.edit("make the walls a file", lambda work: work.world.become_lines(path, text, found["options"]))
            self._session.touched()
        return {"ok": True, "file": path.name, **found}

    def _parent(self, path: str, sensor: str) -> str:
        """The model that a robot or a sensor builds on: its name, or the path of its file."""
        work = self._session.work
        at = f"{path}.sensors.{sensor}.model" if sensor else f"{path}.model"
        try:
            model = work.document.get(at)
        except AmorsimError:
            return ""
        if not isinstance(model, str):
            return ""
        return str(work.document.path.absolute().parent / model) if model.endswith(".toml") else model

    # -------------------------------------------------------------------------------------------------------- programs

    def _program(self, name: Any) -> str:
        """The name of a program in the project's folder."""
        if not self._session.may_run_code:
            raise AmorsimError(
                "other machines can reach this window, so no programs are taken; start the Editor with --allow-code, "
                "or without --host"
            )
        if not isinstance(name, str) or not name.endswith(".py"):
            raise AmorsimError(f"expected the name of a file of Python such as my_controller.py, got {shown(name)}")
        folder = self._session.work.folder
        return place_for(folder, name, PROGRAM).relative_to(folder).as_posix()

    def _write_code(self, program: str, typed: str, controller: Any = None) -> str:
        """Replace the text of a program, as one step; a new one becomes the controller at a path. Returns the text."""
        work = self._session.work
        held = work.program(program)
        if controller is not None and held.text:
            raise AmorsimError(f"{program} is there already; name another file")
        text = with_line_ends(typed, held.text)
        if held.text == text:
            return text

        def change(work: Work) -> None:
            work.set_program(program, text)
            if isinstance(controller, str):
                work.document.set(controller, {"use": f"{program}:{_first_name(text)}"})

        work.edit(f"write {program}", change)
        if controller is not None:
            self._session.meant[work.here / program] = text
        self._session.touched()
        return text


def _template() -> str:
    """The controller that `amorsim new` begins with."""
    return (resources.files("amorsim.cli") / "template" / "controller.py").read_text(encoding="utf-8")


def _first_name(text: str) -> str:
    """The name of the first function or class of a program."""
    found = re.search(r"^(?:def|class) +(\w+)", text, re.MULTILINE)
    return found[1] if found else "drive"


def _is_scenario(path: Path) -> bool:
    try:
        head = path.read_text(encoding="utf-8", errors="replace")[:20_000]
    except OSError:
        return False
    return "[world]" in head or "[[robots]]" in head
