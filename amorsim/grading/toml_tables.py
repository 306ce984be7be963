"""A file of tables, read with all of its faults."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path
from typing import TypeVar

from amorsim.core.errors import ScenarioError, StudyError
from amorsim.scenario.files.models import check_format, read_file
from amorsim.scenario.reading.contents import book_of
from amorsim.scenario.reading.faults import Node

__all__ = ["read_tables"]

T = TypeVar("T")


def read_tables(path: str | os.PathLike[str], keys: tuple[str, ...], read: Callable[[Node, Path], T]) -> T:
    """The result of `read` for a TOML file with these keys, given its top and its path.

    Raises
    ------
    StudyError
        With all that is wrong with the file.
    """
    path = Path(path)
    written = read_file(path)
    if isinstance(written, str):
        raise StudyError(f"{path}: {written}")
    book = book_of(written, path)
    top = Node(written.values, (), book)
    check_format(top.child("format"))
    top.refuse_unknown(keys)
    found = read(top, path)
    try:
        book.raise_if_any()
    except ScenarioError as error:
        raise StudyError(str(error)) from None
    return found
