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
from typing import Any

from amorsim.kernels import compile as compiling

__all__ = ["take_turns"]

LONGEST = 60.0  # [s] that one kernel takes at most; after that its claim counts for nothing
PAUSE = 0.005  # [s]


class _Claims:
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


def take_turns() -> None:
    """From now on, let this process and others that do the same compile each kernel once between them."""
    folder = compiling._cache_folder()
    cache: Any = compiling._KernelCache
    if folder is None or hasattr(cache, "claims"):
        return
    claims = cache.claims = _Claims(folder)
    load, save = cache.load_overload, cache.save_overload

    def path_of(self: Any, signature: Any) -> Path:
        function = self._py_func
        return claims.path(f"{function.__module__}.{function.__qualname__}", str(signature))

    def load_or_claim(self: Any, signature: Any, target: Any) -> Any:
        found = load(self, signature, target)
        path = path_of(self, signature)
        while found is None:
            is_claimed = claims.try_for(path)
            if not is_claimed:
                time.sleep(PAUSE)
                if path.exists():
                    continue
            # Whoever had the claim has saved the kernel, unless compiling it failed.
            found = load(self, signature, target)
            if is_claimed:
                break
        if found is not None:
            claims.give_up(path)
        return found

    def save_and_give_up(self: Any, signature: Any, compiled: Any) -> None:
        try:
            save(self, signature, compiled)
        finally:
            claims.give_up(path_of(self, signature))

    cache.load_overload = load_or_claim
    cache.save_overload = save_and_give_up
