"""The session: a simulation in a child process, for windows to watch and to drive.

It runs in the server's process, and all of its state belongs to the event loop in which it was started. Of several
windows one has the controls.
"""

from __future__ import annotations

import asyncio
import contextlib
from collections.abc import Awaitable, Callable, Mapping
from pathlib import Path
from typing import Any, Self

from amorsim.core.errors import AmorsimError, did_you_mean
from amorsim.core.files.reading import is_file, is_there
from amorsim.core.files.temporary_folders import temporary_folder
from amorsim.ui.scene.wire import Scene
from amorsim.ui.simulator.child_supervisor import ChildSupervisor
from amorsim.ui.simulator.controls import Controls
from amorsim.ui.simulator.frame_buffer import FrameBuffer
from amorsim.ui.simulator.frames.messages import COMMANDS, check
from amorsim.ui.simulator.looks import Looks
from amorsim.ui.simulator.project import Saver, free_places, place_for
from amorsim.ui.simulator.recipe import Recipe

__all__ = ["Session"]

Table = Mapping[str, Any]
Answer = dict[str, Any]

# Commands of a robot, which they name or look at.
_OF_ROBOT = (
    "parameters",
    "history",
    "futures",
    "mapped",
    "intended",
    "hand_over",
    "drive",
    "command",
    "set",
    "restore",
)
_OWN = ("reload", "restart", "places", "page", "save_run", "save_scenario")

BETWEEN_LOOKS = 0.2  # [s], while an answer is waited for


class Session:
    """A simulation in a process of its own, for windows to watch and to drive.

    All of it is for the event loop in which it is started.

    Parameters
    ----------
    recipe
        What is simulated.
    out
        The folder that the run is written into as it goes, new or empty.
    project
        The folder that scenarios and runs are saved in; the present one if not given.
    patience
        After how long [s] without an answer a controller counts as hanging.
    notice
        Called with what the user should know while he waits: once, that kernels are being compiled.

    Attributes
    ----------
    reload
        Loads the scenario's file again, and returns the path of the page to go to; None where that cannot be.
    changed
        Whether that file, or one that it names, has changed since.
    moved
        The path of the page of the session that took the place of this one; empty while none did.
    """

    def __init__(
        self,
        recipe: Recipe,
        *,
        out: Path | None = None,
        project: Path | None = None,
        patience: float = 5.0,
        notice: Callable[[str], None] | None = None,
    ) -> None:
        self.recipe = recipe
        self.project = (project or Path.cwd()).absolute()
        self._saver = Saver(self.project, recipe)
        self._controls = Controls()
        self._looks = Looks()
        self._frame_buffer = FrameBuffer(lambda now: self._supervisor.ask_frame(self._looks.robots, now=now))
        self._supervisor = ChildSupervisor(
            recipe, out=out, patience=patience, notice=notice, frame_buffer=self._frame_buffer
        )
        self._state: Answer = {}  # the child's last answer
        self.reload: Callable[[], Awaitable[str]] | None = None
        self.changed = False
        self.moved = ""

    # ----------------------------------------------------------------------------------------------- beginning and end

    async def start(self) -> Scene:
        """Start the simulation; returns its scene once it is made.

        Raises
        ------
        AmorsimError
            If the scenario cannot be simulated, with the message of `amorsim run`.
        """
        return await self._supervisor.start()

    async def close(self) -> None:
        """End the simulation, with whole files, within two seconds; again if one likes."""
        self._saver.close()
        await self._supervisor.close()

    async def __aenter__(self) -> Self:
        await self.start()
        return self

    async def __aexit__(self, *_: object) -> None:
        await self.close()

    @property
    def scene(self) -> Scene:
        """All that stays as it is while the simulation runs."""
        return self._supervisor.scene

    @property
    def remarks(self) -> list[str]:
        """For the user, at the start."""
        return self._supervisor.remarks

    @property
    def folder(self) -> str:
        """The folder that the run is or was written into; None if there is none."""
        link = self._supervisor.link
        folder = link.folder if link is not None else ""
        return folder if folder and is_file(Path(folder, "run.json")) else ""

    # --------------------------------------------------------------------------------------------------------- windows

    def open_window(self, tab: str = "") -> str:
        """Open a new window, which watches; returns its name. The first has the controls (`Controls`)."""
        return self._controls.open(tab)

    def close_window(self, window: str) -> None:
        """Forget a window; robots that it drove by hand stop."""
        self._looks.close(window)
        if self._controls.close(window):
            with contextlib.suppress(AmorsimError):
                self._supervisor.send({"do": "stop"})

    @property
    def holder(self) -> str:
        """The window that has the controls, or empty."""
        return self._controls.holder

    async def newest_frame(self, after: int = 0, window: str = "") -> bytes:
        """The newest frame whose number is above `after`, as soon as there is one; never, once the session has ended.

        It holds all values of the robot that the window looks at. Frames are made only while a window waits for one, at
        most 40 in a second.
        """
        return await self._frame_buffer.newest(after, lambda: self._looks.of(window))

    # -------------------------------------------------------------------------------------------------------- commands

    def only_asks(self, name: str) -> bool:
        """Whether a command only asks: such are answered at once, others in the order in which they came."""
        return name in COMMANDS and COMMANDS[name].asks

    async def ask(self, window: str, command: Table) -> Answer:
        """The answer to a window's command (see `amorsim.ui.simulator.frames.messages`)."""
        try:
            if not self._controls.knows(window):
                raise AmorsimError("this window is not known any more; load the page again")
            shape = check(command)
            if shape.controls and self.holder != window:
                raise AmorsimError("another window has the controls; ask for them")
            return await self._carry_out(window, command)
        except AmorsimError as error:
            return {"ok": False, "error": str(error)}

    async def request(self, command: Table) -> Answer:
        """The answer to a command from Python, which needs no window and no controls."""
        try:
            return await self._carry_out("", command)
        except AmorsimError as error:
            return {"ok": False, "error": str(error)}

    async def _carry_out(self, window: str, command: Table) -> Answer:
        name = command.get("do")
        if name == "controls":
            return self._controls.carry_out(window, command)
        if name == "select":
            return self._select(window, command)
        if name in _OWN:
            return await self._own(command)
        if name == "scene":
            return {"ok": True, "scene": self.scene}
        if name == "state":
            more = {"selected": self._looks.of(window), "changed": self.changed}
            return {**await self._answer_state(command), **more, **({"moved": self.moved} if self.moved else {})}
        if self._supervisor.hang is not None:
            raise AmorsimError(f"the simulation does not answer: {self._supervisor.hang['text']}")
        answer = await self._supervisor.send(self._with_robot(window, command))
        if name == "replica" and answer["ok"]:
            self._supervisor.scene = answer["scene"]
        self._frame_buffer.spoil()
        return answer

    def _select(self, window: str, command: Table) -> Answer:
        """Select a robot in a window; other windows keep theirs."""
        names = [robot["name"] for robot in self.scene["robots"]]
        robot = command.get("robot")
        if isinstance(robot, str) and robot in names:
            robot = names.index(robot)
        if not isinstance(robot, int) or isinstance(robot, bool) or not 0 <= robot < len(names):
            hint = did_you_mean(str(robot), names) if isinstance(robot, str) else ""
            raise AmorsimError(f"expected a robot's name or its place from 0 to {len(names) - 1}, got {robot!r}.{hint}")
        self._looks.turn(window, robot)
        self._frame_buffer.turn()
        return {"ok": True}

    def _with_robot(self, window: str, command: Table) -> Table:
        if command.get("do") in _OF_ROBOT and "robot" not in command:
            return {**command, "robot": self._looks.of(window)}
        return command

    async def _own(self, command: Table) -> Answer:
        name, supervisor = command["do"], self._supervisor
        if name == "reload":
            if self.reload is None:
                raise AmorsimError("there is no file to load again")
            return {"ok": True, "path": await self.reload()}
        if name == "restart":
            return await supervisor.restart(command.get("without"))
        if name == "places":
            return {"ok": True, "project": str(self.project), **free_places(self.project, self.scene["scenario"])}
        if name == "page":
            return {"ok": True, "page": await self._page()}
        if name == "save_run":
            job = await supervisor.demand({"do": "job"})
            answer = await self._saver.save(job, command.get("name"), self.scene["scenario"])
            supervisor.remark("saved", f"the run was saved in {answer['folder']}")
            return answer
        file = place_for(self.project, command.get("name"), ".toml")
        if is_there(file) and not command.get("overwrite"):
            raise AmorsimError(f"{file.name} is there already; name another file")
        await supervisor.demand({"do": "write_scenario", "file": str(file)})
        supervisor.remark("saved", f"the scenario was saved as {file.relative_to(self.project)}")
        return {"ok": True, "file": str(file)}

    async def _page(self) -> str:
        """The run as one HTML file that plays by itself; a simulation is repeated up to its newest moment for it."""
        from amorsim.ui.run_page.html_file import run_page  # with the engine, which the server does not need

        with temporary_folder("page") as folder:
            run, replica = Path(self.recipe.name), None
            if self.recipe.is_recorded:
                replica = self.scene["recorded"]["replica"]
            else:
                job = await self._supervisor.demand({"do": "job"})
                await self._saver.save(job, "run", self.scene["scenario"], within=folder)
                run = folder / "run"
            page = await asyncio.to_thread(run_page, run, folder / "page.html", replica=replica)
            return page.read_text(encoding="utf-8")

    async def _answer_state(self, command: Table) -> Answer:
        supervisor = self._supervisor
        if supervisor.hang is None:
            try:
                answer = supervisor.send(command)
                while not (await asyncio.wait([answer], timeout=BETWEEN_LOOKS))[0]:
                    if supervisor.is_compiling and self._state:
                        answer.cancel()
                        return {**self._state, "status": "compiling", **self._controls.state()}
                self._state = answer.result()
            except AmorsimError:
                if supervisor.hang is None and not self._state:
                    raise
        return {**self._state, **supervisor.trouble(), **self._controls.state()}
