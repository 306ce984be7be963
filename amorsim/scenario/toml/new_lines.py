"""The lines of values that a file does not have yet, and where they may go."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

from amorsim.scenario.toml.layout import Layout, Path_
from amorsim.scenario.toml.literals import as_toml, keys_as_toml
from amorsim.scenario.toml.statements import Statement

__all__ = ["NewLines"]

_LONGEST = 100  # characters of a table on one line


class NewLines:
    """Writes lines for new values of a file.

    Parameters
    ----------
    statements, layout
        Of the file, as it is now.
    newline
        How its lines end.
    """

    def __init__(self, statements: Sequence[Statement], layout: Layout, newline: str) -> None:
        self._statements = statements
        self._layout = layout
        self._newline = newline

    def places(
        self, path: Path_, depth: int, keys: tuple[str, ...], value: Any, place: int | None
    ) -> Iterator[tuple[int, int, list[str]]]:
        """Where the statements of a new value may go, the likeliest place first: what they replace, and their lines."""
        parent, layout = path[:depth], self._layout
        header = layout.headers.get(parent)
        end = (layout.under(parent) or [-1])[-1] + 1
        is_large = isinstance(value, dict) and _is_large(value)
        if not parent and len(keys) > 1:
            yield self._before_lists(), 0, self._under_header(path, depth, keys, value)
        if not parent and is_large:
            yield self._before_lists(), 0, self.chunk(path, value)
        if is_large:
            yield end, 0, self.chunk(path, value)
        if header is not None:
            yield self._in_body(header, keys, value)
        below = [i for i in layout.under(parent) if layout.paths[i] in layout.pairs and parent]
        if below:  # of dotted keys
            after = below[-1]
            head = layout.head_of(after)
            yield after + 1, 0, [self._line(self._indent(after), _names(path[len(head) :]), value)]
        if isinstance(value, dict):
            yield end, 0, self.chunk(path, value)
        if len(path) > 1:
            yield end, 0, self._under_header(path, depth, keys, value)
        for length in range(depth - 1, -1, -1):
            if path[:length] in layout.headers:
                yield self._in_body(layout.headers[path[:length]], _names(path[length:]), value)
                break
        if place is not None and len(path) > 1:
            yield place, 0, self._under_header(path, depth, keys, value)

    def _in_body(self, header: int, keys: tuple[str, ...], value: Any) -> tuple[int, int, list[str]]:
        """A pair at the end of the body of a header, under those that are there."""
        layout = self._layout
        end = layout.body_end(header)
        pairs = [i for i in range(header + 1, end) if self._statements[i].kind == "pair"]
        if pairs:
            return pairs[-1] + 1, 0, [self._line(self._indent(pairs[-1]), keys, value)]
        if header >= 0:
            return header + 1, 0, [self._line(self._indent(header), keys, value)]
        start = self.with_comments(end) if end < len(self._statements) else end
        return start, 0, [self._line("", keys, value), *([self._newline] if end < len(self._statements) else [])]

    def _indent(self, index: int) -> str:
        text = self._statements[index].text
        return text[: len(text) - len(text.lstrip(" \t"))]

    def _line(self, indent: str, keys: tuple[str, ...], value: Any) -> str:
        return f"{indent}{keys_as_toml(keys)} = {as_toml(value)}{self._newline}"

    def _under_header(self, path: Path_, depth: int, keys: tuple[str, ...], value: Any) -> list[str]:
        """A header for the first table that is missing, or else for the one that is there, and a pair under it."""
        header = path[: depth + 1] if len(keys) > 1 else path[:depth]
        line = self._line("", keys[1:] or keys, value)
        return [self._newline, f"[{keys_as_toml(_names(header))}]{self._newline}", line]

    def chunk(self, path: Path_, table: dict[str, Any], *, is_item: bool = False) -> list[str]:
        """A header with its pairs, the large tables in it under headers of their own, and a blank line before it."""
        keys = keys_as_toml(_names(path))
        lines = [self._newline, f"[[{keys}]]{self._newline}" if is_item else f"[{keys}]{self._newline}"]
        large = {key: item for key, item in table.items() if isinstance(item, dict) and _is_large(item)}
        lines += [self._line("", (key,), item) for key, item in table.items() if key not in large]
        if large and not is_item and len(large) == len(table):
            lines = []  # the headers below make this table too
        for key, item in large.items():
            lines += self.chunk((*path, key), item)
        return lines

    def _before_lists(self) -> int:
        """Where a table of the top may begin: before the first [[list]], or at the end."""
        first = next((i for i, each in enumerate(self._statements) if each.kind == "array"), len(self._statements))
        return self.with_comments(first) if first < len(self._statements) else first

    def with_comments(self, index: int) -> int:
        """The line at which the comments right above a statement begin; those that begin the file do not count."""
        start = index
        while start and self._statements[start - 1].text.lstrip(" \t").startswith("#"):
            start -= 1
        return start if start else index


def _names(path: Path_) -> tuple[str, ...]:
    return tuple(key for key in path if isinstance(key, str))


def _is_large(table: dict[str, Any]) -> bool:
    """Whether a table is written under a header of its own."""
    holds_tables = any(
        isinstance(item, dict) and any(isinstance(inner, dict) for inner in item.values()) for item in table.values()
    )
    return bool(table) and (holds_tables or len(as_toml(table)) > _LONGEST)
