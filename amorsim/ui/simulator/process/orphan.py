"""A process that a session started, and its end where the session ends while it is still being loaded.

Later it reads its standard input, whose end shows that nobody waits any more. But until numpy and numba are loaded it
reads nothing, which takes a second, and many of them on a machine that has much else to do. Loads nothing itself.
"""

from __future__ import annotations

import os
import select
import threading

__all__ = ["is_child", "leave_with_the_session", "stay"]

_stays = threading.Event()
_has_session = threading.Event()


def leave_with_the_session() -> None:
    """End this process as soon as the other end of standard input is closed, until `stay` is called."""
    _has_session.set()
    if hasattr(select, "poll"):  # not on Windows
        threading.Thread(target=_watch, name="amorsim-orphan", daemon=True).start()


def stay() -> None:
    """Leave it to the reader of standard input."""
    _stays.set()


def is_child() -> bool:
    """Whether this process was started by a session."""
    return _has_session.is_set()


def _watch() -> None:
    pipe = select.poll()
    pipe.register(0, 0)  # for its end alone, which comes also where something is still to be read
    pipe.poll()
    if not _stays.is_set():
        os._exit(1)
