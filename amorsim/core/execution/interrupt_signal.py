"""Handle Ctrl-C as Python does, but never while the compiler's library is at work.

That library calls back into Python for each kernel that it loads. A `KeyboardInterrupt` raised in there is lost, and
can end the process by a segmentation fault. So the signal is sent again until the library has returned.
"""

from __future__ import annotations

import signal
import threading
from types import FrameType

__all__ = ["interrupt_main", "raise_interrupt"]

RETRY = 0.02  # [s] until a signal that came in the compiler's library is sent again
_LIBRARY = "llvmlite"
_pending: list[threading.Timer] = []  # which will send it again: at most one, however often Ctrl-C was pressed


def raise_interrupt(_: int, frame: FrameType | None) -> None:
    """Raise `KeyboardInterrupt`, at once or as soon as the compiler's library has returned; a handler of SIGINT."""
    while _pending:
        _pending.pop().cancel()
    if not _is_in_library(frame):
        raise KeyboardInterrupt
    again = threading.Timer(RETRY, interrupt_main)
    again.daemon = True
    _pending.append(again)
    again.start()


def interrupt_main() -> None:
    """Send SIGINT to the main thread, and wake it if it sleeps (not on Windows)."""
    main = threading.main_thread().ident
    if hasattr(signal, "pthread_kill") and main is not None:
        signal.pthread_kill(main, signal.SIGINT)
    else:
        signal.raise_signal(signal.SIGINT)


def _is_in_library(frame: FrameType | None) -> bool:
    while frame is not None:
        if str(frame.f_globals.get("__name__")).partition(".")[0] == _LIBRARY:
            return True
        frame = frame.f_back
    return False
