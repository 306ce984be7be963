"""Text files that hold whole lines whenever a process is killed."""

from __future__ import annotations

import os
import time
from pathlib import Path

__all__ = ["LineFile"]

LONGEST_WAIT = 0.5  # [s] of the clock on the wall, between a line and the disk
LARGEST_BUFFER = 1 << 20  # bytes


class LineFile:
    """A file that lines are appended to; they reach the system in one piece, at most half a second later."""

    def __init__(self, path: Path, header: str) -> None:
        # Unbuffered: what is held back is held here, and handed over in whole lines.
        self._descriptor = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_TRUNC, 0o644)
        self._lines = [header + "\n"]
        self._size = 0
        self.flush()

    def write(self, lines: str) -> None:
        """Append whole lines, each with its line end."""
        self._lines.append(lines)
        self._size += len(lines)
        if self._size > LARGEST_BUFFER or time.monotonic() - self._flushed > LONGEST_WAIT:
            self.flush()

    def flush(self) -> None:
        """Hand everything over to the system."""
        data = memoryview("".join(self._lines).encode())
        while len(data):  # a full disk or a signal may cut a write short
            data = data[os.write(self._descriptor, data) :]
        self._lines = []
        self._size = 0
        self._flushed = time.monotonic()

    def close(self) -> None:
        """Hand everything over and close."""
        if self._descriptor >= 0:
            self.flush()
            os.close(self._descriptor)
            self._descriptor = -1
