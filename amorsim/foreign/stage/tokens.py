"""The words of a Stage world, with those of the files that it includes in their places."""

from __future__ import annotations

import os
import re
from pathlib import Path
from typing import NamedTuple

from amorsim.core.errors import Fault, ScenarioError
from amorsim.core.files.reading import is_file, read_bytes, reason
from amorsim.foreign.text import decoded, is_binary

__all__ = ["Place", "Token", "Tokens", "fault_at", "looks_like_stage", "read_tokens"]

MOST_BYTES = 10_000_000
"""Most that a world and all its includes may hold together [bytes]."""
MOST_INCLUDES = 1000

_TOKEN = re.compile(
    r"""(?P<space>[ \t\f\v\r\x1a]+|\#[^\n]*)
    | (?P<line>\n)
    | "(?P<text>[^"\n]*)"
    | (?P<mark>[()\[\]])
    | (?P<word>[^\s"\#()\[\]]+(?:\[[0-9]+\])?)
    | (?P<wrong>.)""",
    re.VERBOSE,
)
_BLANK = re.compile(r"(?:\s|#[^\n]*(?:\n|\Z))*")
_SURE = re.compile(
    r'include\s+"|define\s+\w+\s+\w+\s*\(|(?:window|floorplan|position|model)\s*\(|'
    r"(?:resolution|interval_sim|interval_real|quit_time|speedup|paused|threads)\s+-?[0-9.]"
)
_BEGINNING = re.compile(r"[A-Za-z_][A-Za-z0-9_:.-]*\s*[(\[\"A-Za-z0-9.+-]")


class Place(NamedTuple):
    """A line of a file, counted from 1."""

    file: Path
    line: int


class Token(NamedTuple):
    """A word, a text in quotes, or a bracket, which is its own `kind`."""

    kind: str  # "word", "text", "(", ")", "[" or "]"
    text: str
    place: Place


class Tokens(NamedTuple):
    """The tokens of a world and the files that they come from: the world's, then each included one, once."""

    tokens: list[Token]
    files: tuple[Path, ...]


def fault_at(place: Place, message: str) -> ScenarioError:
    """The error of one line."""
    return ScenarioError([Fault(file=str(place.file), path="", line=place.line, message=message)])


def looks_like_stage(head: bytes, *, is_sure: bool = False) -> bool:
    """Whether a file with this beginning may be a world of Stage: comments, then a word and its block or value.

    Where `is_sure`, that must be a statement with which worlds of Stage begin, and hardly any other text.
    """
    if is_binary(head):
        return False
    text = head.decode("utf-8-sig", errors="replace")
    blank = _BLANK.match(text)
    begin = blank.end() if blank else 0
    if is_sure:
        return bool(_SURE.match(text, begin))
    return begin > 0 if begin == len(text) else bool(_BEGINNING.match(text, begin))


def read_tokens(path: Path) -> Tokens:
    """The tokens of a world, those of included files in the place of ``include``.

    Raises
    ------
    ScenarioError
        If one of the files cannot be read or is not text, a text is not closed, files include one another in a circle,
        or all of them together are too long.
    """
    reader = _Reader(path)
    reader.read(path, None, ())
    return Tokens(reader.tokens, tuple(reader.files))


class _Reader:
    """Reads a world and its includes, each in its place."""

    def __init__(self, world: Path) -> None:
        self._world = world
        self._bytes = 0
        self._included = 0
        self.tokens: list[Token] = []
        self.files: dict[Path, None] = {}

    def read(self, path: Path, asked: Place | None, outer: tuple[Path, ...]) -> None:
        """Add the tokens of a file, which `outer` files include by a line."""
        text = self._text(path, asked)
        self.files.setdefault(path)
        number = 1
        awaits: Place | None = None  # an include that waits for its file's name
        for match in _TOKEN.finditer(text):
            kind = match.lastgroup
            if kind == "space":
                continue
            if kind == "line":
                number += 1
                continue
            place = Place(path, number)
            if kind == "wrong":
                raise fault_at(place, f"expected a closing quote on the same line, got {match[0]!r} alone")
            assert kind is not None
            word = match[kind]
            if awaits is not None:
                if kind != "text":
                    raise fault_at(awaits, f"expected include with a file's name in quotes, got {word!r}")
                self._include(word, awaits, (*outer, path))
                awaits = None
            elif kind == "word" and word == "include":
                awaits = place
            else:
                self.tokens.append(Token(word if kind == "mark" else kind, word, place))
        if awaits is not None:
            raise fault_at(awaits, "expected include with a file's name in quotes, got nothing")

    def _include(self, name: str, place: Place, outer: tuple[Path, ...]) -> None:
        self._included += 1
        if self._included > MOST_INCLUDES:
            raise fault_at(place, f"the files include one another more than {MOST_INCLUDES} times; expected fewer")
        # Next to the file that includes it, or next to the world, which is where Stage looks.
        places = [Path(os.path.abspath(neighbour.parent / name)) for neighbour in (place.file, self._world)]  # noqa: PTH100
        path = next((path for path in places if is_file(path)), places[0])
        if path in outer:
            raise fault_at(place, f"{name} includes itself, by way of {' and '.join(each.name for each in outer)}")
        self.read(path, place, outer)

    def _text(self, path: Path, asked: Place | None) -> str:
        try:
            data = read_bytes(path, MOST_BYTES - self._bytes)
        except (OSError, ValueError) as error:
            message = f"cannot be read: {reason(error)}"
            if asked is None:
                raise ScenarioError([Fault(file=str(path), path="", message=message)]) from None
            raise fault_at(asked, f"the included file {path} {message}") from None
        self._bytes += len(data)
        return decoded(data, path, "a world of Stage")
