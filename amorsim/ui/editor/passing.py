"""The temporary folder of an Editor's session, and those that killed processes have left."""

from __future__ import annotations

import contextlib
import os
import shutil
import tempfile
import time
from pathlib import Path
from typing import IO

from amorsim.core.errors import AmorsimError

__all__ = ["PassingFolder"]

PREFIX = "amorsim-edit-"
LOCK = ".lock"  # locked for as long as the folder is used
OLDEST = 60.0  # [s] that a folder without a lock may be new: its session is about to lock it


class PassingFolder:
    """A temporary folder, locked by this process. Making one removes those of processes that have ended."""

    def __init__(self) -> None:
        _remove_left()
        self._path = Path(tempfile.mkdtemp(prefix=PREFIX))
        self._lock: IO[bytes] | None = (self._path / LOCK).open("ab")
        _is_locked_by_us(self._lock)

    @property
    def path(self) -> Path:
        """The folder.

        Raises
        ------
        AmorsimError
            If it has been removed: nothing more is to be written there.
        """
        if self._lock is None:
            raise AmorsimError("the Editor is ending")
        return self._path

    def remove(self) -> None:
        """Delete it with all that it holds; calling it again does nothing."""
        if self._lock is not None:
            self._lock.close()
            self._lock = None
            shutil.rmtree(self._path, ignore_errors=True)


def _is_locked_by_us(stream: IO[bytes]) -> bool:
    """Lock a file for this process; false if another has it, or files cannot be locked here."""
    try:
        import fcntl
    except ImportError:  # on Windows
        return False
    try:
        fcntl.flock(stream, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        return False
    return True


def _remove_left() -> None:
    """Remove the user's folders that no process holds any more."""
    with contextlib.suppress(OSError):
        for folder in Path(tempfile.gettempdir()).glob(f"{PREFIX}*"):
            with contextlib.suppress(OSError):
                if _is_left(folder):
                    shutil.rmtree(folder, ignore_errors=True)


def _is_left(folder: Path) -> bool:
    found = folder.lstat()
    is_ours = folder.is_dir() and not folder.is_symlink() and (os.name == "nt" or found.st_uid == os.getuid())
    if not is_ours or time.time() - found.st_mtime < OLDEST:
        return False
    with (folder / LOCK).open("ab") as lock:
        return _is_locked_by_us(lock)
