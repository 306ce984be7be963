"""Processes that compile side by side take turns at kernels: what one compiles, another waits for and loads.

Without this, two processes that need the same kernel at the same time both compile it. A claim is a file beside the
kernels' cache that names the process; it is made before compiling and taken away when the kernel is in the cache. A
process waits only for kernels that the one it compiles calls, so two never wait for each other.
"""

from __future__ import annotations

import contextlib
import hashlib
import os
import time
from pathlib import Path

__all__ = ["LONGEST", "PAUSE", "Claims"]

LONGEST = 60.0  # [s] that one kernel takes at most; after that its claim counts for nothing
PAUSE = 0.005  # [s]


class Claims:
    """Claims of this process in a folder."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._held: set[Path] = set()

    def path(self, kernel: str, signature: str) -> Path:
        """Where the claim of a kernel and the types of its arguments lies."""
        return self._folder / f"{hashlib.blake2b(f'{kernel} {signature}'.encode(), digest_size=12).hexdigest()}.claim"

    def try_for(self, path: Path) -> bool:
        """Claim, if nobody has; or if whoever has is gone or takes too long. Where no file can be made, true."""
        if path in self._held:
            return True
        try:
            if path.exists() and _is_void(path):
                path.unlink(missing_ok=True)
            with path.open("x", encoding="ascii") as file:
                file.write(str(os.getpid()))
        except (FileExistsError, FileNotFoundError):  # somebody else was quicker, to make it or to take it away
            return False
        except OSError:
            return True
        self._held.add(path)
        return True

    def is_taken(self, path: Path) -> bool:
        """Whether somebody else has claimed, and is at it."""
        try:
            return path not in self._held and path.exists() and not _is_void(path)
        except OSError:  # it was taken away in between
            return False

    def give_up(self, path: Path) -> None:
        """Take a claim away, if it is this process's."""
        if path in self._held:
            self._held.discard(path)
            with contextlib.suppress(OSError):
                path.unlink(missing_ok=True)


def _is_void(path: Path) -> bool:
    if time.time() - path.stat().st_mtime > LONGEST:
        return True
    if os.name != "posix":  # elsewhere asking whether a process lives may end it
        return False
    owner = path.read_text(encoding="ascii")
    if not owner:  # just made, its name not written yet
        return False
    try:
        os.kill(int(owner), 0)
        if hasattr(os, "waitid"):  # a child of this process that has ended is there until somebody asks how
            with contextlib.suppress(ChildProcessError):
                return os.waitid(os.P_PID, int(owner), os.WEXITED | os.WNOHANG | os.WNOWAIT) is not None
    except ProcessLookupError:
        return True
    except (OSError, ValueError):
        return False
    return False
