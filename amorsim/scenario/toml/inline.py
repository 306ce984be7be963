"""Changes within a value's text: an array or inline table gets or loses a member, and the rest stays."""

from __future__ import annotations

from collections.abc import Sequence

from amorsim.scenario.toml.literals import keys_as_toml
from amorsim.scenario.toml.statements import Member, members

__all__ = ["count", "find", "insert", "move", "remove"]

Path_ = tuple[str | int, ...]


def find(text: str, at: int, path: Path_) -> tuple[int, Member | None, Path_]:
    """The deepest value on the way to `path` in the value that begins at `at`.

    Returns
    -------
    at
        Where that value begins.
    member
        What it is a member of its array or table as; None where it is the value itself.
    rest
        What is left of the path: nothing where it was found.
    """
    found = None
    while path and text[at] in "[{":
        for index, member in enumerate(members(text, at)):
            keys = member.keys or (index,)
            if path[: len(keys)] == keys:
                found, at, path = member, member.first, path[len(keys) :]
                break
        else:
            break
    return at, found, path


def insert(text: str, at: int, keys: tuple[str, ...], value: str, place: int | None, newline: str) -> str:
    """The text with another member in the array or inline table at `at`: before number `place`, or at the end."""
    new = f"{keys_as_toml(keys)} = {value}" if keys else value
    there = list(members(text, at))
    if not there:
        close = _close(text, at)
        if text[at + 1 : close].strip():  # comments
            return f"{text[: at + 1]}{new}{text[at + 1 :]}"
        space = " " if keys else ""
        return f"{text[: at + 1]}{space}{new}{space}{text[close:]}"
    if place is not None and place < len(there):
        before = there[place].start
        indent = _indent(text, before)
        gap = " " if indent is None else f"{newline}{indent}"
        return f"{text[:before]}{new},{gap}{text[before:]}"
    last = there[-1]
    indent = _indent(text, last.start)
    comma = _comma(text, last.last)
    line_end = text.find("\n", last.last if comma is None else comma)
    if indent is None or line_end < 0 or line_end > _close(text, at):
        return f"{text[: last.last]}, {new}{text[last.last :]}"
    if text[line_end - 1] == "\r":
        line_end -= 1
    if comma is None:
        text, line_end = f"{text[: last.last]},{text[last.last :]}", line_end + 1
        return f"{text[:line_end]}{newline}{indent}{new}{text[line_end:]}"
    return f"{text[:line_end]}{newline}{indent}{new},{text[line_end:]}"


def remove(text: str, at: int, member: Member) -> str:
    """The text without a member of the array or inline table at `at`, and without its comma."""
    there = list(members(text, at))
    place = there.index(member)
    comma = _comma(text, member.last)
    end = member.last if comma is None else comma + 1
    begin = text.rfind("\n", 0, member.start) + 1
    line_end = text.find("\n", end)
    has_lines = _indent(text, member.start) is not None and 0 <= line_end < _close(text, at)
    if has_lines and (place + 1 == len(there) or there[place + 1].start > line_end):
        return text[:begin] + text[line_end + 1 :]
    if place + 1 < len(there):
        return text[: member.start] + text[there[place + 1].start :]
    if place:
        return text[: there[place - 1].last] + text[member.last :]
    close = _close(text, at)
    inside = text[at + 1 : member.start] + text[end:close]
    return text[: at + 1] + (inside if inside.strip() else "") + text[close:]


def move(text: str, at: int, number: int, place: int, newline: str) -> str:
    """The text with a member of the array or table at `at` elsewhere in it, number `place` afterwards.

    Where every member has lines of its own, those go with it, and the comments above it and behind it.
    """
    there = list(members(text, at))
    member = there[number]
    if _have_lines(text, at, there):
        if _comma(text, there[-1].last) is None:
            text = f"{text[: there[-1].last]},{text[there[-1].last :]}"
        ends = [text.index("\n", member.last) + 1 for member in there]
        begins = [text.index("\n", at) + 1, *ends[:-1]]
        lines = [text[begin:end] for begin, end in zip(begins, ends, strict=True)]
        lines.insert(place, lines.pop(number))
        return text[: begins[0]] + "".join(lines) + text[ends[-1] :]
    value = text[member.first : member.last]
    return insert(remove(text, at, member), at, member.keys, value, place, newline)


def count(text: str, at: int) -> int:
    """How many members the array or inline table at `at` has."""
    return sum(1 for _ in members(text, at))


def _have_lines(text: str, at: int, there: Sequence[Member]) -> bool:
    """Whether each member begins a line that neither bracket shares with it."""
    close = _close(text, at)
    for member in there:
        line_end = text.find("\n", member.last, close)
        comma = _comma(text, member.last)
        if _indent(text, member.start) is None or line_end < 0 or (comma is not None and comma > line_end):
            return False
    return True


def _indent(text: str, at: int) -> str | None:
    """The blanks before a member that is the first in its line; None for one that is not."""
    before = text[text.rfind("\n", 0, at) + 1 : at]
    return before if not before.strip() and "\n" in text[:at] else None


def _comma(text: str, at: int) -> int | None:
    """Where the comma is that follows a member's end, if there is one before anything else but comments."""
    while text[at] not in ",]}":
        at = text.index("\n", at) if text[at] == "#" else at + 1
    return at if text[at] == "," else None


def _close(text: str, at: int) -> int:
    """Where the bracket is that closes the one at `at`."""
    end = at + 1
    there: Sequence[Member] = list(members(text, at))
    if there:
        end = there[-1].last
    while text[end] not in "]}":
        end = text.index("\n", end) if text[end] == "#" else end + 1
    return end
