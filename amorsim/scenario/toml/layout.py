"""Where each path is in a TOML file's statements."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from amorsim.scenario.toml.statements import Statement

__all__ = ["MISSING", "Layout", "Path_", "changed", "copied_tables", "found_at", "inserted", "without"]

Path_ = tuple[str | int, ...]
"""Keys of tables, and numbers of the items of lists."""

MISSING: Any = object()
"""What is at a path where nothing is."""


def copied_tables(value: Any) -> Any:
    """A copy of tables and lists, however deep, in a fraction of the time that `copy.deepcopy` takes."""
    if isinstance(value, dict):
        return {key: copied_tables(item) for key, item in value.items()}
    return [copied_tables(item) for item in value] if isinstance(value, list) else value


class Layout:
    """The path of each statement: that of a pair's value, of a header's table, none of anything else."""

    def __init__(self, statements: Sequence[Statement]) -> None:
        self.paths: list[Path_ | None] = []
        self.pairs: dict[Path_, int] = {}
        """The statement that gives a path a value in a pair."""
        self.headers: dict[Path_, int] = {(): -1}
        """The statement that is the header of a table; the file's own table has none."""
        counts: dict[Path_, int] = {}
        head: Path_ = ()
        for index, statement in enumerate(statements):
            if statement.kind == "pair":
                path = head + statement.keys
                self.paths.append(path)
                self.pairs[path] = index
            elif statement.kind in ("table", "array"):
                head = self._head(statement, counts)
                self.paths.append(head)
                self.headers[head] = index
            else:
                self.paths.append(None)

    @staticmethod
    def _head(statement: Statement, counts: dict[Path_, int]) -> Path_:
        """The path of a header's table: of a list the last item so far, or the one that it begins."""
        path: Path_ = ()
        *before, last = statement.keys
        for key in before:
            path += (key,)
            if path in counts:
                path += (counts[path] - 1,)
        path += (last,)
        if statement.kind == "array":
            counts[path] = counts.get(path, 0) + 1
        return (*path, counts[path] - 1) if path in counts else path

    def pair_over(self, path: Path_) -> tuple[int, Path_] | None:
        """The statement of the pair whose value is at a path or holds it, and the rest of the path within it."""
        for length in range(len(path), 0, -1):
            if path[:length] in self.pairs:
                return self.pairs[path[:length]], path[length:]
        return None

    def under(self, path: Path_) -> list[int]:
        """The statements for a path or below it, headers and pairs."""
        length = len(path)
        return [i for i, each in enumerate(self.paths) if each is not None and each[:length] == path]

    def head_of(self, index: int) -> Path_:
        """The path of the table in whose body a statement is."""
        while index >= 0:
            path = self.paths[index]
            if path is not None and self.headers.get(path) == index:
                return path
            index -= 1
        return ()

    def body_end(self, header: int) -> int:
        """Where the next header is after a header, or the end."""
        index = header + 1
        while index < len(self.paths):
            path = self.paths[index]
            if path is not None and self.headers.get(path) == index:
                break
            index += 1
        return index


def found_at(values: Any, path: Path_) -> Any:
    """The value at a path, or `MISSING`."""
    for part in path:
        if isinstance(values, dict):
            values = values.get(part, MISSING)
        elif isinstance(values, list) and isinstance(part, int) and 0 <= part < len(values):
            values = values[part]
        else:
            return MISSING
    return values


def changed(values: Any, path: Path_, value: Any) -> Any:
    """`values` with a value at a path; tables on the way are copied, or made if missing."""
    if not path:
        return value
    part, rest = path[0], path[1:]
    if isinstance(values, list):
        return [changed(item, rest, value) if i == part else item for i, item in enumerate(values)]
    inner = values.get(part, {})
    return {**values, part: changed(inner, rest, value)}


def inserted(values: Any, path: Path_, place: int, value: Any) -> Any:
    """`values` with an item more in the list at a path, before number `place`."""
    there = found_at(values, path)
    return changed(values, path, [*there[:place], value, *there[place:]])


def without(values: Any, path: Path_) -> Any:
    """`values` without what is at a path."""
    holder, last = found_at(values, path[:-1]), path[-1]
    if isinstance(holder, list):
        return changed(values, path[:-1], [item for i, item in enumerate(holder) if i != last])
    return changed(values, path[:-1], {key: item for key, item in holder.items() if key != last})
