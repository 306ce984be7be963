"""Reads files that a user names, of any kind, safely."""

from __future__ import annotations

import itertools
import os
import stat
from pathlib import Path

from amorsim.core.errors import did_you_mean

__all__ = [
    "MOST_BYTES",
    "check_readable",
    "is_file",
    "is_folder",
    "is_there",
    "no_such_file",
    "read_bytes",
    "read_text",
    "reason",
]

MOST_BYTES = 100_000_000
"""A text longer than this [bytes] is not a map, track, scenario or program."""

_MOST_NAMES = 1000  # of a folder, that are compared with the name of a file that is not there
_KINDS = (
    (stat.S_ISCHR, "a device"),
    (stat.S_ISBLK, "a device"),
    (stat.S_ISFIFO, "a pipe"),
    (stat.S_ISSOCK, "a socket"),
)


def check_readable(path: str | os.PathLike[str], most: int = MOST_BYTES) -> None:
    """Raise `OSError` unless a file exists and can be read to its end: regular, and of at most `most` bytes.

    A pipe would wait for a writer, and a device such as ``/dev/zero`` has no end. Folders are left to `open`, which
    reports them.
    """
    about = Path(path).stat()
    for is_kind, what in _KINDS:
        if is_kind(about.st_mode):
            raise OSError(f"it is {what}; expected a regular file")
    if about.st_size > most:
        raise OSError(f"it has {about.st_size / 1e6:.6g} MB; expected {most / 1e6:.6g} MB at most")


def is_file(path: str | os.PathLike[str]) -> bool:
    """Whether there is a regular file; false for a name that the system does not accept."""
    try:
        return Path(path).is_file()
    except OSError:  # a name that is too long
        return False


def is_folder(path: str | os.PathLike[str]) -> bool:
    """Whether there is a folder; false for a name that the system does not accept."""
    try:
        return Path(path).is_dir()
    except OSError:  # a name that is too long
        return False


def is_there(path: str | os.PathLike[str]) -> bool:
    """Whether there is something of this name; false for a name that the system does not accept."""
    try:
        return Path(path).exists()
    except OSError:  # a name that is too long
        return False


def read_bytes(path: str | os.PathLike[str], most: int = MOST_BYTES) -> bytes:
    """The content of a file.

    Raises
    ------
    OSError
        If there is no such file, it cannot be read, is not a regular file, or has more than `most` bytes.
    ValueError
        If no system could have such a path, for example one with a zero byte.
    """
    check_readable(path, most)
    return Path(path).read_bytes()


def read_text(path: str | os.PathLike[str], encoding: str = "utf-8", most: int = MOST_BYTES) -> str:
    """The text in a file, its line ends as Python reads them; raises as `read_bytes`."""
    check_readable(path, most)
    return Path(path).read_text(encoding=encoding)


def no_such_file(path: str | os.PathLike[str]) -> str:
    """The problem with a file that does not exist, with the name in its folder that is most like it."""
    wanted = Path(path)
    try:
        there = [
            each for each in itertools.islice(wanted.parent.iterdir(), _MOST_NAMES) if each.suffix == wanted.suffix
        ]
    except (OSError, ValueError):
        there = []
    # An ending alone does not make names alike.
    near = did_you_mean(wanted.name, sorted(each.name for each in there if did_you_mean(wanted.stem, [each.stem])))
    return f"there is no such file.{near}" if near else "there is no such file; check its name and its folder"


def reason(error: Exception) -> str:
    """Why a file could not be read, without its name."""
    return (isinstance(error, OSError) and error.strerror) or str(error)
