"""The work of the simulating thread: how long it has lasted, whose controller it is in, and how to interrupt it."""

from __future__ import annotations

import ctypes
import sys
import threading
import time
import traceback
from types import FrameType
from typing import Any

from amorsim.core.error_text import users_lines
from amorsim.ui.simulator.process.stacks import is_compiling, robot_of

__all__ = ["Busy", "Interrupted"]

LONGEST_QUIET = 1.0  # [s] after which the window shows that kernels are compiled


class Interrupted(BaseException):
    """Raised in a user's controller that does not return; no `except Exception` of his catches it."""


class Busy:
    """The present work of the main thread, for other threads to look at."""

    def __init__(self) -> None:
        self._thread = threading.main_thread().ident or 0
        self._since: float | None = None
        self._in_step = False

    def begin(self, *, in_step: bool = True) -> None:
        """Begin a step or a command: one that may run a controller, or one that does not."""
        self._since, self._in_step = time.monotonic(), in_step

    def end(self) -> None:
        """Be idle again."""
        self._since, self._in_step = None, False

    def sign_of_life(self, patience: float) -> dict[str, Any]:
        """How long the thread has been busy; after `patience` [s] also whose controller blocks it, and where."""
        since = self._since
        held = 0.0 if since is None else time.monotonic() - since
        found: dict[str, Any] = {"held": held}
        if held > LONGEST_QUIET:
            # On a busy machine it can take as long to read kernels from their cache, which is not worth a message.
            found["compiling"] = is_compiling(self._stack()[1], reading_counts=False)
        if self._in_step and held > patience:
            found |= self._where()
        return found

    def interrupt(self) -> None:
        """Break off the controller that the thread is in, if Python can."""
        if self._in_step and self._where():
            ctypes.pythonapi.PyThreadState_SetAsyncExc(ctypes.c_ulong(self._thread), ctypes.py_object(Interrupted))

    def _stack(self) -> tuple[FrameType | None, traceback.StackSummary]:
        frame = sys._current_frames().get(self._thread)
        return frame, traceback.extract_stack(frame) if frame is not None else traceback.StackSummary()

    def _where(self) -> dict[str, Any]:
        """Whose controller blocks the thread, and at which line."""
        frame, stack = self._stack()
        # A kernel that is met for the first time (at a first contact ...) is compiled: that takes its time, and ends.
        lines = [] if is_compiling(stack) else users_lines(stack)
        return {"stack": "\n".join(lines), "robot": robot_of(frame)} if lines else {}
