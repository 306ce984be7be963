"""Supervises a session's child process: starts it, watches its signs of life, and starts another where needed.

Where a controller hangs or the child is gone, another child is led to where this one was, without the controller that
held it up.
"""

from __future__ import annotations

import asyncio
import contextlib
import time
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from amorsim.core.errors import AmorsimError
from amorsim.kernels import COMPILING
from amorsim.runs.folder import next_folder
from amorsim.ui.scene.wire import Scene
from amorsim.ui.simulator.frame_buffer import FrameBuffer
from amorsim.ui.simulator.frames.packing import Bundle
from amorsim.ui.simulator.link import Link
from amorsim.ui.simulator.recipe import Recipe
from amorsim.ui.simulator.sources.story import line_of

__all__ = ["ChildSupervisor"]

Table = Mapping[str, Any]
Answer = dict[str, Any]

BETWEEN_PINGS = 0.5  # [s]
LONGEST_INTERRUPT = 1.0  # [s] that a controller gets to be broken off
LONGEST_ANSWER = 600.0  # [s]
LONGEST_START = 300.0  # [s], compiling included


class ChildSupervisor:
    """A child process that is there as long as its session, or another in its place; for one event loop.

    Parameters
    ----------
    recipe, out, patience, notice
        As for `amorsim.ui.simulator.session.Session`.
    frame_buffer
        Takes the frames, and knows when none comes.

    Attributes
    ----------
    link
        The link to the present child; None before there was one.
    hang
        The report of the child, or of its end, on a controller that hangs; None where none does.
    is_compiling
        Whether it was compiling kernels when it was looked at last.
    remarks
        For the user, at the start.
    """

    def __init__(
        self,
        recipe: Recipe,
        *,
        out: Path | None,
        patience: float,
        notice: Callable[[str], None] | None,
        frame_buffer: FrameBuffer,
    ) -> None:
        self.link: Link | None = None
        self.hang: dict[str, Any] | None = None
        self.is_compiling = False
        self.remarks: list[str] = []
        self._recipe, self._out = recipe, out
        self._patience, self._notice = patience, notice
        self._frame_buffer = frame_buffer
        self._scene: Scene | None = None
        self._epoch = 0
        self._kept: dict[str, Answer] = {}  # commands whose effect outlasts a child
        self._watching: asyncio.Task[None] | None = None
        self._restarting = asyncio.Lock()
        self._is_closed = False

    # ----------------------------------------------------------------------------------------------- beginning and end

    async def start(self) -> Scene:
        """Start the first child; returns its scene."""
        await self._begin({"inputs": [], "tick": 0})
        self._watching = asyncio.create_task(self._watch())
        return self.scene

    async def _begin(self, rest: dict[str, Any], carried: bytes | None = None) -> str:
        """Start a child; returns from where it was led to where the last one was, in words."""
        order = {
            "recipe": self._recipe.to_json(),
            "out": str(self._out) if self._out else "",
            "epoch": self._epoch,
            **rest,
        }
        if self._is_closed:
            raise AmorsimError("the simulation has ended")
        link = self.link = Link(order, carried=carried, on_frame=self._take_frame, on_end=self._ended)
        try:
            ready = await self._await_ready(link)
        except BaseException:
            await link.close(0.0)
            raise
        self._scene, self.remarks = ready["scene"], ready["remarks"]
        self.hang, self.is_compiling = None, False
        self._frame_buffer.move_on()
        return str(ready["since"])

    async def _await_ready(self, link: Link) -> Answer:
        """Wait for the child's message that it is ready; meanwhile tell the user what takes so long."""
        deadline = time.monotonic() + LONGEST_START
        sign: asyncio.Future[Answer] | None = None
        while not (await asyncio.wait([link.ready], timeout=BETWEEN_PINGS))[0]:
            if time.monotonic() > deadline:
                raise AmorsimError(f"the simulation was not ready after {LONGEST_START:g} s")
            with contextlib.suppress(AmorsimError):  # it has ended, which `link.ready` is about to report
                if sign is not None and sign.done():
                    self._look_for_compiler(sign.result())
                    sign = None
                sign = sign or link.send({"do": "ping"})
        return link.ready.result()

    async def close(self) -> None:
        """End the simulation, with whole files."""
        self._is_closed = True
        if self._watching is not None:
            self._watching.cancel()
        if self.link is not None:
            await self.link.close()

    @property
    def scene(self) -> Scene:
        """All that stays as it is while the simulation runs."""
        if self._scene is None:
            raise AmorsimError("the simulation has not been started")
        return self._scene

    @scene.setter
    def scene(self, scene: Scene) -> None:
        self._scene = scene

    # -------------------------------------------------------------------------------------------------------- speaking

    def send(self, command: Table) -> asyncio.Future[Answer]:
        """Send the child a command; returns a future of the answer.

        Raises
        ------
        AmorsimError
            If it has ended.
        """
        if self.link is None or self._is_closed:
            raise AmorsimError("the simulation has ended")
        if command.get("do") == "speed":
            self._kept[command["do"]] = dict(command)
        return self.link.send(command)

    async def demand(self, command: Table) -> Answer:
        """The answer to a command that must succeed.

        Raises
        ------
        AmorsimError
            If it cannot be.
        """
        answer = await asyncio.wait_for(self.send(command), LONGEST_ANSWER)
        if not answer["ok"]:
            raise AmorsimError(answer["error"])
        return answer

    def remark(self, kind: str, text: str, **more: str) -> None:
        """Let the child add a remark to the events."""
        with contextlib.suppress(AmorsimError):
            self.send({"do": "remark", "kind": kind, "text": text, **more})

    def ask_frame(self, robots: list[int], *, now: bool) -> bool:
        """Ask for a frame with all of these robots; returns whether there is a child to ask."""
        if self.link is None or not self.link.is_alive:
            return False
        self.link.tell({"do": "frame", "now": now, "robots": robots})
        return True

    def _take_frame(self, data: bytes) -> None:
        bundle = Bundle(data)
        self._epoch = bundle.epoch
        if self.link is not None:
            self.link.tick = bundle.newest
        self._frame_buffer.take(bundle)

    # -------------------------------------------------------------------------------------------------------- watching

    async def _watch(self) -> None:
        """Ask the child for signs of life, and note when a controller blocks it."""
        while True:
            await asyncio.sleep(BETWEEN_PINGS)
            link = self.link
            if link is None or not link.is_alive or not link.ready.done():
                continue
            sign = await self._sign(link, self._patience + BETWEEN_PINGS)
            if link is not self.link or not link.is_alive:
                continue
            self._look_for_compiler(sign or {})
            if sign is None:
                self._note_hang("hang", "it gives no sign of life", link.tick, "", "")
            elif sign["held"] > self._patience and "stack" in sign:
                text = f"the controller of {sign['robot'] or 'a robot'} has not returned for {sign['held']:.0f} s"
                self._note_hang("hang", text, sign["tick"], sign["robot"], sign["stack"])
            elif self.hang is not None and self.hang["status"] == "hang":
                self.hang = None
                self._frame_buffer.move_on()

    async def _sign(self, link: Link, patience: float) -> Answer | None:
        """A sign of life, or none within `patience` [s]."""
        try:
            sign = await asyncio.wait_for(link.send({"do": "ping", "patience": self._patience}), patience)
        except (TimeoutError, AmorsimError):
            return None
        link.tick = sign["tick"]
        return sign

    def _look_for_compiler(self, sign: Answer) -> None:
        is_compiling = sign.get("compiling", False)
        if is_compiling and self._notice is not None:
            self._notice(COMPILING)
            self._notice = None
        self.is_compiling = is_compiling

    def _note_hang(self, status: str, text: str, tick: int, robot: str, stack: str) -> None:
        is_new = self.hang is None or self.hang["status"] != status
        self.hang = {"status": status, "text": text, "tick": tick, "robot": robot, "stack": stack}
        if is_new:
            self._frame_buffer.stand_still()
        if self.link is not None:  # earlier commands get no answer either
            self.link.give_up(f"the simulation does not answer: {text}")

    def _ended(self, link: Link) -> None:
        """Handle the end of a child that was not asked to end."""
        is_expected = self.hang is not None and self.hang["status"] == "restarting"
        if self._is_closed or link is not self.link or self._scene is None or is_expected:
            return
        robot = self.hang["robot"] if self.hang else ""
        self._note_hang("gone", f"the simulation has ended by itself ({link.end})", link.tick, robot, link.last_words)

    def trouble(self) -> Answer:
        """The state to show if the child hangs or is gone; empty if it is well."""
        hang = self.hang
        if hang is None:
            return {}
        tick = hang["tick"]
        line = line_of(tick, tick * self.scene["dt"], "hang", hang["text"], hang["robot"]) | {"stack": hang["stack"]}
        return {"ok": True, "status": hang["status"], "fault": line}

    # ------------------------------------------------------------------------------------------------------ restarting

    async def restart(self, without: Any) -> Answer:
        """Break off the controller that hangs; where that does not help, or the child is gone, start another child.

        Parameters
        ----------
        without
            Names of the robots that go over to the hand; None for that whose controller hangs, if there is one.
        """
        async with self._restarting:
            link, hang = self.link, self.hang
            assert link is not None
            if without is None:
                without = [hang["robot"]] if hang is not None and hang["robot"] else []
            if not isinstance(without, list) or not all(isinstance(name, str) for name in without):
                raise AmorsimError(f"without: expected a list of robots' names, got {without!r}")
            if link.is_alive and (hang is None or hang["status"] == "hang"):
                link.tell({"do": "interrupt"})
                if await self._is_back(link):
                    await self._go_on(without)
                    return {"ok": True, "again": False}
            await self._start_another(link, without)
            return {"ok": True, "again": True}

    async def _go_on(self, without: list[str]) -> None:
        """Let the child continue after its controller was interrupted."""
        hang, self.hang = self.hang, None
        self._frame_buffer.move_on()
        for name in without:
            await self.demand({"do": "hand_over", "robot": name, "to": "hand"})
        if not without:
            await self.demand({"do": "forgive"})
        if hang is not None:
            self.remark("restarted", "the step was broken off and taken back")

    async def _start_another(self, link: Link, without: list[str]) -> None:
        """Start another child in place of one that hangs or has ended."""
        inputs = list(link.inputs)
        tick = max([link.tick, *(one["tick"] for one in inputs)])
        inputs += [{"tick": tick, "do": "hand_over", "robot": name, "value": "hand", "path": ""} for name in without]
        if self.hang is not None:
            self.hang = {**self.hang, "status": "restarting"}
        await link.close(0.0)
        self._epoch += 1
        if self._out is not None and self._out.exists():
            self._out = next_folder(self._out)
        try:
            since = await self._begin({"inputs": inputs, "tick": tick}, link.carried)
        except AmorsimError as error:
            self._note_hang("gone", f"it could not be started again: {error}", tick, "", link.last_words)
            raise
        if link.uncarried and link.carried is None:
            since += f", for {link.uncarried}"
        for kept in list(self._kept.values()):
            self.send(kept)
        self.remark("restarted", f"it was started again, and led to where it was {since}")

    async def _is_back(self, link: Link) -> bool:
        """Whether the child's controller has returned; asks the child, which answers soon."""
        deadline = time.monotonic() + LONGEST_INTERRUPT
        while time.monotonic() < deadline and link.is_alive:
            sign = await self._sign(link, 0.2)
            if sign is None:
                return False
            if sign["held"] == 0.0:
                return True
            await asyncio.sleep(0.02)
        return False
