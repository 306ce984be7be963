"""Atomic file writes: a file is replaced completely or not at all.

Everything that amorsim writes, other than the lines that a run appends to, goes through here: into a temporary folder
next to the file, to the disk, and only then over the old file. A failure or a kill leaves the old file unchanged; what
a kill leaves of the temporary folder is removed by the next process that writes there.
"""

from __future__ import annotations

import contextlib
import errno
import os
import shutil
from collections.abc import Iterator
from pathlib import Path

from amorsim.core.arguments import path_of
from amorsim.core.errors import AmorsimError, RunError
from amorsim.core.files.temporary_folders import make_folder

__all__ = [
    "check_place",
    "copy_file",
    "create_text",
    "make_folders",
    "new_file",
    "replacing",
    "write_bytes",
    "write_text",
]

_NO_LINKS = (errno.EPERM, errno.ENOTSUP, errno.ENOSYS)  # of disks that know no second name for a file


@contextlib.contextmanager
def replacing(
    path: str | os.PathLike[str], error: type[AmorsimError] = RunError, *, within: Path | None = None
) -> Iterator[Path]:
    """A path of the same name in a temporary folder; what is written there replaces `path` at the end.

    Files written next to it replace those next to `path`. Permissions stay as they were. If the block raises, nothing
    is replaced.

    Parameters
    ----------
    path
        The file, which need not exist.
    error
        The exception raised in place of an `OSError` from the block or from the replacing.
    within
        The folder in which the file must stay, for names that amorsim chose: folders are made, and links below
        `within` are replaced, never followed. Without it, for a file that the user named, a link stays a link: the
        file that it leads to is replaced.
    """
    path = path_of(path, "path")
    try:
        target = _target(path, within)
        with new_file(path.name, target.parent) as new:
            yield new
            _sync_all(new.parent)
            if target.exists() and not target.is_symlink():
                shutil.copymode(target, new)
            for file in sorted(new.parent.rglob("*")):  # first, because the file itself may name them
                if file.is_file() and file != new:
                    place = path.parent / file.relative_to(new.parent)
                    make_folders(place.parent, path.parent if within is None else within)
                    file.replace(place)
            new.replace(target)
    except OSError as problem:
        raise error(f"{path}: cannot be written ({problem.strerror or problem})") from problem


def create_text(path: Path, text: str) -> None:
    """Write a text file that must not be there yet: of several processes that try, one succeeds.

    Raises
    ------
    FileExistsError
        If it is there.
    RunError
        If it cannot be written.
    """
    try:
        with new_file(path.name, path.parent) as new:
            new.write_bytes(text.encode())
            _sync_all(new.parent)
            try:
                os.link(new, path)
            except OSError as problem:
                if problem.errno not in _NO_LINKS:
                    raise
                if path.exists():
                    raise FileExistsError(errno.EEXIST, os.strerror(errno.EEXIST)) from None
                new.replace(path)
    except FileExistsError:
        raise
    except OSError as problem:
        raise RunError(f"{path}: cannot be written ({problem.strerror or problem})") from problem


def check_place(path: str | os.PathLike[str], error: type[AmorsimError] = RunError) -> None:
    """Raise what `replacing` would raise if no file can be written at a place: before long computations."""
    path = path_of(path, "path")
    try:
        with new_file(path.name, _target(path, None).parent):
            pass
    except OSError as problem:
        raise error(f"{path}: cannot be written ({problem.strerror or problem})") from problem


def make_folders(folder: Path, within: Path) -> None:
    """Make `within` and the folders from there to `folder`; links among them are replaced.

    Raises
    ------
    OSError
        If one cannot be made.
    """
    within.mkdir(parents=True, exist_ok=True)
    for each in reversed([folder, *folder.parents][: len(folder.relative_to(within).parts)]):
        if each.is_symlink():
            each.unlink()
        each.mkdir(exist_ok=True)


@contextlib.contextmanager
def new_file(name: str, parent: Path) -> Iterator[Path]:
    """A file or folder of this name to be written, in a temporary folder in `parent`, which is removed at the end."""
    folder = make_folder(parent)
    try:
        yield folder / name
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def _target(path: Path, within: Path | None) -> Path:
    """The file that is replaced; raises `OSError` if it cannot be."""
    if within is not None:
        if not path.is_relative_to(within):
            raise OSError(errno.EINVAL, f"it is not within {within}")
        make_folders(path.parent, within)
        if path.is_symlink():
            return path
    try:
        target = Path(os.path.realpath(path)) if within is None else path
    except ValueError as problem:  # a zero byte, which no system has in a name
        raise OSError(errno.EINVAL, str(problem)) from None
    _refuse_to_replace(target)
    return target


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


def _sync_all(folder: Path) -> None:
    for file in folder.rglob("*"):
        if file.is_file():
            with file.open("rb+") as opened:
                os.fsync(opened.fileno())


def write_bytes(path: str | os.PathLike[str], data: bytes, *, within: Path | None = None) -> None:
    """Write a file; `within` is that of `replacing`.

    Raises
    ------
    RunError
        If it cannot be written; the old file stays then.
    """
    with replacing(path, within=within) as new:
        new.write_bytes(data)


def write_text(path: str | os.PathLike[str], text: str, *, within: Path | None = None) -> None:
    """Write a text file, in UTF-8 and with the line ends of `text`; as `write_bytes`."""
    write_bytes(path, text.encode(), within=within)


def copy_file(source: str | os.PathLike[str], path: str | os.PathLike[str]) -> None:
    """Copy the content of a file; raises as `write_bytes`, and if `source` cannot be read."""
    try:
        data = Path(source).read_bytes()
    except OSError as problem:
        where = Path(path).parent
        raise RunError(f"{source}: cannot be copied into {where} ({problem.strerror or problem})") from problem
    write_bytes(path, data)
