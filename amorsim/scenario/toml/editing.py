"""Changes of a TOML file's text, each in the lines that it is about, and each read again before it counts.

A statement that changes is read again alone, for its neighbours mean what they meant; where statements come, go or
move, the whole file is.
"""

from __future__ import annotations

from typing import Any, NamedTuple

from amorsim.core.errors import DocumentError
from amorsim.scenario.toml import inline
from amorsim.scenario.toml.layout import MISSING, Layout, Path_, changed, found_at, inserted, without
from amorsim.scenario.toml.literals import are_same, as_toml, parse, parse_value
from amorsim.scenario.toml.new_lines import NewLines
from amorsim.scenario.toml.order import exchanged, order_of, reordered
from amorsim.scenario.toml.statements import Statement, cut

__all__ = ["Editor", "Splice"]


class Splice(NamedTuple):
    """One change: which statements were replaced by which, and the values before and after."""

    start: int
    old: list[Statement]
    new: list[Statement]
    old_values: dict[str, Any]
    new_values: dict[str, Any]


class Editor:
    """The statements of a file, their values, and the changes that were made to them.

    `values` are never changed but replaced, so that what was read from them stays.
    """

    def __init__(self, statements: list[Statement], values: dict[str, Any]) -> None:
        self.statements = statements
        self.values = values
        self.log: list[Splice] = []
        first = next((each.text for each in statements if each.text.endswith("\n")), "\n")
        self._newline = "\r\n" if first.endswith("\r\n") else "\n"
        self._layout: Layout | None = None

    @property
    def text(self) -> str:
        """The whole file."""
        return "".join([statement.text for statement in self.statements])

    @property
    def layout(self) -> Layout:
        """Where the file has each path."""
        if self._layout is None:
            self._layout = Layout(self.statements)
        return self._layout

    @property
    def _new(self) -> NewLines:
        """Writes values that the file does not have yet."""
        return NewLines(self.statements, self.layout, self._newline)

    def apply(self, splice: Splice, *, back: bool = False) -> None:
        """Make a change again, or take it `back`."""
        old, new = (splice.new, splice.old) if back else (splice.old, splice.new)
        self.statements[splice.start : splice.start + len(old)] = new
        self.values = splice.old_values if back else splice.new_values
        # A pair with the same path leaves all others where they are.
        if [each.keys for each in old] != [each.keys for each in new] or any(each.kind != "pair" for each in new):
            self._layout = None

    # ----------------------------------------------------------------------------------------------------------- set

    def set(self, path: Path_, value: Any) -> None:
        """Set a plain value at a path; of tables and lists only what differs is written."""
        old = found_at(self.values, path)
        if old is not MISSING and are_same(old, value):
            return
        if isinstance(old, dict) and isinstance(value, dict):
            for key in [key for key in old if key not in value]:
                self.remove((*path, key))
            for key, item in value.items():
                self.set((*path, key), item)
            if found_at(self.values, path) is MISSING:  # an empty table in the place of one that dotted keys made
                self._create(path, value)
        elif isinstance(old, list) and isinstance(value, list):
            self._set_list(path, old, value)
        elif old is not MISSING:
            self._replace(path, value)
        else:
            self._create(path, value)

    def _set_list(self, path: Path_, old: list[Any], value: list[Any]) -> None:
        if len(old) == len(value):
            for index, item in enumerate(value):
                self.set((*path, index), item)
            return
        short = min(len(old), len(value))
        same = next((i for i in range(short) if not are_same(old[i], value[i])), short)
        tail = next((i for i in range(short - same) if not are_same(old[-1 - i], value[-1 - i])), short - same)
        for index in reversed(range(same, len(old) - tail)):
            self.remove((*path, index))
        if found_at(self.values, path) is MISSING:  # the last of [[tables]]
            self._create(path, value)
            return
        for index in range(same, len(value) - tail):
            self.insert(path, index, value[index])

    def _replace(self, path: Path_, value: Any) -> None:
        spot = self.layout.pair_over(path)
        if spot is None and isinstance(path[-1], int):  # one of [[tables]] alone can be no other thing
            self._replace(path[:-1], found_at(changed(self.values, path, value), path[:-1]))
            return
        if spot is None:  # a table of statements
            place = self.layout.under(path)[0]
            self.remove(path)
            self._create(path, value, place)
            return
        index, rest = spot
        statement = self.statements[index]
        at, member, left = inline.find(statement.text, statement.first, rest)
        if left:  # a table of dotted keys in an inline one
            self.remove(path)
            self._create(path, value)
            return
        last = statement.last if member is None else member.last
        text = statement.text[:at] + as_toml(value) + statement.text[last:]
        self._replace_pair(index, text, changed(self.values, path, value))

    def _replace_pair(self, index: int, text: str, expected: dict[str, Any]) -> None:
        """Replace a pair's text; read again, it must give the expected value."""
        old = self.statements[index]
        path = self.layout.paths[index]
        assert path is not None
        try:
            (new,) = cut(text)
            if new.kind != "pair" or new.keys != old.keys:
                raise ValueError("not the same pair")
            value = parse_value(new.value)
        except (ValueError, RecursionError) as error:
            raise self._refused(path) from error
        if not are_same(value, found_at(expected, path)):
            raise self._refused(path)
        self._splice(index, 1, [new], changed(self.values, path, value))

    @staticmethod
    def _refused(path: Path_) -> DocumentError:
        return DocumentError(
            "this change cannot be made in the file as it is written; write out the table that it is in, under a "
            "header of its own",
            ".".join(map(str, path)),
        )

    def _create(self, path: Path_, value: Any, place: int | None = None) -> None:
        """Write a value at a path where there is none; `place` limits where its statements may go."""
        depth = len(path) - 1
        while found_at(self.values, path[:depth]) is MISSING:
            depth -= 1
        holder = found_at(self.values, path[:depth])
        keys = tuple(key for key in path[depth:] if isinstance(key, str))
        if not isinstance(holder, dict) or len(keys) != len(path) - depth:
            where, name = (".".join(map(str, each)) for each in (path[:depth], path))
            raise DocumentError(f"there is nothing under {where}: it is {as_toml(holder)[:80]}", name)
        expected = changed(self.values, path, value)
        spot = self.layout.pair_over(path[:depth])
        if spot is not None:
            self._create_inside(path, keys, value, spot, expected)
            return
        for start, count, new in self._new.places(path, depth, keys, value, place):
            if self._try(start, count, new, expected):
                return
        raise self._refused(path)

    def _create_inside(
        self, path: Path_, keys: tuple[str, ...], value: Any, spot: tuple[int, Path_], expected: dict[str, Any]
    ) -> None:
        index, rest = spot
        statement = self.statements[index]
        at, _, left = inline.find(statement.text, statement.first, rest)
        dotted = tuple(key for key in left if isinstance(key, str))
        if not dotted:
            for key in reversed(keys[1:]):
                value = {key: value}
            keys = keys[:1]
        text = inline.insert(statement.text, at, (*dotted, *keys), as_toml(value), None, self._newline)
        self._replace_pair(index, text, expected)

    # -------------------------------------------------------------------------------------------------------- remove

    def remove(self, path: Path_) -> None:
        """Remove what is at a path, with comments behind it or right above its header."""
        expected = without(self.values, path)
        spot = self.layout.pair_over(path)
        if spot is None:
            self._remove_statements(path, expected)
            return
        index, rest = spot
        statement = self.statements[index]
        if not rest:
            if not self._try(index, 1, [], expected, may_prune=True):
                raise self._refused(path)
            return
        _, member, left = inline.find(statement.text, statement.first, rest)
        if left:  # a table of dotted keys in an inline one
            for name in list(found_at(self.values, path)):
                self.remove((*path, name))
            return
        assert member is not None
        keys = len(member.keys) or 1
        holder, _, _ = inline.find(statement.text, statement.first, rest[: len(rest) - keys])
        text = inline.remove(statement.text, holder, member)
        pruned = expected
        for length in range(1, keys):  # a table that dotted keys made goes with the last of them
            if found_at(pruned, path[:-length]) == {}:
                pruned = without(pruned, path[:-length])
        self._replace_pair(index, text, pruned)

    def _remove_statements(self, path: Path_, expected: dict[str, Any]) -> None:
        runs = self._runs(path)
        statements = list(self.statements)
        for start, stop in reversed(runs):
            after = stop
            while after < len(statements) and not statements[after].text.strip():
                after += 1
            # Of the blank lines about what goes, those before it stay, but at the end of the file.
            is_apart = start == 0 or not statements[start - 1].text.strip()
            while after == len(statements) and start and not statements[start - 1].text.strip():
                start -= 1
            statements[start : after if is_apart or after == len(statements) else stop] = []
        first, last = 0, len(self.statements)
        while first < len(statements) and statements[first] is self.statements[first]:
            first += 1
        new = statements[first:]
        while new and self.statements[last - 1] is new[-1]:
            new.pop()
            last -= 1
        lines = [each.text for each in new]
        if not self._try(first, last - first, lines, expected, may_prune=True):
            raise self._refused(path)

    def _runs(self, path: Path_) -> list[tuple[int, int]]:
        """The runs of statements at a path or below it, with the comments above their headers."""
        runs: list[tuple[int, int]] = []
        paths, headers = self.layout.paths, self.layout.headers
        for index in self.layout.under(path):
            at = paths[index]
            is_header = at is not None and headers.get(at) == index
            start = self._new.with_comments(index) if is_header else index
            if runs and all(paths[i] is None for i in range(runs[-1][1], index)) and (is_header or start == index):
                is_bad = any(self.statements[i].kind == "bad" for i in range(runs[-1][1], index))
                if not is_bad:
                    runs[-1] = (runs[-1][0], index + 1)
                    continue
            runs.append((start, index + 1))
        return runs

    # ---------------------------------------------------------------------------------------------- items of lists

    def insert(self, path: Path_, place: int, value: Any) -> None:
        """Insert an item into the list at a path, before number `place`."""
        there = found_at(self.values, path)
        expected = inserted(self.values, path, place, value)
        spot = self.layout.pair_over(path)
        if spot is not None:
            index, rest = spot
            statement = self.statements[index]
            at, _, _ = inline.find(statement.text, statement.first, rest)
            text = inline.insert(statement.text, at, (), as_toml(value), place, self._newline)
            self._replace_pair(index, text, expected)
            return
        if not isinstance(value, dict):
            self._replace(path, found_at(expected, path))
            return
        lines = self._new.chunk(path, value, is_item=True)
        if place < len(there):
            start = self._runs((*path, place))[0][0]
            lines = [*lines[1:], self._newline]
        else:
            start = self.layout.under(path)[-1] + 1
        if not self._try(start, 0, lines, expected):
            raise self._refused((*path, place))

    def begin_list(self, path: Path_, value: Any) -> None:
        """Write a list of one item where there is none; a table gets a [[header]]."""
        if len(path) > 1 or not isinstance(value, dict):
            self.set(path, [value])
            return
        expected = changed(self.values, path, [value])
        if not self._try(len(self.statements), 0, self._new.chunk(path, value, is_item=True), expected):
            raise self._refused(path)

    def move(self, path: Path_, place: int) -> None:
        """Move what is at a path within its list or table; afterwards it has the number `place`."""
        holder = path[:-1]
        keys = order_of(found_at(self.values, holder))
        number = keys.index(path[-1])
        if number == place:
            return
        expected = reordered(self.values, holder, number, place)
        spot = self.layout.pair_over(holder)
        if spot is not None:
            index, left = spot
            statement = self.statements[index]
            at, _, rest = inline.find(statement.text, statement.first, left)
            if rest or inline.count(statement.text, at) != len(keys):  # dotted keys in an inline table
                raise self._refused(path)
            text = inline.move(statement.text, at, number, place, self._newline)
            self._replace_pair(index, text, expected)
        else:
            runs, target = self._runs(path), self._runs((*holder, keys[place]))
            if len(runs) > 1 or len(target) > 1:
                problem = "what the file says of it stands in several places; move them together"
                raise DocumentError(problem, ".".join(map(str, path)))
            lines = [each.text for each in self.statements]
            own, other = ((self._new.with_comments(start), stop) for start, stop in (*runs, *target))
            if not self._try(*exchanged(lines, own, other, self._newline), expected):
                raise self._refused(path)
        if order_of(found_at(self.values, holder)) != order_of(found_at(expected, holder)):
            raise self._refused(path)

    # -------------------------------------------------------------------------------------------------- statements

    def _try(
        self, start: int, count: int, lines: list[str], expected: dict[str, Any], *, may_prune: bool = False
    ) -> bool:
        """Replace statements by lines, if the file's values are then the expected ones; returns whether they are."""
        start, count, lines = self._joined(start, count, lines)
        bad = {each.text for each in self.statements[start : start + count] if each.kind == "bad"}
        new = [Statement(each.text, "bad") if each.text in bad else each for each in cut("".join(lines))]
        if any(each.kind == "bad" and each.text not in bad for each in new):
            return False
        statements = [*self.statements[:start], *new, *self.statements[start + count :]]
        try:
            values = parse("".join([each.text for each in statements if each.kind != "bad"]))
        except (ValueError, RecursionError):
            return False
        if not are_same(values, expected) and not (may_prune and are_same(_pruned(values), _pruned(expected))):
            return False
        self._splice(start, count, new, values)
        return True

    def _joined(self, start: int, count: int, lines: list[str]) -> tuple[int, int, list[str]]:
        """The same change with the line ends and blank lines that its neighbours need."""
        before = self.statements[start - 1].text if start else ""
        after = self.statements[start + count].text if start + count < len(self.statements) else ""
        lines = list(lines)
        if count == 0 and lines:
            is_chunk = not lines[0].strip()
            if is_chunk and not before.strip():
                lines.pop(0)
            if is_chunk and after.strip() and lines:
                lines.append(self._newline)
        if lines and start and not before.endswith("\n"):  # at the end of a file without a last line end
            lines = [before + self._newline, *lines]
            lines[-1] = lines[-1].removesuffix(self._newline)
            return start - 1, count + 1, lines
        is_last = start + count == len(self.statements)
        if count and is_last and lines and not self.statements[-1].text.endswith("\n"):
            lines = [line if line.endswith("\n") else line + self._newline for line in lines]
            lines[-1] = lines[-1].removesuffix(self._newline)
        return start, count, lines

    def _splice(self, start: int, count: int, new: list[Statement], values: dict[str, Any]) -> None:
        splice = Splice(start, self.statements[start : start + count], new, self.values, values)
        self.apply(splice)
        self.log.append(splice)


def _pruned(values: Any) -> Any:
    """A table without the empty tables in it, since removed keys and headers leave none behind."""
    if isinstance(values, dict):
        found = {key: _pruned(item) for key, item in values.items()}
        return {key: item for key, item in found.items() if item != {} and item != []}
    return [_pruned(item) for item in values] if isinstance(values, list) else values
