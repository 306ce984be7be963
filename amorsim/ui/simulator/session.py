"""The session: it keeps the child process, and is what windows talk to.

It runs in the server's process. The child is started, watched and, where it hangs or is gone, started again and led to
where it was, without the controller that held it up. Of several windows one has the controls.
"""

from __future__ import annotations

import asyncio
import concurrent.futures
import contextlib
import threading
import time
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from amorsim.core.errors import AmorsimError, did_you_mean
from amorsim.kernels import COMPILING
from amorsim.runs.folder import next_folder
from amorsim.ui.simulator.controls import Controls
from amorsim.ui.simulator.link import Link
from amorsim.ui.simulator.looks import Looks
from amorsim.ui.simulator.mailbox import Mailbox
from amorsim.ui.simulator.messages import check
from amorsim.ui.simulator.packing import Bundle
from amorsim.ui.simulator.project import Saver, free_places, place_for
from amorsim.ui.simulator.protocol import Scene
from amorsim.ui.simulator.recipe import Recipe
from amorsim.ui.simulator.story import line_of

__all__ = ["Session"]

Table = Mapping[str, Any]
Answer = dict[str, Any]

_OF_ROBOT = ("parameters", "history", "hand_over", "drive", "command", "set", "restore")  # which they name, or look at
_OWN = ("restart", "places", "save_run", "save_scenario")

BETWEEN_PINGS = 0.5  # [s]
BETWEEN_LOOKS = 0.2  # [s], while an answer is waited for
LONGEST_INTERRUPT = 1.0  # [s] that a controller gets to be broken off
LONGEST_ANSWER = 600.0  # [s]
LONGEST_START = 300.0  # [s], compiling included


class Session:
    """A simulation in a process of its own, for windows to watch and to drive.

    Parameters
    ----------
    recipe
        What is simulated.
    out
        The folder that the run is written into as it goes, new or empty.
    project
        The folder that scenarios and runs are saved in; the present one if not given.
    patience
        After how long [s] without an answer a controller is said to hang.
    notice
        Called in a thread with what the user should know while he waits: once, that kernels are being compiled.
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
        self.remarks: list[str] = []  # for the user, at the start
        self._saver = Saver(self.project, recipe)
        self._out = out
        self._patience = patience
        self._notice = notice
        self._is_compiling = False
        self._link: Link | None = None
        self._scene: Scene | None = None
        self._controls = Controls()
        self._looks = Looks()
        self._mailbox = Mailbox(self._ask_frame)
        self._epoch = 0
        self._hang: dict[str, Any] | None = None  # what the child, or its end, tells of a controller that hangs
        self._state: Answer = {}
        self._kept: dict[str, Answer] = {}  # commands whose effect outlasts a child
        self._is_closed = threading.Event()
        self._closing = threading.Lock()

    # ----------------------------------------------------------------------------------------------- beginning and end

    def start(self) -> Scene:
        """Start the simulation; returns its scene once it is made.

        Raises
        ------
        AmorsimError
            If the scenario cannot be simulated, with what `amorsim run` would say.
        """
        self._begin({"inputs": [], "tick": 0})
        threading.Thread(target=self._watch, name="amorsim-watch", daemon=True).start()
        assert self._scene is not None
        return self._scene

    def _begin(self, rest: dict[str, Any], carried: bytes | None = None) -> str:
        """Start a child; returns from where it was led to where the last one was, in words."""
        order = {
            "recipe": self.recipe.to_json(),
            "out": str(self._out) if self._out else "",
            "epoch": self._epoch,
            **rest,
        }
        link = Link(order, carried=carried, on_frame=self._take_frame, on_end=self._ended)
        self._link = link
        try:
            ready = self._await_ready(link)
        except BaseException:
            link.close(0.0)
            raise
        self._scene, self.remarks = ready["scene"], ready["remarks"]
        self._hang, self._is_compiling = None, False
        self._mailbox.move_on()
        with contextlib.suppress(AmorsimError):
            self._state = link.send({"do": "state"}).result(LONGEST_START)  # to be told where it can tell no other
        if not link.is_alive:
            self._ended(link)
        return str(ready["since"])

    def _await_ready(self, link: Link) -> Answer:
        """What it says when it is ready; the user is told what takes so long."""
        deadline = time.monotonic() + LONGEST_START
        sign: concurrent.futures.Future[Answer] | None = None
        while True:
            try:
                return link.ready.result(BETWEEN_PINGS)
            except concurrent.futures.TimeoutError:
                if time.monotonic() > deadline:
                    raise AmorsimError(f"the simulation was not ready after {LONGEST_START:g} s") from None
            with contextlib.suppress(AmorsimError):  # it has ended, which is about to be told
                if sign is not None and sign.done():
                    self._look_for_compiler(sign.result())
                    sign = None
                sign = sign or link.send({"do": "ping"})

    def _look_for_compiler(self, sign: Answer) -> None:
        is_compiling = sign.get("compiling", False)
        if is_compiling and self._notice is not None:
            self._notice(COMPILING)
            self._notice = None
        self._is_compiling = is_compiling

    def close(self) -> None:
        """End the simulation, with whole files, within two seconds; in any thread, and again if one likes."""
        self._is_closed.set()
        self._saver.close()
        with self._closing:
            if self._link is not None:
                self._link.close()

    @property
    def folder(self) -> str:
        """The folder that the run is written into, or was until the end; nothing where there is none."""
        folder = self._link.folder if self._link is not None else ""
        return folder if folder and Path(folder, "run.json").is_file() else ""

    def __enter__(self) -> Session:
        self.start()
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    # --------------------------------------------------------------------------------------------------------- windows

    def open_window(self, tab: str = "") -> str:
        """Let a new window watch; returns the word by which it is known. The first has the controls (`Controls`)."""
        return self._controls.open(tab)

    def close_window(self, window: str) -> None:
        """Let a window go; what it drove by hand stands."""
        self._looks.close(window)
        if self._controls.close(window):
            with contextlib.suppress(AmorsimError):
                self._send({"do": "stop"})

    @property
    def holder(self) -> str:
        """The window that has the controls, or nothing."""
        return self._controls.holder

    # -------------------------------------------------------------------------------------------------------- commands

    @property
    def scene(self) -> Scene:
        """All that stays as it is while the simulation runs."""
        if self._scene is None:
            raise AmorsimError("the simulation has not been started")
        return self._scene

    async def ask(self, window: str, command: Table) -> Answer:
        """The answer to a window's command (see `amorsim.ui.simulator.messages`)."""
        name = command.get("do")
        try:
            if not self._controls.knows(window):
                raise AmorsimError("this window is not known any more; load the page again")
            shape = check(command)
            if name == "controls":
                return self._controls.carry_out(window, command)
            if name == "select":
                return self._select(window, command)
            if shape.controls and self.holder != window:
                raise AmorsimError("another window has the controls; ask for them")
            if name in _OWN:
                return await asyncio.to_thread(self._own, command)
            if name == "scene":
                return {"ok": True, "scene": self.scene}
            if name == "state":
                return {**await self._told_state(command), "selected": self._looks.of(window)}
            if self._hang is not None:
                raise AmorsimError(f"the simulation does not answer: {self._hang['text']}")
            answer = await asyncio.wrap_future(self._send(self._with_robot(window, command)))
            self._mailbox.spoil()
            return answer
        except AmorsimError as error:
            return {"ok": False, "error": str(error)}

    def request(self, command: Table) -> Answer:
        """The answer to a command from Python, which needs no controls; waits for it."""
        try:
            if command.get("do") in _OWN:
                return self._own(command)
            if command.get("do") == "select":
                return self._select("", command)
            answer = self._send(self._with_robot("", command)).result(LONGEST_ANSWER)
            self._mailbox.spoil()
            return answer
        except AmorsimError as error:
            return {"ok": False, "error": str(error)}

    def _send(self, command: Table) -> concurrent.futures.Future[Answer]:
        link = self._link
        if link is None or self._is_closed.is_set():
            raise AmorsimError("the simulation has ended")
        if command.get("do") == "speed":
            self._kept[command["do"]] = dict(command)
        return link.send(command)

    def _select(self, window: str, command: Table) -> Answer:
        """Let a window look at a robot, whatever others look at."""
        names = [robot["name"] for robot in self.scene["robots"]]
        robot = command.get("robot")
        if isinstance(robot, str) and robot in names:
            robot = names.index(robot)
        if not isinstance(robot, int) or isinstance(robot, bool) or not 0 <= robot < len(names):
            hint = did_you_mean(str(robot), names) if isinstance(robot, str) else ""
            raise AmorsimError(f"expected a robot's name or its place from 0 to {len(names) - 1}, got {robot!r}.{hint}")
        self._looks.turn(window, robot)
        self._mailbox.turn()
        return {"ok": True}

    def _with_robot(self, window: str, command: Table) -> Table:
        if command.get("do") in _OF_ROBOT and "robot" not in command:
            return {**command, "robot": self._looks.of(window)}
        return command

    def _own(self, command: Table) -> Answer:
        name = command["do"]
        if name == "restart":
            return self._restart(command)
        if name == "places":
            return {"ok": True, "project": str(self.project), **free_places(self.project, self.scene["scenario"])}
        if name == "save_run":
            job = self._demand({"do": "job"})
            answer = self._saver.save(job, command.get("name"), self.scene["scenario"])
            self._remark("saved", f"the run was saved in {answer['folder']}")
            return answer
        file = place_for(self.project, command.get("name"), ".toml")
        if file.exists() and not command.get("overwrite"):
            raise AmorsimError(f"{file.name} is there already; name another file")
        self._demand({"do": "write_scenario", "file": str(file)})
        self._remark("saved", f"the scenario was saved as {file.relative_to(self.project)}")
        return {"ok": True, "file": str(file)}

    def _demand(self, command: Table) -> Answer:
        answer = self._send(command).result(LONGEST_ANSWER)
        if not answer["ok"]:
            raise AmorsimError(answer["error"])
        return answer

    def _remark(self, kind: str, text: str, **more: str) -> None:
        with contextlib.suppress(AmorsimError):
            self._send({"do": "remark", "kind": kind, "text": text, **more})

    async def _told_state(self, command: Table) -> Answer:
        if self._hang is None:
            link = self._link
            try:
                answer = asyncio.wrap_future(self._send(command))
                while not (await asyncio.wait([answer], timeout=BETWEEN_LOOKS))[0]:
                    if self._is_compiling and self._state:
                        answer.cancel()
                        return {**self._state, "status": "compiling", **self._controls.told()}
                self._state = await answer
            except AmorsimError:
                if link is not None and not link.is_alive:
                    self._ended(link)  # the link's own word of it may still be under way
                if self._hang is None and not self._state:
                    raise
        return {**self._state, **self._told_hang(), **self._controls.told()}

    def _told_hang(self) -> Answer:
        hang = self._hang
        if hang is None:
            return {}
        tick = hang["tick"]
        line = line_of(tick, tick * self.scene["dt"], "hang", hang["text"], hang["robot"]) | {"stack": hang["stack"]}
        return {"ok": True, "status": hang["status"], "fault": line}

    # ---------------------------------------------------------------------------------------------------------- frames

    async def newest_frame(self, after: int = 0, window: str = "") -> bytes:
        """The newest frame whose number is above `after`, as soon as there is one; never, once the session has ended.

        It tells all of the robot that the window looks at. Frames are made only while somebody waits for one, at most
        40 in a second.
        """
        return await self._mailbox.newest(after, lambda: self._looks.of(window))

    def _ask_frame(self, now: bool) -> bool:
        link = self._link
        if link is None or not link.is_alive:
            return False
        link.tell({"do": "frame", "now": now, "robots": self._looks.robots})
        return True

    def _take_frame(self, data: bytes) -> None:
        bundle = Bundle(data)
        self._epoch = bundle.epoch
        if self._link is not None:
            self._link.tick = bundle.newest
        self._mailbox.take(bundle)

    # -------------------------------------------------------------------------------------------------------- watching

    def _watch(self) -> None:
        """Ask the child for signs of life, and tell when a controller holds it up."""
        while not self._is_closed.wait(BETWEEN_PINGS):
            link = self._link
            if link is None or not link.is_alive or not link.ready.done():
                continue
            sign = self._sign(link)
            if link is not self._link or not link.is_alive:
                continue
            self._look_for_compiler(sign or {})
            if sign is None:
                self._note_hang("hang", "it gives no sign of life", link.tick, "", "")
            elif sign["held"] > self._patience and "stack" in sign:
                text = f"the controller of {sign['robot'] or 'a robot'} has not returned for {sign['held']:.0f} s"
                self._note_hang("hang", text, sign["tick"], sign["robot"], sign["stack"])
            elif self._hang is not None and self._hang["status"] == "hang":
                self._hang = None
                self._mailbox.move_on()

    def _sign(self, link: Link) -> Answer | None:
        try:
            sign = link.send({"do": "ping", "patience": self._patience}).result(self._patience + BETWEEN_PINGS)
        except (concurrent.futures.TimeoutError, AmorsimError):
            return None
        link.tick = sign["tick"]
        return sign

    def _note_hang(self, status: str, text: str, tick: int, robot: str, stack: str) -> None:
        is_new = self._hang is None or self._hang["status"] != status
        self._hang = {"status": status, "text": text, "tick": tick, "robot": robot, "stack": stack}
        if is_new:
            self._mailbox.stand_still()
        if self._link is not None:  # whoever has asked already gets no answer either
            self._link.give_up(f"the simulation does not answer: {text}")

    def _ended(self, link: Link) -> None:
        """The child's end that nobody asked for."""
        is_expected = self._hang is not None and self._hang["status"] == "restarting"
        if self._is_closed.is_set() or link is not self._link or self._scene is None or is_expected:
            return
        robot = self._hang["robot"] if self._hang else ""
        self._note_hang("gone", f"the simulation has ended by itself ({link.end})", link.tick, robot, link.last_words)

    # ------------------------------------------------------------------------------------------------------ restarting

    def _restart(self, command: Table) -> Answer:
        """Break off the controller that hangs; where that does not help, or the child is gone, start another child."""
        link, hang = self._link, self._hang
        assert link is not None
        without = command.get("without")
        if without is None:
            without = [hang["robot"]] if hang is not None and hang["robot"] else []
        if not isinstance(without, list) or not all(isinstance(name, str) for name in without):
            raise AmorsimError(f"without: expected a list of robots' names, got {without!r}")
        if link.is_alive and (hang is None or hang["status"] == "hang"):
            link.tell({"do": "interrupt"})
            if self._is_back(link):
                self._hang = None
                self._mailbox.move_on()
                for name in without:
                    self._demand({"do": "hand_over", "robot": name, "to": "hand"})
                if not without:
                    self._demand({"do": "forgive"})
                if hang is not None:
                    self._remark("restarted", "the step was broken off and taken back")
                return {"ok": True, "again": False}
        inputs = list(link.inputs)
        tick = max([link.tick, *(one["tick"] for one in inputs)])
        inputs += [{"tick": tick, "do": "hand_over", "robot": name, "value": "hand", "path": ""} for name in without]
        if self._hang is not None:
            self._hang = {**self._hang, "status": "restarting"}
        link.close(0.0)
        self._epoch += 1
        if self._out is not None and self._out.exists():
            self._out = next_folder(self._out)
        try:
            since = self._begin({"inputs": inputs, "tick": tick}, link.carried)
        except AmorsimError as error:
            self._note_hang("gone", f"it could not be started again: {error}", tick, "", link.last_words)
            raise
        if link.uncarried and link.carried is None:
            since += f", for {link.uncarried}"
        for kept in list(self._kept.values()):
            self._send(kept)
        self._remark("restarted", f"it was started again, and led to where it was {since}")
        return {"ok": True, "again": True}

    def _is_back(self, link: Link) -> bool:
        deadline = time.monotonic() + LONGEST_INTERRUPT
        while time.monotonic() < deadline and link.is_alive:
            try:
                sign = link.send({"do": "ping", "patience": self._patience}).result(0.2)
                if sign["held"] == 0.0:
                    return True
            except (concurrent.futures.TimeoutError, AmorsimError):
                return False
            time.sleep(0.02)
        return False
