"""The link from a session to one child process: started, spoken with, ended.

It belongs to an event loop. Threads read the pipes and wait for the process; what they find they hand to the loop, and
they look at nothing else.
"""

from __future__ import annotations

import asyncio
import atexit
import collections
import contextlib
import itertools
import json
import subprocess
import sys
import threading
import weakref
from collections.abc import Callable, Mapping
from typing import Any

from amorsim.core.errors import AmorsimError
from amorsim.ui.faults.shown_faults import FaultsError
from amorsim.ui.simulator.process.pipes import FRAME, SNAPSHOT, Writer, python_for, read_message

__all__ = ["Link"]

Answer = dict[str, Any]

LONGEST_END = 1.8  # [s] that a child gets to end with whole files
LAST_WORDS = 60  # lines of its log that are kept

_alive: weakref.WeakSet[Link] = weakref.WeakSet()


class Link:
    """A child process that belongs to the event loop in which it is made.

    Parameters
    ----------
    order
        What it is to simulate (see `amorsim.ui.simulator.process.child.main`).
    carried
        The snapshot that it is to go on from, as another child gave it; None for none.
    on_frame, on_end
        Called with the bytes of each frame, and with the link when the process has ended.

    Attributes
    ----------
    ready
        Its scene, once the simulation is made; an `AmorsimError` where it cannot be, a `FaultsError` where the
        scenario's files are why.
    inputs
        The inputs that were given to it, as far as it has reported them.
    tick
        The last tick that it reported.
    carried
        The last snapshot that another child can go on from, or None.
    uncarried
        Why there is none, where there cannot be any.
    folder
        What it writes the run into.
    is_alive
        Whether it can answer.
    end, last_words
        How it ended, and what it wrote into its log before.
    """

    def __init__(
        self,
        order: Mapping[str, Any],
        *,
        carried: bytes | None = None,
        on_frame: Callable[[bytes], None],
        on_end: Callable[[Link], None],
    ) -> None:
        self._loop = asyncio.get_running_loop()
        self.ready: asyncio.Future[Answer] = self._loop.create_future()
        self.ready.add_done_callback(_look_at)
        self.inputs: list[dict[str, Any]] = list(order["inputs"])
        self.tick: int = order["tick"]
        self.carried = carried
        self.uncarried = ""
        self.folder = ""
        self.is_alive = True
        self.end = ""
        self._log: collections.deque[str] = collections.deque(maxlen=LAST_WORDS)
        self._on_frame, self._on_end = on_frame, on_end
        self._numbers = itertools.count(1)
        self._open: dict[int, asyncio.Future[Answer]] = {}
        self._pings: set[int] = set()  # which of the open ones are signs of life
        # In a session of its own, where there are such: Ctrl-C in the terminal is for the session alone.
        self._process = subprocess.Popen(
            python_for("amorsim.ui.simulator.process.child"),
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            start_new_session=True,
        )
        assert self._process.stdin is not None
        self._writer = Writer(self._process.stdin)
        self._writer.send({**order, "carried": carried is not None})
        if carried is not None:
            self._writer.send_snapshot(carried)
        self._readers = [_thread(self._read, "amorsim-link"), _thread(self._hear, "amorsim-log")]
        self._waiter = _thread(self._wait, "amorsim-wait")
        _alive.add(self)

    @property
    def pid(self) -> int:
        """The number of the process."""
        return self._process.pid

    @property
    def last_words(self) -> str:
        """The last lines of its log."""
        return "\n".join(self._log)

    def send(self, command: Mapping[str, Any]) -> asyncio.Future[Answer]:
        """Send a command; returns a future of the answer.

        Raises
        ------
        AmorsimError
            If it has ended.
        """
        if not self.is_alive:
            raise AmorsimError("the simulation has ended by itself")
        answer: asyncio.Future[Answer] = self._loop.create_future()
        answer.add_done_callback(_look_at)
        number = next(self._numbers)
        self._open[number] = answer
        if command.get("do") == "ping":
            self._pings = {number, *(ping for ping in self._pings if ping in self._open)}
        self._writer.send({**command, "id": number})
        return answer

    def give_up(self, reason: str) -> None:
        """Answer all waiting commands with an `AmorsimError`, except signs of life; late answers are thrown away."""
        for number in [number for number in self._open if number not in self._pings]:
            _fail(self._open.pop(number), reason)

    def tell(self, command: Mapping[str, Any]) -> None:
        """Send what has no answer."""
        self._writer.send(command)

    # ------------------------------------------------------------------------------------------------- what comes

    def _heard(self, kind: bytes, data: bytes) -> None:
        if kind == FRAME:
            self._on_frame(data)
            return
        if kind == SNAPSHOT:
            self.carried = data
            return
        table = json.loads(data)
        if "push" in table:
            self._pushed(table)
            return
        answer = self._open.pop(table.pop("id"), None)
        if answer is not None and not answer.done():
            answer.set_result(table)

    def _pushed(self, table: Answer) -> None:
        kind = table["push"]
        if kind == "ready":
            self.folder = table["folder"]
            if not self.ready.done():
                self.ready.set_result(table)
        elif kind == "failed":
            faults = table["faults"]
            _fail(self.ready, FaultsError(table["error"], faults) if faults else table["error"])
        elif kind == "inputs":
            self.inputs[table["first"] :] = table["inputs"]
        elif kind == "epoch":
            self.carried = None
        elif kind == "uncarried":
            self.uncarried = table["reason"]
        elif kind == "tick":
            self.tick = max(self.tick, table["tick"])
        elif kind == "folder":
            self.folder = table["folder"]

    def _finish(self, code: int) -> None:
        self.end = f"signal {-code}" if code < 0 else f"exit status {code}"
        self.is_alive = False
        _fail(self.ready, f"the simulation could not be started ({self.end})\n{self.last_words}")
        self._on_end(self)  # before the answers: whose command fails shall find why
        for answer in self._open.values():
            _fail(answer, f"the simulation has ended by itself ({self.end})")
        self._open.clear()

    # ------------------------------------------------------------------------------------------------- in threads

    def _post(self, function: Callable[..., None], *arguments: Any) -> None:
        """Let the loop call a function."""
        with contextlib.suppress(RuntimeError):  # it has ended
            self._loop.call_soon_threadsafe(function, *arguments)

    def _read(self) -> None:
        assert self._process.stdout is not None
        while (message := read_message(self._process.stdout)) is not None:
            self._post(self._heard, *message)

    def _hear(self) -> None:
        """Pass on what the child writes into its log."""
        assert self._process.stderr is not None
        with contextlib.suppress(OSError, ValueError):  # closed
            for line in self._process.stderr:
                text = line.decode(errors="replace").rstrip("\n")
                self._post(self._log.append, text)
                sys.stderr.write(text + "\n")
                sys.stderr.flush()

    def _wait(self) -> None:
        code = self._process.wait()
        for reader in self._readers:
            reader.join(1.0)  # not longer: what the child has started may hold its pipes
        self._post(self._finish, code)

    async def close(self, timeout: float = LONGEST_END) -> None:
        """End the child: in order if it ends within `timeout` [s], else by force."""
        await asyncio.to_thread(self.close_now, timeout)

    def close_now(self, timeout: float = LONGEST_END) -> None:
        """The same from any thread, which waits for it."""
        if self._process.poll() is None and timeout > 0.0:
            self.tell({"do": "end"})
            with contextlib.suppress(subprocess.TimeoutExpired):
                self._process.wait(timeout)
        if self._process.poll() is None:
            self._process.kill()
        self._process.wait()
        self._writer.close(0.1)
        for thread in (*self._readers, self._waiter):
            thread.join(1.0)
        for pipe in (self._process.stdin, self._process.stdout, self._process.stderr):
            with contextlib.suppress(OSError):
                if pipe is not None:
                    pipe.close()
        _alive.discard(self)


def _thread(target: Callable[[], None], name: str) -> threading.Thread:
    thread = threading.Thread(target=target, name=name, daemon=True)
    thread.start()
    return thread


def _fail(answer: asyncio.Future[Answer], reason: str | AmorsimError) -> None:
    if not answer.done():
        answer.set_exception(AmorsimError(reason) if isinstance(reason, str) else reason)


def _look_at(answer: asyncio.Future[Answer]) -> None:
    """Take note of an error that nobody waits for any more."""
    if not answer.cancelled():
        answer.exception()


def _end_all() -> None:
    for link in list(_alive):
        link.close_now()


atexit.register(_end_all)
