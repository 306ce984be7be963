"""JSON files that other programs may have written: read with limits, and checked key by key."""

from __future__ import annotations

import json
import math
import os
from collections.abc import Callable, Mapping
from typing import Any

from amorsim.core.error_text import in_words
from amorsim.core.errors import AmorsimError
from amorsim.core.files.reading import MOST_BYTES, read_bytes, reason
from amorsim.core.numbers import is_number

__all__ = [
    "Check",
    "Key",
    "check_keys",
    "is_figure",
    "is_real",
    "is_text",
    "is_whole",
    "list_of",
    "parse_json",
    "read_table",
    "table_of",
]

Check = Callable[[Any], bool]
Key = tuple[Check, str]
"""The type of a key's value, and the same in words."""

LARGEST = 1e300  # larger numbers are mistakes
_WHOLE = 2**64  # whole numbers are below it in size


def parse_json(text: str | bytes, table: Callable[[dict[str, Any]], Any] | None = None) -> Any:
    """The content of a text of JSON; nan and the infinities are read, as Python writes them.

    `table` makes something else of each table.

    Whole numbers of more than 64 bits are read as floats, so that no arithmetic with a file's numbers overflows.

    Raises
    ------
    ValueError
        If it is none, or is nested too deeply.
    """
    try:
        return json.loads(text, parse_int=_whole, object_hook=table)
    except RecursionError:
        raise ValueError("its tables and lists are nested too deeply") from None


def _whole(text: str) -> int | float:
    return int(text) if len(text) < 20 or (len(text) < 22 and abs(int(text)) < _WHOLE) else float(text)


def read_table(path: str | os.PathLike[str], error: type[AmorsimError], largest: int = MOST_BYTES) -> dict[str, Any]:
    """The table that a file of JSON holds.

    Raises
    ------
    FileNotFoundError
        If there is no file.
    AmorsimError
        Of the class `error`, if it cannot be read, has more than `largest` bytes, or holds anything else.
    """
    try:
        found = parse_json(read_bytes(path, largest))
    except FileNotFoundError:
        raise
    except (OSError, json.JSONDecodeError, UnicodeDecodeError) as problem:
        raise error(f"{path}: cannot be read ({reason(problem)})") from None
    except ValueError as problem:
        raise error(f"{path}: is damaged: {problem}") from None
    if not isinstance(found, dict):
        raise error(f"{path}: is damaged: expected a table, got {in_words(found)}")
    return found


def check_keys(
    where: object,
    table: Mapping[str, Any],
    needed: Mapping[str, Key],
    others: Mapping[str, Key],
    error: type[AmorsimError],
) -> None:
    """Raise an error of the class `error` for a key that is missing or has a value of another kind.

    Parameters
    ----------
    where
        The file, and the place in it if it is not the whole.
    needed, others
        By key: keys that must be there, and keys that may.
    """
    for key, (check, what) in {**needed, **others}.items():
        if (key in table or key in needed) and not check(table.get(key)):
            raise error(f"{where}: is damaged: expected {what} under {key!r}, got {in_words(table.get(key))}")


def is_text(value: Any) -> bool:
    """Whether it is a text that can be shown and written."""
    return isinstance(value, str) and not any("\ud800" <= letter <= "\udfff" for letter in value)


def is_whole(value: Any, most: int = _WHOLE) -> bool:
    """Whether it is a whole number from 0 to `most`."""
    return type(value) is int and 0 <= value <= most


def is_real(value: Any) -> bool:
    """Whether it is a finite number."""
    return is_number(value, below=LARGEST)


def is_figure(value: Any) -> bool:
    """Whether it is a number, also nan or infinite."""
    return is_real(value) or (isinstance(value, float) and not math.isfinite(value))


def list_of(check: Check, length: int | None = None) -> Check:
    """A check for lists whose entries pass `check`, of this length if it is given."""
    return lambda value: isinstance(value, list) and (length is None or len(value) == length) and all(map(check, value))


def table_of(check: Check) -> Check:
    """A check for tables whose keys can be shown and whose values pass `check`."""
    return lambda value: isinstance(value, dict) and all(is_text(key) and check(each) for key, each in value.items())
