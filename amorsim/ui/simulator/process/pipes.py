"""Messages between two processes over pipes: a kind, a length, and that many bytes."""

from __future__ import annotations

import json
import queue
import struct
import threading
from collections.abc import Mapping
from typing import IO, Any

from amorsim.core.execution.processes import python_command

__all__ = ["FRAME", "JSON", "SNAPSHOT", "Writer", "python_for", "read_message"]

JSON, FRAME, SNAPSHOT = b"J", b"F", b"S"
_HEAD = struct.Struct("<cI")
LARGEST = 1 << 30


def python_for(module: str) -> list[str]:
    """The command that runs `main` of a module in another process with the same import paths.

    While the module is loaded the process ends with its standard input; `main` is to `stay` (see
    `amorsim.ui.simulator.process.orphan`) and to read that.
    """
    return python_command(
        "from amorsim.ui.simulator.process.orphan import leave_with_the_session; leave_with_the_session(); "
        f"from {module} import main; main()"
    )


def read_message(pipe: IO[bytes]) -> tuple[bytes, bytes] | None:
    """The kind and bytes of the next message; None at the end, also if it is in the middle of a message."""
    head = _read(pipe, _HEAD.size)
    if head is None:
        return None
    kind, size = _HEAD.unpack(head)
    if kind not in (JSON, FRAME, SNAPSHOT) or size > LARGEST:
        return None
    data = _read(pipe, size)
    return None if data is None else (kind, data)


def _read(pipe: IO[bytes], size: int) -> bytes | None:
    data = b""
    while len(data) < size:
        try:
            part = pipe.read(size - len(data))
        except (OSError, ValueError):  # closed
            return None
        if not part:
            return None
        data += part
    return data


class Writer:
    """Writes messages in a thread of its own, so that the sender never waits for the reader.

    Few messages wait, since nearly every one is an answer to a command.
    """

    def __init__(self, pipe: IO[bytes]) -> None:
        self._pipe = pipe
        self._waiting: queue.SimpleQueue[bytes | None] = queue.SimpleQueue()
        self._thread = threading.Thread(target=self._write, name="amorsim-writer", daemon=True)
        self._thread.start()

    def send(self, message: Mapping[str, Any]) -> None:
        """Send a table of plain values."""
        self._put(JSON, json.dumps(message).encode())

    def send_frame(self, data: bytes) -> None:
        """Send the bytes of a frame."""
        self._put(FRAME, data)

    def send_snapshot(self, data: bytes) -> None:
        """Send the bytes of a snapshot."""
        self._put(SNAPSHOT, data)

    def _put(self, kind: bytes, data: bytes) -> None:
        self._waiting.put(_HEAD.pack(kind, len(data)) + data)

    def _write(self) -> None:
        while (data := self._waiting.get()) is not None:
            try:
                self._pipe.write(data)
                self._pipe.flush()
            except (OSError, ValueError):  # nobody reads any more
                return

    def close(self, timeout: float = 1.0) -> None:
        """Write the remaining messages, for at most so long [s]."""
        self._waiting.put(None)
        self._thread.join(timeout)
