"""The text of a TOML file cut into its statements: a header, a pair of key and value, a blank line or a comment each.

Joined again, they are the file to the byte. What a value means is left to `tomllib`; this module finds its place.
"""

from __future__ import annotations

import re
import tomllib
from collections.abc import Iterator
from typing import Any, NamedTuple

__all__ = ["Member", "Statement", "cut", "members", "value_end"]

_KEY = r"""(?:[A-Za-z0-9_-]+|"(?:[^"\\\n]|\\[^\n])*"|'[^'\n]*')"""
_KEYS = rf"{_KEY}(?:[ \t]*\.[ \t]*{_KEY})*"
_STRINGS = (
    r'"""(?:\\.|[^\\])*?"""(?:"{0,2})',  # up to two quotes may stand before the three that end it
    r"'''.*?'''(?:'{0,2})",
    r'"(?!"")(?:[^"\\\n]|\\[^\n])*"',
    r"'(?!'')[^'\n]*'",
)
_HEADER = re.compile(rf"(\[\[?)[ \t]*({_KEYS})[ \t]*(\]\]?)")
_PAIR = re.compile(rf"({_KEYS})[ \t]*=[ \t]*")
_LINE = re.compile(r"[^\n]*(?:\n|\Z)")
_END = re.compile(r"[ \t]*(?:#[^\n]*|\r)?(?:\n|\Z)")
_INDENT = re.compile(r"[ \t]*")
_GAP = re.compile(r"(?:[ \t\r\n]+|#[^\n]*)*")
_STRING = re.compile("|".join(_STRINGS), re.DOTALL)
_BARE = re.compile(r"[^\s#][^\n#]*?(?=[ \t\r]*(?:[\n#]|\Z))")
_BARE_INSIDE = re.compile(r"[^\s,\]}#=][^,\]}#\n]*?(?=[ \t\r]*(?:[,\]}#\n]|\Z))")
# Strings and comments may hold brackets that are none.
_BRACKET = re.compile(rf"({'|'.join(_STRINGS)})|(#[^\n]*)|([\[\]{{}}])|[\"']", re.DOTALL)
_CLOSING = {"[": "]", "{": "}"}


class Statement(NamedTuple):
    """Whole lines of a file that belong together; the last may lack its line end.

    `kind` is ``"blank"`` (comments too), ``"table"`` and ``"array"`` (headers), ``"pair"``, or ``"bad"`` for what is no
    TOML. `first` and `last` bound the value of a pair within `text`.
    """

    text: str
    kind: str
    keys: tuple[str, ...] = ()
    first: int = 0
    last: int = 0

    @property
    def value(self) -> str:
        """The text of a pair's value."""
        return self.text[self.first : self.last]


class Member(NamedTuple):
    """A member of an array or an inline table: its keys (none in an array), where it begins, and where its value is."""

    keys: tuple[str, ...]
    start: int
    first: int
    last: int


def cut(text: str) -> list[Statement]:
    """The statements of a file, in order; what is not TOML is cut line by line."""
    found = []
    at, length = 0, len(text)
    while at < length:
        statement = _statement(text, at)
        found.append(statement)
        at += len(statement.text)
    return found


def _statement(text: str, at: int) -> Statement:
    begin = _INDENT.match(text, at).end()  # type: ignore[union-attr]
    if line := _END.match(text, begin):
        return Statement(text[at : line.end()], "blank")
    if text[begin] == "[":
        header = _HEADER.match(text, begin)
        if header and len(header[1]) == len(header[3]) and (end := _END.match(text, header.end())):
            kind = "table" if len(header[1]) == 1 else "array"
            return Statement(text[at : end.end()], kind, _keys(header[2]))
    elif pair := _PAIR.match(text, begin):
        last = value_end(text, pair.end())
        if last is not None:
            end = _END.match(text, last)
            if end:
                return Statement(text[at : end.end()], "pair", _keys(pair[1]), pair.end() - at, last - at)
            return Statement(text[at : _line_end(text, last)], "bad")
    return Statement(text[at : _line_end(text, begin)], "bad")


def _line_end(text: str, at: int) -> int:
    line = _LINE.match(text, at)
    assert line is not None
    return line.end()


def _keys(text: str) -> tuple[str, ...]:
    """The keys of ``a . "b"``; text that is not TOML stays as it is."""
    if '"' not in text and "'" not in text:
        return tuple(part.strip() for part in text.split("."))
    keys: list[str] = []
    try:
        inner: Any = tomllib.loads(f"{text} = 0")
    except ValueError:
        return (text,)
    while isinstance(inner, dict):
        ((key, inner),) = inner.items()
        keys.append(key)
    return tuple(keys)


def value_end(text: str, at: int, *, is_inside: bool = False) -> int | None:
    """Where the value ends that begins at `at`, in a pair or else inside brackets; None if it does not end."""
    first = text[at : at + 1]
    if first in ("", "\n"):
        return None
    if first in "\"'":
        string = _STRING.match(text, at)
        return string.end() if string else None
    if first in "[{":
        waiting = []
        for part in _BRACKET.finditer(text, at):
            bracket = part[3]
            if bracket is None:
                if part[1] is None and part[2] is None:  # a quote that opens no string
                    return None
            elif bracket in "[{":
                waiting.append(_CLOSING[bracket])
            elif not waiting or waiting.pop() != bracket:
                return None
            elif not waiting:
                return part.end()
        return None
    bare = (_BARE_INSIDE if is_inside else _BARE).match(text, at)
    return bare.end() if bare else None


def members(text: str, at: int) -> Iterator[Member]:
    """The members of the array or inline table that begins at `at`, which must be TOML."""
    is_table = text[at] == "{"
    at += 1
    while True:
        at = _GAP.match(text, at).end()  # type: ignore[union-attr]
        if text[at] in "]}":
            return
        start = at
        keys: tuple[str, ...] = ()
        if is_table:
            pair = _PAIR.match(text, at)
            assert pair is not None
            at, keys = pair.end(), _keys(pair[1])
        last = value_end(text, at, is_inside=True)
        assert last is not None
        yield Member(keys, start, at, last)
        at = _GAP.match(text, last).end()  # type: ignore[union-attr]
        if text[at] == ",":
            at += 1
