"""Atomic file writes: a file is replaced completely or not at all.

Everything that amorsim writes, other than the lines that a run appends to, goes through here: into a temporary folder
next to the file, to the disk, and only then over the old file. A failure or a kill leaves the old file unchanged.
"""

from __future__ import annotations

import contextlib
import errno
import os
import shutil
import tempfile
from collections.abc import Iterator
from pathlib import Path

from amorsim.core.arguments import path_of
from amorsim.core.errors import AmorsimError, RunError

__all__ = ["check_place", "copy_file", "replacing", "write_bytes", "write_text"]

PREFIX = ".amorsim-"  # of the temporary folders; one that a kill left behind may be removed


@contextlib.contextmanager
def replacing(path: str | os.PathLike[str], error: type[AmorsimError] = RunError) -> Iterator[Path]:
    """A path of the same name in a temporary folder; what is written there replaces `path` at the end.

    Files written next to it replace those next to `path`. A link stays a link: the file that it leads to is replaced.
    Permissions stay as they were. If the block raises, nothing is replaced.

    Parameters
    ----------
    path
        The file, which need not exist.
    error
        The exception raised in place of an `OSError` from the block or from the replacing.
    """
    path = path_of(path, "path")
    try:
        target = _real(path)
        _refuse_to_replace(target)
        folder = Path(tempfile.mkdtemp(prefix=PREFIX, dir=target.parent))
        try:
            new = folder / path.name
            yield new
            beside = [file for file in folder.rglob("*") if file.is_file() and file != new]
            for file in (*beside, new):
                _sync(file)
            if target.exists():
                shutil.copymode(target, new)
            for file in beside:  # first, because the file itself may name them
                place = path.parent / file.relative_to(folder)
                place.parent.mkdir(parents=True, exist_ok=True)
                file.replace(place)
            new.replace(target)
        finally:
            shutil.rmtree(folder, ignore_errors=True)
    except OSError as problem:
        raise error(f"{path}: cannot be written ({problem.strerror or problem})") from problem


def check_place(path: str | os.PathLike[str], error: type[AmorsimError] = RunError) -> None:
    """Raise what `replacing` would for a place where no file can be written: before it is long computed."""
    path = path_of(path, "path")
    try:
        target = _real(path)
        _refuse_to_replace(target)
        shutil.rmtree(tempfile.mkdtemp(prefix=PREFIX, dir=target.parent))
    except OSError as problem:
        raise error(f"{path}: cannot be written ({problem.strerror or problem})") from problem


def _real(path: Path) -> Path:
    """Where a path leads to."""
    try:
        return Path(os.path.realpath(path))
    except ValueError as problem:  # a zero byte, which no system has in a name
        raise OSError(errno.EINVAL, str(problem)) from None


def _refuse_to_replace(target: Path) -> None:
    """Raise if the file could not be opened for writing, or is not a file."""
    if target.is_dir():
        raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR))
    if not target.exists():
        return
    if not target.is_file():
        raise OSError(errno.EINVAL, "it is a device or a pipe; name a file")
    if not os.access(target, os.W_OK):
        raise PermissionError(errno.EACCES, os.strerror(errno.EACCES))


def _sync(file: Path) -> None:
    with file.open("rb+") as opened:
        os.fsync(opened.fileno())


def write_bytes(path: str | os.PathLike[str], data: bytes) -> None:
    """Write a file.

    Raises
    ------
    RunError
        If it cannot be written; the old file stays then.
    """
    with replacing(path) as new:
        new.write_bytes(data)


def write_text(path: str | os.PathLike[str], text: str) -> None:
    """Write a text file, in UTF-8 and with the line ends of `text`; raises as `write_bytes`."""
    write_bytes(path, text.encode())


def copy_file(source: str | os.PathLike[str], path: str | os.PathLike[str]) -> None:
    """Copy the content of a file; raises as `write_bytes`, and if `source` cannot be read."""
    try:
        data = Path(source).read_bytes()
    except OSError as problem:
        where = Path(path).parent
        raise RunError(f"{source}: cannot be copied into {where} ({problem.strerror or problem})") from problem
    write_bytes(path, data)
