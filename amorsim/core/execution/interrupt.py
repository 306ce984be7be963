"""Ctrl-C in a run: it ends after the present step, or at once where a user's code does not return."""

from __future__ import annotations

import contextlib
import signal
import sys
import threading
import traceback
from collections.abc import Callable
from pathlib import Path
from types import FrameType, TracebackType

import numba

from amorsim.core.error_text import users_lines
from amorsim.core.execution.interrupt_signal import interrupt_main, raise_interrupt

__all__ = ["Interrupt"]

PATIENCE = 0.5  # [s] that a user's code gets to return after Ctrl-C
_COMPILER = Path(numba.__file__).parent


class Interrupt:
    """On Ctrl-C, ends the run after the present step, so that all files end with the same step.

    A controller or plugin that does not return within `PATIENCE` is broken off by a `KeyboardInterrupt`. A second
    Ctrl-C raises it wherever the run is. If the program handles the signal itself, or the run is not in its main
    thread, nothing is done.

    Attributes
    ----------
    is_wanted
        Whether Ctrl-C was pressed.
    is_stepping
        Whether a step is being made: only then is a user's code broken off.
    """

    def __init__(self) -> None:
        self.is_wanted = False
        self._before: signal._HANDLER = None  # the handler that is put back
        self._has_ended = threading.Event()
        self.is_stepping = False
        self._is_ours = False  # the next signal, which comes from `_watch`
        self._within: FrameType | None = None  # whatever it calls is part of the run

    def __enter__(self) -> Interrupt:
        before = signal.getsignal(signal.SIGINT)
        is_raised = before is signal.default_int_handler or before is raise_interrupt
        if is_raised and threading.current_thread() is threading.main_thread():
            self._within = sys._getframe(1)
            signal.signal(signal.SIGINT, self._note)
            self._before = before
        return self

    def call(self, step: Callable[[], None]) -> None:
        """Make a step of the run; the error for code that was broken off in it names the place."""
        self.is_stepping = True
        try:
            step()
        except KeyboardInterrupt as error:
            self._explain(error)
            raise
        finally:
            self.is_stepping = False

    def _note(self, number: int, frame: FrameType | None) -> None:
        if self._is_ours:
            self._is_ours = False
            if self.is_stepping and self._users_stack(frame):  # else it has returned meanwhile
                raise KeyboardInterrupt
        elif self.is_wanted:
            raise_interrupt(number, frame)
        else:
            self.is_wanted = True
            threading.Thread(target=self._watch, name="amorsim-interrupt", daemon=True).start()

    def _watch(self) -> None:
        """Break off a user's code that does not return."""
        main = threading.main_thread().ident or 0
        while not self._has_ended.wait(PATIENCE):
            if self.is_stepping and self._users_stack(sys._current_frames().get(main)):
                self._is_ours = True
                interrupt_main()

    def _users_stack(self, frame: FrameType | None) -> list[str]:
        """The lines of the user's code that is running; none if amorsim's own code runs or compiles."""
        stack = traceback.StackSummary()
        while frame is not None and frame is not self._within:
            summary = traceback.FrameSummary(frame.f_code.co_filename, frame.f_lineno, frame.f_code.co_name)
            stack.insert(0, summary)
            frame = frame.f_back
        if any(Path(summary.filename).is_relative_to(_COMPILER) for summary in stack):
            return []
        return users_lines(stack)

    def _explain(self, error: KeyboardInterrupt) -> None:
        """Add to an error the place in the user's code where it occurred."""
        lines = users_lines(traceback.extract_tb(error.__traceback__))
        if lines:
            error.add_note("\n".join(["this did not return:", *lines]))

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._has_ended.set()
        self._within = None
        if self._before is not None:
            with contextlib.suppress(ValueError):
                signal.signal(signal.SIGINT, self._before)
