"""The files of a submission, read without following a link."""

from __future__ import annotations

import os
import stat
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path

import attrs

from amorsim.core.errors import ControllerError

__all__ = ["HandedIn", "hand_in", "is_within", "leads_through_link"]

_MOST_FILES = 2000
_MOST_BYTES = 100 * 10**6
_OMITTED = ("__pycache__",)  # and what begins with a dot


@attrs.frozen
class HandedIn:
    """The files of a submission by path, the one to load, and what was left out."""

    name: str
    files: dict[str, bytes]
    left_out: tuple[str, ...] = ()


def hand_in(
    path: Path, others: Iterable[Path] = (), given: Sequence[Path] = (), beside: Sequence[str] = ()
) -> HandedIn:
    """The files of a submission: its folder, if nobody else's files are there, else its file and those `beside` it.

    Symbolic and hard links, and what is not a regular file, are left out.

    Parameters
    ----------
    path
        The submission's file.
    others
        Files and folders of others.
    beside
        Names of files that go with it, if they lie in its folder.
    given
        Files that every submission gets; they replace its own of the same names.

    Raises
    ------
    ControllerError
        If the file is a link or cannot be read, or there is too much.
    """
    folder = path.parent.resolve()
    is_own = not any(is_within(each.resolve(), folder) for each in others)
    files: dict[str, bytes] = {}
    left_out: list[str] = []
    size = 0
    alone = [path.name, *(name for name in beside if (folder / name).is_file())]
    for name in _names(folder) if is_own else alone:
        data = _read(folder / name, _MOST_BYTES - size)
        if data is None:
            left_out.append(name)
            continue
        files[name] = data
        size += len(data)
        if len(files) + len(left_out) > _MOST_FILES:
            raise ControllerError(f"its folder holds more than {_MOST_FILES} files")
    if path.name not in files:
        raise ControllerError("it is a link or not a regular file, or cannot be read")
    for each in given:
        files[each.name] = each.read_bytes()
    return HandedIn(path.name, files, tuple(left_out))


def leads_through_link(path: Path, base: Path) -> bool:
    """Whether a path, or a folder on the way to it from `base`, is a symbolic link."""
    path = path.absolute()
    return any(each.is_symlink() for each in (path, *path.parents) if is_within(each, base) and each != base)


def is_within(path: Path, folder: Path) -> bool:
    """Whether a path is a folder, or is in it."""
    return path == folder or folder in path.parents


def _names(folder: Path) -> Iterator[str]:
    """The paths of all files in a folder and its subfolders, but not behind links."""
    waiting = [""]
    while waiting:
        inner = waiting.pop()
        with os.scandir(folder / inner) as entries:
            for entry in sorted(entries, key=lambda each: each.name):
                if entry.name.startswith(".") or entry.name in _OMITTED:
                    continue
                name = f"{inner}{entry.name}"
                if entry.is_dir(follow_symlinks=False):
                    waiting.append(f"{name}/")
                else:
                    yield name


def _read(path: Path, most: int) -> bytes | None:
    """The content of a regular file; None for a link, another kind of file, or one that cannot be read."""
    try:
        # A pipe would wait for its writer.
        opened = os.open(path, os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK)
    except OSError:
        return None
    with os.fdopen(opened, "rb") as file:
        about = os.fstat(opened)
        if not stat.S_ISREG(about.st_mode) or about.st_nlink > 1:
            return None
        if about.st_size > most:
            raise ControllerError(f"its folder holds more than {_MOST_BYTES / 1e6:g} MB")
        return file.read(most)
