"""The child process: it owns the simulation and follows its session, over standard input and output.

Three threads: the first one simulates, and is the one that a user's controller can hold up; the second reads what the
session sends; the third writes answers. So the session hears from it also while a controller does not return, the
simulation never waits for a reader, and the process ends when its session does: then there is nothing more to read.
"""

from __future__ import annotations

import contextlib
import faulthandler
import json
import os
import queue
import signal
import sys
import threading
import time
import traceback
from collections.abc import Mapping
from pathlib import Path
from typing import IO, Any

from amorsim.core.error_text import explain
from amorsim.core.errors import AmorsimError
from amorsim.kernels.cache_folder import mark_warm
from amorsim.ui.faults.shown_faults import lines_of
from amorsim.ui.simulator.frames.packing import FrameFlag, pack_bundle
from amorsim.ui.simulator.frames.scenes import SceneBuilder
from amorsim.ui.simulator.process.busy import Busy, Interrupted
from amorsim.ui.simulator.process.commands import Commands
from amorsim.ui.simulator.process.orphan import stay
from amorsim.ui.simulator.process.pipes import JSON, Writer, read_message
from amorsim.ui.simulator.process.replaying import Replaying
from amorsim.ui.simulator.process.stacks import robot_of
from amorsim.ui.simulator.process.step_faults import Fault
from amorsim.ui.simulator.process.watching import Watching
from amorsim.ui.simulator.recipe import Recipe
from amorsim.ui.simulator.sources.carried import Carried, Carrier
from amorsim.ui.simulator.sources.inputs import Input, Inputs
from amorsim.ui.simulator.sources.player import Player
from amorsim.ui.simulator.sources.recording import Recording
from amorsim.ui.simulator.sources.source import Source

__all__ = ["Child", "main"]

LONGEST_SLEEP = 0.05  # [s], after which an idle loop looks about
LEAST_BETWEEN_FRAMES = 0.025  # [s]
LONGEST_STEP = 0.25  # [s] that a controller gets to return once all is to end
LONGEST_END = 1.7  # [s] that a step may take to end once all is to end
# Where not even a thread that only reads gets its turn (code that never lets Python go), the process ends by itself.
LONGEST_SILENCE = 60.0  # [s]

# Messages of the session that need no answer of the simulation.
_AT_ONCE = ("ping", "frame", "interrupt", "end")


class Child:
    """The process's work.

    Parameters
    ----------
    orders, answers
        What is read, and where answers go.
    """

    _source: Source
    _does: Watching

    def __init__(self, orders: IO[bytes], answers: IO[bytes]) -> None:
        self._orders = orders
        self._writer = Writer(answers)
        self._commands: queue.SimpleQueue[dict[str, Any]] = queue.SimpleQueue()
        self._is_ending = threading.Event()
        self._busy = Busy()
        self._process = os.getpid()
        self._is_wanted = False  # a frame, by the session
        self._robots: tuple[int, ...] = (0,)  # for which frames contain everything
        self._number = 0
        self._changed = True
        self._last_frame = 0.0
        self._tick = 0
        self._folder = ""
        self._is_first = True
        self._carrier = Carrier()
        self._epoch = 0
        self._known: tuple[Inputs | None, int] = (None, 0)  # the inputs that the session knows, and how many
        self._player: Player | None = None  # the source, if it is a simulation

    # ---------------------------------------------------------------------------------------------- the reading thread

    def read(self) -> None:
        """Take the session's messages, until there are no more."""
        try:
            while (message := read_message(self._orders)) is not None:
                kind, data = message
                if kind != JSON:
                    continue
                command = json.loads(data)
                if command.get("do") in _AT_ONCE:
                    self._at_once(command)
                else:
                    self._commands.put(command)
        finally:  # also after a message that should not come: a child that does not listen would never end
            self.end()

    def _at_once(self, command: Mapping[str, Any]) -> None:
        name = command["do"]
        if name == "ping":
            faulthandler.dump_traceback_later(LONGEST_SILENCE, exit=True, file=2)
            life = self._busy.sign_of_life(float(command.get("patience", 5.0)))
            self._writer.send({"id": command["id"], "ok": True, "tick": self._tick, **life})
        elif name == "frame":
            self._robots = tuple(command["robots"])
            self._is_wanted = True
            self._changed = self._changed or bool(command["now"])
            self._commands.put({"do": ""})  # wakes an idle loop
        elif name == "interrupt":
            self._busy.interrupt()
        else:
            self.end()

    def end(self) -> None:
        """Let the first thread end, and see to it that the process does."""
        self._is_ending.set()
        self._commands.put({"do": ""})
        for seconds, then, arguments in ((LONGEST_STEP, self._busy.interrupt, ()), (LONGEST_END, os._exit, (1,))):
            timer = threading.Timer(seconds, then, arguments)
            timer.daemon = True
            timer.start()

    # ------------------------------------------------------------------------------------------- the simulating thread

    def work(
        self, recipe: Recipe, *, out: Path | None, inputs: Inputs, tick: int, epoch: int, carried: Carried | None
    ) -> None:
        """Make the simulation, and simulate until the session ends."""
        try:
            self._busy.begin(in_step=False)
            if recipe.is_recorded:
                ready = self._open(recipe, epoch)
            else:
                ready = self._simulate(recipe, out=out, inputs=inputs, tick=tick, epoch=epoch, carried=carried)
        except AmorsimError as error:
            self._writer.send({"push": "failed", "error": explain(error), "faults": lines_of(error)})
            return
        self._busy.end()
        source = self._source = self._does.source
        self._folder, self._tick = str(source.folder or ""), source.newest
        self._writer.send({"push": "ready", "scene": self._does.scene, "folder": self._folder, **ready})
        self._epoch = source.epoch
        try:
            while not self._is_ending.is_set():
                with contextlib.suppress(Interrupted):  # it came late: what it was meant for has returned
                    self._turn()
        finally:
            source.close()

    def _simulate(
        self, recipe: Recipe, *, out: Path | None, inputs: Inputs, tick: int, epoch: int, carried: Carried | None
    ) -> dict[str, Any]:
        """Make the simulation, and lead it to where another process was; returns remarks, and from where it was led."""
        since = ""
        simulation, remark = recipe.simulation()
        player = Player(simulation, out=out, notice=self._replayed, epoch=epoch)
        if tick or len(inputs):
            player.inputs = inputs
            since = player.resume(tick, carried)
        builder = SceneBuilder(simulation)
        self._player = player
        self._does = Commands(player, builder, self._is_ending.is_set, changes=recipe.changes, passing=recipe.passing)
        scenario = simulation.scenario
        remarks = [
            f"{scenario.map.name}: {text}" for text in (*scenario.remarks, *scenario.map.warnings, remark) if text
        ]
        return {"remarks": remarks, "since": since}

    def _open(self, recipe: Recipe, epoch: int) -> dict[str, Any]:
        """Open a recorded run; returns remarks."""
        self._does = Replaying(Recording(Path(recipe.name), epoch=epoch), self._is_ending.is_set)
        return {"remarks": [], "since": "from its folder"}

    def _replayed(self, _: int) -> None:
        if self._is_ending.is_set():
            raise SystemExit(0)

    def _turn(self) -> None:
        """Carry out the messages, make a step if one is due, and show how it looks."""
        does = self._does
        now = time.monotonic()
        wait = LONGEST_SLEEP
        if does.is_running:
            wait = min(wait, does.pace.wait(now))
        if self._is_wanted and self._changed:
            wait = min(wait, max(0.0, self._last_frame + LEAST_BETWEEN_FRAMES - now))
        self._listen(wait)
        if does.is_running and does.pace.wait(time.monotonic()) <= 0.0:
            self._step()
            # As fast as possible: look about only when there is something to see to.
            while does.is_running and does.pace.factor is None and self._commands.empty() and not self._is_frame_due():
                self._step()
        self._show()

    def _listen(self, wait: float) -> None:
        try:
            command = self._commands.get(timeout=wait) if wait > 0.0 else self._commands.get_nowait()
            while True:
                if command.get("do") != "":
                    self._carry_out(command)
                command = self._commands.get_nowait()
        except queue.Empty:
            pass

    def _carry_out(self, command: dict[str, Any]) -> None:
        self._busy.begin()
        try:
            answer = self._does.carry_out(command)
        except Interrupted:
            self._interrupted()
            answer = {"ok": False, "error": "it was broken off"}
        except Exception as error:
            sys.stderr.write("".join(traceback.format_exception(error)))
            answer = {"ok": False, "error": f"{type(error).__name__}: {error}"}
        finally:
            self._busy.end()
        self._changed = True
        self._tick = self._source.newest
        self._tell_inputs()
        self._writer.send({"id": command["id"], **answer})

    def _step(self) -> None:
        does, source = self._does, self._source
        # Frames are rare where it runs as fast as it can; only the step before one needs to be looked at.
        is_watched = does.pace.factor is not None or self._is_frame_due()
        if self._is_ending.is_set():
            return
        source.watched = self._robots
        self._busy.begin()
        try:
            made = source.step(watched=is_watched)
        except Interrupted:
            made = False
            self._interrupted()
        finally:
            self._busy.end()
        self._expect_original()
        self._changed = True
        self._tick = source.newest
        if not made:
            does.is_running = False
            if source.fault is not None:
                sys.stderr.write(source.fault.stack + "\n")
            return
        if self._is_first and self._player is not None:
            mark_warm()
            self._is_first = False
        if self._carrier.is_due:
            self._carry()
        does.pace.stepped(time.monotonic(), source.dt)
        if source.tick == source.last:
            does.is_running, does.has_ended = False, True

    def _expect_original(self) -> None:
        """End this process if a controller has forked it: its session listens to the original alone."""
        if os.getpid() != self._process:
            sys.stderr.write("a controller or plugin forked the process that simulates; the copy ends here\n")
            sys.stderr.flush()
            os._exit(1)

    def _carry(self) -> None:
        """Send the session a snapshot from which another child can go on, or why there is none."""
        carried = None if self._player is None else self._player.carry(self._carrier)
        if carried is not None:
            self._writer.send({"push": "tick", "tick": carried.tick})
            self._writer.send_snapshot(carried.to_bytes())
        elif self._carrier.reason:
            self._writer.send({"push": "uncarried", "reason": self._carrier.reason})

    def _interrupted(self) -> None:
        robot = self._hung
        if self._player is None:
            return
        self._player.fail(
            Fault(
                robots=(robot,) if robot else (),
                text=f"the controller of {robot or 'a robot'} did not return",
                stack="",
            )
        )

    @property
    def _hung(self) -> str:
        _, _, trace = sys.exc_info()
        while trace is not None:
            if robot := robot_of(trace.tb_frame):
                return robot
            trace = trace.tb_next
        return ""

    def _tell_inputs(self) -> None:
        """Send the session the inputs so far, from which another child can go on."""
        if self._player is None:
            return
        if self._player.epoch != self._epoch:  # what was carried is of another course of events
            self._epoch = self._player.epoch
            self._writer.send({"push": "epoch"})
        folder = str(self._player.folder or "")
        if folder != self._folder:
            self._folder = folder
            self._writer.send({"push": "folder", "folder": folder})
        inputs = self._player.inputs
        first, news = inputs.news()
        known, count = self._known
        if inputs is not known or news or len(inputs) != count:
            self._known = inputs, len(inputs)
            self._writer.send({"push": "inputs", "first": first, "inputs": [one.to_json() for one in news]})

    def _is_frame_due(self) -> bool:
        return self._is_wanted and time.monotonic() - self._last_frame >= LEAST_BETWEEN_FRAMES

    def _show(self) -> None:
        """Send a frame if the session has an older one and enough time has passed since the last."""
        if self._changed and self._is_frame_due():
            # Before the frame is made: what is wanted, or changes, meanwhile asks for another.
            self._changed = self._is_wanted = False
            does = self._does
            self._number += 1
            self._last_frame = time.monotonic()
            flags = (FrameFlag.RUNNING if does.is_running else 0) | (FrameFlag.ENDED if does.has_ended else 0)
            speed = float("inf") if does.pace.factor is None else does.pace.factor
            self._source.watched = self._robots
            moments = self._source.frames(
                version=does.scene["version"], number=self._number, speed=speed, achieved=does.achieved, flags=flags
            )
            self._writer.send_frame(pack_bundle(moments))

    def close(self) -> None:
        """Write what is still to be written."""
        self._writer.close()


def main() -> None:
    """Read the first message, which names what to simulate, and simulate it."""
    # Ctrl-C is for the session, which ends this process in order.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    orders = os.fdopen(os.dup(0), "rb", buffering=0)
    answers = os.fdopen(os.dup(1), "wb")
    # What a user's controller prints goes to the log, and never into the answers.
    os.dup2(2, 1)
    os.dup2(os.open(os.devnull, os.O_RDONLY), 0)
    first = read_message(orders)
    if first is None:
        return
    order = json.loads(first[1])
    snapshot = read_message(orders) if order["carried"] else None
    child = Child(orders, answers)
    with contextlib.suppress(AttributeError, ValueError):
        signal.signal(signal.SIGTERM, lambda *_: child.end())
    threading.Thread(target=child.read, name="amorsim-reader", daemon=True).start()
    stay()
    child.work(
        Recipe.from_json(order["recipe"]),
        out=Path(order["out"]) if order["out"] else None,
        inputs=Inputs(Input.from_json(one) for one in order["inputs"]),
        tick=order["tick"],
        epoch=order["epoch"],
        carried=None if snapshot is None else Carried.from_bytes(snapshot[1]),
    )
    child.close()
    # All is written; taking the interpreter apart would only take time.
    sys.stderr.flush()
    os._exit(0)
