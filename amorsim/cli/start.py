"""The entry point: handles Ctrl-C before a command begins and after it has ended.

Commands answer Ctrl-C themselves. Importing them takes a fifth of a second, in which nothing is begun yet, so Ctrl-C
then ends the process at once, as it ends a program in C; and likewise while the interpreter ends.
"""

from __future__ import annotations

import atexit
import signal
import threading

from amorsim.core.execution.interrupt_signal import raise_interrupt

__all__ = ["answer_interrupts", "main"]


def main() -> None:
    """Run the command line; the exit status is 0 for success, 1 for a difference found, 2 for a user's mistake."""
    _end_on_interrupt()
    try:
        from amorsim.cli.app import main as run

        run()
    finally:
        answer_interrupts()
        atexit.unregister(_end_on_interrupt)
        atexit.register(_end_on_interrupt)  # the last that is registered is called first


def answer_interrupts() -> None:
    """Let Ctrl-C raise `KeyboardInterrupt` from here on, as Python does, but not within the compiler's library."""
    _replace(signal.SIG_DFL, raise_interrupt)


def _end_on_interrupt() -> None:
    _replace(signal.default_int_handler, signal.SIG_DFL)
    _replace(raise_interrupt, signal.SIG_DFL)


def _replace(present: object, handler: signal._HANDLER) -> None:
    """Handle Ctrl-C by `handler` if it is handled by `present`, and not, for example, ignored by a shell's wish."""
    if threading.current_thread() is threading.main_thread() and signal.getsignal(signal.SIGINT) is present:
        signal.signal(signal.SIGINT, handler)
