"""The messages of a window's WebSocket, whatever page it is of: text from the window, and its limits.

A message is a table as JSON: ``{"drawn": n}``, the number of the frame that it has drawn, or ``{"id": n, "do": NAME,
...}``, a command. A message that is anything else is answered with what is wrong with it.
"""

from __future__ import annotations

import json
import reprlib
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple, NoReturn

from amorsim.core.errors import AmorsimError

__all__ = ["LONGEST_MESSAGE", "Kind", "MessageError", "decode", "number_of", "shown", "whole"]

LONGEST_MESSAGE = 64 * 1024  # [bytes]
LARGEST_WHOLE = 2**53  # up to which a browser counts


class MessageError(AmorsimError):
    """A message that no window of ours sends."""


class Kind(NamedTuple):
    """The condition for a value, in words and as a function."""

    expected: str
    holds: Callable[[Any], bool]


def whole(low: int, high: int = LARGEST_WHOLE) -> Kind:
    """A whole number in a range, both ends included."""

    def holds(value: Any) -> bool:
        return isinstance(value, int) and not isinstance(value, bool) and low <= value <= high

    return Kind(f"a whole number from {low} to {high}", holds)


_NUMBER = whole(0)  # of a frame or a command


def _no_number(word: str) -> NoReturn:
    raise ValueError(word)


def decode(text: str | None) -> dict[str, Any]:
    """The message in a text: a command, or a report of what was drawn; None if it is not text.

    Raises
    ------
    MessageError
        If it is neither; the rest of a command is its session's to check.
    """
    try:
        message = None if text is None else json.loads(text, parse_constant=_no_number)
    except (ValueError, RecursionError):  # too many digits are a ValueError
        message = None
    if not isinstance(message, dict):
        raise MessageError("expected a message as text, a table as JSON")
    if "drawn" in message:
        if not _NUMBER.holds(message["drawn"]):
            raise MessageError(f"drawn: expected {_NUMBER.expected}, got {shown(message['drawn'])}")
    elif not isinstance(message.get("do"), str):
        raise MessageError(f"do: expected the name of a command, got {shown(message.get('do'))}")
    return message


def number_of(message: Mapping[str, Any]) -> int | None:
    """The number that a command wants on its answer; None if it has none."""
    number = message.get("id")
    return number if _NUMBER.holds(number) else None


def shown(value: Any) -> str:
    """A value in an error's text, short however long or deep it is."""
    return reprlib.repr(value)
