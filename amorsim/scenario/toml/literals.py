"""Values as TOML writes them on one line; and whether two values are the same to TOML."""

from __future__ import annotations

import datetime
import json
import math
import operator
import re
import tomllib
from collections.abc import Mapping
from typing import Any

from amorsim.core.error_text import in_words
from amorsim.core.errors import DocumentError
from amorsim.scenario.toml.angles import LongDegrees, parse_float

__all__ = ["are_same", "as_toml", "checked_text", "keys_as_toml", "parse", "parse_value", "plain"]

_BARE_KEY = re.compile(r"[A-Za-z0-9_-]+")
_TIMES = (datetime.datetime, datetime.date, datetime.time)
_DELETE = "\N{DELETE}"  # the one control character that JSON leaves as it is, and TOML refuses


def parse(text: str) -> dict[str, Any]:
    """The table in a TOML text; raises what `tomllib` raises."""
    return tomllib.loads(text, parse_float=parse_float)


def parse_value(text: str) -> Any:
    """The value in a TOML text; raises what `tomllib` raises, and `ValueError` if there is more than a value."""
    table = parse(f"value = {text}")
    if list(table) != ["value"]:
        raise ValueError("more than a value")
    return table["value"]


def plain(value: Any, path: str = "") -> Any:
    """A value of Python as TOML has it: tuples and arrays as lists, NumPy's numbers as Python's.

    Raises
    ------
    DocumentError
        If TOML has no such value; with the path that it was for.
    """
    if isinstance(value, str):
        return checked_text(value, path)
    if isinstance(value, (bool, *_TIMES)):
        return value
    if isinstance(value, Mapping):
        for key in value:
            if not isinstance(key, str):
                raise DocumentError(f"expected texts as the keys of a table, got {in_words(key)}", path)
        return {checked_text(key, path): plain(item, path) for key, item in value.items()}
    if isinstance(value, float):
        return value if isinstance(value, LongDegrees) else float(value)
    if isinstance(value, (list, tuple)):
        return [plain(item, path) for item in value]
    if hasattr(value, "tolist"):  # of NumPy
        return plain(value.tolist(), path)
    try:
        return operator.index(value)
    except TypeError:
        raise DocumentError(
            f"expected a number, a text, true, false, a list or a table of these, got {in_words(value)}", path
        ) from None


def checked_text(text: str, path: str = "") -> str:
    """The text itself.

    Raises
    ------
    DocumentError
        If no file can hold it, for it has half of a pair of surrogates.
    """
    if any("\ud800" <= letter <= "\udfff" for letter in text):
        raise DocumentError(f"expected a text that UTF-8 can hold, got {in_words(text)}", path)
    return text


def as_toml(value: Any) -> str:
    """The text of a plain value, on one line; numbers as the shortest decimals that read as the same bits."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, LongDegrees):
        return value.text
    if isinstance(value, (int, float)):
        return repr(value)
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False).replace(_DELETE, "\\u007f")
    if isinstance(value, dict):
        pairs = ", ".join(f"{keys_as_toml((key,))} = {as_toml(item)}" for key, item in value.items())
        return f"{{ {pairs} }}" if pairs else "{}"
    if isinstance(value, list):
        return f"[{', '.join(map(as_toml, value))}]"
    text: str = value.isoformat()
    return text


def keys_as_toml(keys: tuple[str, ...]) -> str:
    """Keys with dots between them, quoted where they must be."""
    return ".".join(key if _BARE_KEY.fullmatch(key) else as_toml(key) for key in keys)


def are_same(one: Any, other: Any) -> bool:
    """Whether two TOML values are the same; 1, 1.0 and true differ, and nan is the same as nan."""
    if isinstance(one, dict):
        return (
            isinstance(other, dict)
            and one.keys() == other.keys()
            and all(are_same(item, other[key]) for key, item in one.items())
        )
    if isinstance(one, list):
        return isinstance(other, list) and len(one) == len(other) and all(map(are_same, one, other))
    if isinstance(one, float):
        if not isinstance(other, float):
            return False
        if isinstance(one, LongDegrees) or isinstance(other, LongDegrees):
            return getattr(one, "text", None) == getattr(other, "text", None)
        return (one == other and math.copysign(1.0, one) == math.copysign(1.0, other)) or (
            one != one and other != other
        )
    return type(one) is type(other) and bool(one == other)
