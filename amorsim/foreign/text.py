"""Text files of other programs: read whole, in any encoding, with the lines of faults."""

from __future__ import annotations

import re
from pathlib import Path

from amorsim.core.errors import Fault, ScenarioError
from amorsim.core.files.reading import read_bytes, reason

__all__ = ["NUMBER", "Faults", "decoded", "is_binary", "read_text"]

_BINARY = re.compile(rb"[\x00-\x08\x0e-\x19\x1b-\x1f]")
NUMBER = re.compile(r"[+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?")
"""A number as all these formats spell it."""


def is_binary(data: bytes) -> bool:
    """Whether bytes are not text."""
    return bool(_BINARY.search(data))


def decoded(data: bytes, path: Path, kind: str) -> str:
    """The text of a file that should be a `kind`: UTF-8, or else Latin 1, in which every byte is a letter.

    Raises
    ------
    ScenarioError
        If it is not text.
    """
    if binary := _BINARY.search(data):
        problem = f"byte {binary.start()} is {binary.group()[0]:#04x}: this is not a text file, and {kind} is one"
        raise ScenarioError([Fault(file=str(path), path="", message=problem)])
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError:
        return data.decode("latin-1")


def read_text(path: Path, most: int, kind: str) -> str:
    """The text in a file of at most so many bytes; raises `ScenarioError` if it cannot be read or is not text."""
    try:
        data = read_bytes(path, most)
    except (OSError, ValueError) as error:
        raise ScenarioError([Fault(file=str(path), path="", message=f"cannot be read: {reason(error)}")]) from None
    return decoded(data, path, kind)


class Faults:
    """The faults of one file, each with its line; only the first of very many."""

    _MOST = 50

    def __init__(self, path: Path) -> None:
        self._path = path
        self._faults: list[Fault] = []

    def add(self, line: int, message: str) -> None:
        """Note a fault in a line."""
        if len(self._faults) < self._MOST:
            self._faults.append(Fault(file=str(self._path), path="", line=line, message=message))

    def raise_if_any(self) -> None:
        """Raise a `ScenarioError` if there are faults."""
        if self._faults:
            raise ScenarioError(self._faults)
