"""The process that reads documents for the Editor. It is ended if it takes too long; the server goes on."""

from __future__ import annotations

import contextlib
import pickle
import subprocess
import threading
from typing import Any

from amorsim.core.errors import AmorsimError
from amorsim.core.execution.processes import end_with_children
from amorsim.ui.simulator.process.pipes import python_for

__all__ = ["Reader", "ReaderError"]

LONGEST = 30.0  # [s] that a request may take; a large map takes one of them
_START = 120.0  # [s] that the process may take until it is there: it loads numpy and numba


class ReaderError(AmorsimError):
    """A request that was not answered: it took too long, or its process ended."""


class _EndedError(Exception):
    """The process has ended."""


class Reader:
    """A process that answers one request at a time. If it was ended, the next request starts another.

    Its functions are those of `amorsim.ui.editor.reader_child`.

    Parameters
    ----------
    time_limit
        How long a request may take [s], once the process is there.
    """

    def __init__(self, time_limit: float = LONGEST) -> None:
        self.time_limit = time_limit
        self._asking = threading.Lock()
        self._changing = threading.Lock()
        self._process: subprocess.Popen[bytes] | None = None
        self._is_there = False  # whether it has reported so
        self._is_late = False
        self._is_closed = False

    def start(self) -> None:
        """Start the process if there is none; does not wait until it is ready."""
        with self._changing:
            if self._is_closed:
                raise ReaderError("it is closed")
            if self._process is None or self._process.poll() is not None:
                self._drop()
                self._process = subprocess.Popen(
                    python_for("amorsim.ui.editor.reader_child"),
                    stdin=subprocess.PIPE,
                    stdout=subprocess.PIPE,
                    start_new_session=True,
                )
                self._is_there = False

    def ask(self, name: str, /, **arguments: Any) -> Any:
        """Call a function in the process; returns its result.

        Raises
        ------
        ReaderError
            If it takes longer than the time limit, or its process ends.
        AmorsimError
            What the function raises, with its words.
        """
        with self._asking:
            try:
                is_ok, answer = self._asked(name, arguments)
            except _EndedError:  # perhaps before it was asked: somebody has killed it
                try:
                    is_ok, answer = self._asked(name, arguments)
                except _EndedError:
                    raise ReaderError("reading it ended its process") from None
        if not is_ok:
            raise AmorsimError(answer)
        return answer

    def _asked(self, name: str, arguments: dict[str, Any]) -> tuple[bool, Any]:
        self.start()
        process = self._process
        if process is None:
            raise ReaderError("it is closed")
        assert process.stdin is not None
        try:
            if not self._is_there:
                self._answer(process, _START)
                self._is_there = True
            pickle.dump((name, arguments), process.stdin)
            process.stdin.flush()
            found: tuple[bool, Any] = self._answer(process, self.time_limit)
        except (OSError, EOFError, ValueError, pickle.UnpicklingError):
            is_late, self._is_late = self._is_late, False
            is_meant = process is not self._process  # it was ended by `kill` or `close`
            self.kill()
            if is_late:
                raise ReaderError(f"reading it took longer than {self.time_limit:g} s") from None
            if is_meant:
                raise ReaderError("reading it was broken off") from None
            raise _EndedError from None
        return found

    def _answer(self, process: subprocess.Popen[bytes], seconds: float) -> Any:
        assert process.stdout is not None
        timer = threading.Timer(seconds, self._end_late, (process,))
        timer.daemon = True
        timer.start()
        try:
            return pickle.load(process.stdout)
        finally:
            timer.cancel()

    def _end_late(self, process: subprocess.Popen[bytes]) -> None:
        self._is_late = True
        end_with_children(process)

    def kill(self) -> None:
        """End the process; the next request starts another."""
        with self._changing:
            self._drop()

    def close(self) -> None:
        """End the process for good; calling it again does nothing."""
        with self._changing:
            self._is_closed = True
            self._drop()

    def _drop(self) -> None:
        process, self._process = self._process, None
        if process is None:
            return
        end_with_children(process)
        for pipe in (process.stdin, process.stdout):
            assert pipe is not None
            with contextlib.suppress(OSError, ValueError):
                pipe.close()
