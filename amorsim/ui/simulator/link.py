"""The link from a session to one child process: started, spoken with, ended."""

from __future__ import annotations

import atexit
import collections
import concurrent.futures
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
from amorsim.ui.simulator.pipes import FRAME, SNAPSHOT, Writer, python_for, read_message

__all__ = ["Link"]

Answer = dict[str, Any]

LONGEST_END = 1.8  # [s] that a child gets to end with whole files
LAST_WORDS = 60  # lines of its log that are kept

_alive: weakref.WeakSet[Link] = weakref.WeakSet()


class Link:
    """A child process.

    Parameters
    ----------
    order
        What it is to simulate (see `amorsim.ui.simulator.child.main`).
    carried
        The snapshot that it is to go on from, as another child gave it; None for none.
    on_frame, on_end
        Called in a thread with the bytes of each frame, and with the link when the process has ended.

    Attributes
    ----------
    ready
        Its scene, once the simulation is made; an `AmorsimError` where it cannot be.
    inputs
        What was given to it, as far as it told.
    tick
        The last that it told of.
    carried
        The last snapshot that another child can go on from, or None.
    uncarried
        Why there is none, where there cannot be any.
    folder
        What it writes the run into.
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
        self.ready: concurrent.futures.Future[Answer] = concurrent.futures.Future()
        self.inputs: list[dict[str, Any]] = list(order["inputs"])
        self.tick: int = order["tick"]
        self.carried = carried
        self.uncarried = ""
        self.folder = ""
        self.end = ""
        self._log: collections.deque[str] = collections.deque(maxlen=LAST_WORDS)
        self._on_frame, self._on_end = on_frame, on_end
        self._numbers = itertools.count(1)
        self._open: dict[int, concurrent.futures.Future[Answer]] = {}
        self._pings: set[int] = set()  # which of the open ones are signs of life
        self._lock = threading.Lock()
        self._has_ended = False
        # In a session of its own, where there are such: Ctrl-C in the terminal is for the session alone.
        self._process = subprocess.Popen(
            python_for("amorsim.ui.simulator.child"),
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
        self._threads = [
            threading.Thread(target=target, name=name, daemon=True)
            for target, name in ((self._read, "amorsim-link"), (self._hear, "amorsim-log"))
        ]
        for thread in self._threads:
            thread.start()
        _alive.add(self)

    @property
    def is_alive(self) -> bool:
        """Whether it can answer."""
        return not self._has_ended

    @property
    def pid(self) -> int:
        """The number of the process."""
        return self._process.pid

    @property
    def last_words(self) -> str:
        """The last lines of its log."""
        return "\n".join(self._log)

    def send(self, command: Mapping[str, Any]) -> concurrent.futures.Future[Answer]:
        """Send a command; the answer comes in time.

        Raises
        ------
        AmorsimError
            If it has ended.
        """
        answer: concurrent.futures.Future[Answer] = concurrent.futures.Future()
        with self._lock:
            if self._has_ended:
                raise AmorsimError("the simulation has ended by itself")
            number = next(self._numbers)
            self._open[number] = answer
            if command.get("do") == "ping":
                self._pings = {number, *(ping for ping in self._pings if ping in self._open)}
        self._writer.send({**command, "id": number})
        return answer

    def give_up(self, reason: str) -> None:
        """Answer what waits with an `AmorsimError`, signs of life apart; a late answer is thrown away."""
        with self._lock:
            waiting = [number for number in self._open if number not in self._pings]
            answers = [self._open.pop(number) for number in waiting]
        for answer in answers:
            if answer.set_running_or_notify_cancel():
                answer.set_exception(AmorsimError(reason))

    def tell(self, command: Mapping[str, Any]) -> None:
        """Send what has no answer."""
        self._writer.send(command)

    def _read(self) -> None:
        assert self._process.stdout is not None
        while (message := read_message(self._process.stdout)) is not None:
            kind, data = message
            if kind == FRAME:
                self._on_frame(data)
                continue
            if kind == SNAPSHOT:
                self.carried = data
                continue
            table = json.loads(data)
            if "push" in table:
                self._pushed(table)
                continue
            with self._lock:
                answer = self._open.pop(table.pop("id"), None)
            if answer is not None and answer.set_running_or_notify_cancel():
                answer.set_result(table)
        self._finish()

    def _pushed(self, table: Answer) -> None:
        kind = table["push"]
        if kind == "ready":
            self.folder = table["folder"]
            self.ready.set_result(table)
        elif kind == "failed":
            self.ready.set_exception(AmorsimError(table["error"]))
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

    def _finish(self) -> None:
        code = self._process.wait()
        self.end = f"signal {-code}" if code < 0 else f"exit status {code}"
        self._threads[1].join(1.0)
        with self._lock:
            self._has_ended = True
        if not self.ready.done():
            self.ready.set_exception(
                AmorsimError(f"the simulation could not be started ({self.end})\n{self.last_words}")
            )
        self._on_end(self)  # before the answers: whose command fails shall find why
        with self._lock:
            unanswered = list(self._open.values())
            self._open.clear()
        for answer in unanswered:
            if answer.set_running_or_notify_cancel():
                answer.set_exception(AmorsimError(f"the simulation has ended by itself ({self.end})"))

    def _hear(self) -> None:
        """Pass on what it writes into its log."""
        assert self._process.stderr is not None
        for line in self._process.stderr:
            text = line.decode(errors="replace").rstrip("\n")
            self._log.append(text)
            with contextlib.suppress(OSError, ValueError):
                sys.stderr.write(text + "\n")
                sys.stderr.flush()

    def close(self, timeout: float = LONGEST_END) -> None:
        """End it: in order where it can within `timeout` [s], else by force."""
        if self._process.poll() is None and timeout > 0.0:
            self.tell({"do": "end"})
            with contextlib.suppress(subprocess.TimeoutExpired):
                self._process.wait(timeout)
        if self._process.poll() is None:
            self._process.kill()
        self._process.wait()
        self._writer.close(0.1)
        for thread in self._threads:
            if thread is not threading.current_thread():
                thread.join(1.0)
        for pipe in (self._process.stdin, self._process.stdout, self._process.stderr):
            with contextlib.suppress(OSError):
                if pipe is not None:
                    pipe.close()
        _alive.discard(self)


def _end_all() -> None:
    for link in list(_alive):
        link.close()


atexit.register(_end_all)
