"""Temporary folders named after their process, so that those of a killed process can be removed.

A name is ``.amorsim-MACHINE-PROCESS-BEGUN-REST``; in the system's temporary folder, ``amorsim-KIND-MACHINE-...``.
"""

from __future__ import annotations

import contextlib
import functools
import os
import platform
import re
import shutil
import tempfile
import zlib
from collections.abc import Iterator
from pathlib import Path

__all__ = ["HIDDEN", "make_folder", "own_name", "remove_left", "temporary_folder"]

HIDDEN = ".amorsim-"  # how names begin of what is made next to a user's files, for a moment
_NAME = re.compile(r"(?:\.amorsim|amorsim-[a-z]+)-(?P<machine>[0-9a-f]{8})-(?P<process>\d+)-(?P<begun>\d+)-")
_looked: set[Path] = set()  # folders in which this process has removed what was left


def own_name(rest: str, prefix: str = HIDDEN) -> str:
    """A name for a folder that this process makes."""
    process = os.getpid()
    return f"{prefix}{_machine()}-{process}-{_begun(process) or 0}-{rest}"


def make_folder(parent: Path, prefix: str = HIDDEN) -> Path:
    """A new folder in `parent`, named after this process; first removes what ended processes left there.

    Raises
    ------
    OSError
        If it cannot be made.
    """
    if parent not in _looked:
        _looked.add(parent)
        remove_left(parent)
    return Path(tempfile.mkdtemp(prefix=own_name("", prefix), dir=parent))


@contextlib.contextmanager
def temporary_folder(kind: str) -> Iterator[Path]:
    """A folder in the system's temporary folder, removed at the end; `kind` is a word of small letters in its name."""
    folder = make_folder(Path(tempfile.gettempdir()), f"amorsim-{kind}-")
    try:
        yield folder
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def remove_left(parent: Path) -> None:
    """Remove the folders that ended processes of this machine have left in a folder."""
    with contextlib.suppress(OSError), os.scandir(parent) as entries:
        for entry in entries:
            found = _NAME.match(entry.name)
            if found is None or found["machine"] != _machine() or _lives(int(found["process"]), int(found["begun"])):
                continue
            with contextlib.suppress(OSError):
                if entry.is_dir(follow_symlinks=False):
                    shutil.rmtree(entry.path, ignore_errors=True)
                else:
                    Path(entry.path).unlink()


@functools.cache
def _machine() -> str:
    """The identity of this machine or container among others that share a disk and have other processes."""
    try:
        processes = str(Path("/proc/self/ns/pid").readlink())
    except OSError:  # not on Linux
        processes = ""
    return f"{zlib.crc32(f'{platform.node()} {processes}'.encode()):08x}"


def _lives(process: int, begun: int) -> bool:
    """Whether a process is running; true if that is not known."""
    if Path("/proc/self/stat").exists():
        return _begun(process) == begun
    if os.name == "nt":
        return True
    try:
        os.kill(process, 0)
    except (ProcessLookupError, OverflowError):
        return False
    except OSError:  # another user's
        return True
    return True


def _begun(process: int) -> int | None:
    """When a process began, in ticks since the system's start; None if it has ended or that is not known."""
    try:
        words = Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()
    except OSError:
        return None
    return None if words[0] in ("Z", "X") else int(words[19])
