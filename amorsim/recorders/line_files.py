"""Text files to which complete lines are appended, so that a process may be killed at any time."""

from __future__ import annotations

import contextlib
import os
import threading
from collections.abc import Callable
from pathlib import Path

from amorsim.core.errors import RunError

__all__ = ["LineFile", "LineFiles"]

LONGEST_WAIT = 0.4  # [s] of wall time until a line is handed to the system
LARGEST_BUFFER = 1 << 16  # bytes, of one file
PAGE = 4096  # bytes; when a process is killed, the system breaks off its write only between two pages


class LineFile:
    """A file to which lines are appended; it buffers them and hands them to the system as whole lines.

    It hands over at most a page of memory at a time, so that a kill hardly ever breaks a line.

    Raises
    ------
    RunError
        From each method, if the file cannot be made or written. The file then ends with its last whole line and takes
        no more.
    """

    def __init__(self, path: Path, header: str) -> None:
        self.path = path
        self._lines: list[bytes] = []
        self._size = 0
        self._end = 0  # length of the file's content
        self._problem = ""  # why it takes no more
        try:
            self._descriptor = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_TRUNC, 0o644)
        except OSError as error:
            raise self._failure(error) from None
        try:
            self._hand_over(header.encode() + b"\n")
        except RunError:
            os.close(self._descriptor)
            raise

    def write(self, lines: str | bytes | memoryview) -> None:
        """Append whole lines, each with its line end; bytes are UTF-8. They may be changed afterwards."""
        self._check()
        lines = lines.encode() if isinstance(lines, str) else lines
        if self._size + len(lines) > LARGEST_BUFFER:
            self.flush()
        if len(lines) > LARGEST_BUFFER:  # a copy of this many would cost more than handing them over
            self._hand_over(lines)
            return
        self._lines.append(bytes(lines))
        self._size += len(lines)

    def flush(self) -> None:
        """Hand all buffered lines to the system."""
        self._check()
        if not self._lines:
            return
        data = b"".join(self._lines)
        self._lines = []
        self._size = 0
        self._hand_over(data)

    def _hand_over(self, data: bytes | memoryview) -> None:
        data = bytes(data)
        start = 0
        while start < len(data):
            stop = data.rfind(b"\n", start, start + PAGE) + 1 or data.find(b"\n", start) + 1
            self._write(memoryview(data)[start:stop])
            start = stop

    def _write(self, lines: memoryview) -> None:
        done = 0
        try:
            while done < len(lines):  # a full disk or a signal may cut a write short
                done += os.write(self._descriptor, lines[done:])
        except OSError as error:
            whole = bytes(lines[:done]).rfind(b"\n") + 1
            with contextlib.suppress(OSError):
                os.ftruncate(self._descriptor, self._end + whole)
            failure = self._failure(error)
            self._problem = str(failure)
            raise failure from None
        self._end += done

    def _check(self) -> None:
        # A further line would hide that lines before it are missing.
        if self._problem:
            raise RunError(self._problem)

    def close(self) -> None:
        """Hand everything over and close."""
        if self._descriptor < 0:
            return
        try:
            self.flush()
        finally:
            os.close(self._descriptor)
            self._descriptor = -1

    def _failure(self, error: OSError) -> RunError:
        return RunError(f"{self.path}: cannot be written ({error.strerror or error})")


class LineFiles:
    """The files of a run; lines reach them within half a second after they were written.

    A thread does this, because a step may take long, and any time may pass between steps that a user makes by hand.

    Parameters
    ----------
    hand_over
        Called before lines are handed to the system, by that thread or by `close`, to write lines that are held back
        elsewhere.
    """

    def __init__(self, hand_over: Callable[[], None] | None = None) -> None:
        self._hand_over = hand_over
        self._files: dict[str, LineFile] = {}
        self._lock = threading.Lock()
        self._closing = threading.Event()
        self._thread: threading.Thread | None = None
        self._problem: Exception | None = None

    def add(self, name: str, path: Path, header: str) -> None:
        """Make a file, to be written by its `name`."""
        file = LineFile(path, header)
        with self._lock:
            self._files[name] = file
        if self._thread is None:
            self._thread = threading.Thread(target=self._keep_flushing, name="amorsim-files", daemon=True)
            self._thread.start()

    def check(self) -> None:
        """Raise the error that occurred in the meantime, if any."""
        if self._problem is not None:
            raise self._problem

    def write(self, name: str, lines: str | bytes | memoryview) -> None:
        """Append whole lines to a file."""
        with self._lock:
            self.check()
            self._files[name].write(lines)

    def _keep_flushing(self) -> None:
        while not self._closing.wait(LONGEST_WAIT):
            try:
                if self._hand_over is not None:
                    self._hand_over()
                with self._lock:
                    for file in self._files.values():
                        file.flush()
            except Exception as error:
                self._problem = error  # for the next call of `write`
                return

    def close(self) -> None:
        """Hand everything over and close all files, also after one of them failed."""
        self._closing.set()
        if self._thread is not None:
            self._thread.join()
        problem = self._problem
        self._problem = None
        try:
            if self._hand_over is not None:
                self._hand_over()
        except RunError as error:
            problem = problem or error
        for file in self._files.values():
            try:
                file.close()
            except RunError as error:
                problem = problem or error
        self._files = {}
        if problem is not None:
            raise problem
