"""What keeps the grader's memory from a submission, and ends the processes that one leaves behind; on Linux.

A process may read the memory of others of its user, and there lies the truth. What the system does not offer is left
out: this makes looking hard and is no sandbox.
"""

from __future__ import annotations

import contextlib
import ctypes
import os
import signal
import sys
from collections.abc import Iterator
from pathlib import Path

__all__ = ["MARK", "end_strays", "memory_hidden", "renounce"]

MARK = "AMORSIM_GRADED"
"""The environment variable that a submission's process has, and all that it starts."""

_GET_DUMPABLE, _SET_DUMPABLE, _DROP_BOUND = 3, 4, 24  # of prctl(2)
_TRACE = 19  # CAP_SYS_PTRACE of capabilities(7)
_VERSION = 0x20080522  # of capset(2), the third


class _Header(ctypes.Structure):
    _fields_ = (("version", ctypes.c_uint32), ("process", ctypes.c_int))


class _Capabilities(ctypes.Structure):
    _fields_ = tuple((name, ctypes.c_uint32) for name in ("effective", "permitted", "inheritable"))


@contextlib.contextmanager
def memory_hidden() -> Iterator[None]:
    """While this lasts, other processes of this user cannot read this one's memory."""
    system = _system()
    if system is None or system.prctl(_GET_DUMPABLE, 0, 0, 0, 0) != 1:
        yield
        return
    system.prctl(_SET_DUMPABLE, 0, 0, 0, 0)
    try:
        yield
    finally:
        system.prctl(_SET_DUMPABLE, 1, 0, 0, 0)


def renounce() -> None:
    """Give up root's right to read the memory of others, for this process and all that it starts."""
    system = _system()
    if system is None or not hasattr(system, "capset"):
        return
    system.prctl(_DROP_BOUND, _TRACE, 0, 0, 0)  # fails for other users, which have nothing to give up
    header, sets = _Header(_VERSION, 0), (_Capabilities * 2)()
    if system.capget(ctypes.byref(header), sets) == 0:
        for name in ("effective", "permitted", "inheritable"):
            setattr(sets[0], name, getattr(sets[0], name) & ~(1 << _TRACE))
        system.capset(ctypes.byref(header), sets)


def end_strays(mark: str) -> None:
    """End the processes with this mark that left the session of their submission."""
    if _system() is None:
        return
    wanted = f"{MARK}={mark}".encode()
    for entry in Path("/proc").iterdir():
        if entry.name.isdigit() and int(entry.name) != os.getpid():
            with contextlib.suppress(OSError):  # it is another user's, or has ended
                if wanted in (entry / "environ").read_bytes().split(b"\0"):
                    os.kill(int(entry.name), signal.SIGKILL)


def _system() -> ctypes.CDLL | None:
    return ctypes.CDLL(None) if sys.platform == "linux" else None
