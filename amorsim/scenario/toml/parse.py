"""A TOML file as it is written: its statements, their values, and the faulty lines."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from typing import Any

import attrs

from amorsim.core.errors import Fault
from amorsim.scenario.toml.inline import find
from amorsim.scenario.toml.layout import Layout, Path_
from amorsim.scenario.toml.literals import parse
from amorsim.scenario.toml.problems import plain_problem, toml_problem
from amorsim.scenario.toml.statements import Statement, cut, value_end

__all__ = ["BadLine", "Written", "line_numbers", "line_of", "read_written"]

_MOST = 20  # bad lines are reported


@attrs.frozen
class BadLine:
    """A line that is not TOML, counted from 1, and what is wrong with it."""

    line: int
    text: str
    message: str


_GOOD = ("pair", "table", "array")
_ALL_BAD = 3  # lines, from which on a file without a good one is not TOML at all


class Written:
    """The values of a file without its bad lines, and the bad lines."""

    def __init__(
        self, text: str, values: dict[str, Any], statements: list[Statement] | None = None, bad: Iterable[BadLine] = ()
    ) -> None:
        self.values = values
        self.bad = tuple(bad)
        self.text = text
        self._statements = statements

    @property
    def statements(self) -> list[Statement]:
        """The text in its statements, those of bad lines being "bad"."""
        if self._statements is None:  # which only changes and faults ask for
            self._statements = cut(self.text)
        return self._statements

    def faults(self, file: str) -> list[Fault]:
        """The bad lines as faults of the file; one fault if no line is good."""
        if len(self.bad) >= _ALL_BAD and not self.values and not any(each.kind in _GOOD for each in self.statements):
            first = self.bad[0]
            message = "not a file of TOML: none of its lines is KEY = VALUE or [TABLE]"
            return [Fault(file=file, path="", message=message, line=first.line, value=first.text)]
        return [Fault(file=file, path="", message=each.message, line=each.line, value=each.text) for each in self.bad]


def read_written(text: str) -> Written:
    """The values of a text; lines that are not valid TOML are reported and ignored."""
    try:
        return Written(text, parse(text))
    except (ValueError, RecursionError):
        pass
    statements = cut(text)
    bad: dict[int, str] = {}
    is_open = False  # whether the lines before are of a value that does not end
    for index, statement in enumerate(tuple(statements)):
        if statement.kind != "bad":
            is_open = False
        elif not is_open:
            bad[index] = _problem_of(statement.text)
            is_open = _is_open(statement.text)
            _leave_out_body(statements, index, statement.text)
    values: dict[str, Any] = {}
    while len(bad) < _MOST:
        try:
            values = parse(_sound(statements))
            break
        except (ValueError, RecursionError) as error:
            index = _first_bad(statements, str(error))
            bad[index] = toml_problem(error, statements[index].text)
            old = statements[index]
            statements[index] = Statement(old.text, "bad")
            if old.kind != "pair":
                _leave_out_body(statements, index, old.text)
    else:  # this is not a file of TOML
        statements = [Statement(each.text, "bad") for each in statements]
    lines = line_numbers(statements)
    reported = sorted(bad)[:_MOST]
    return Written(text, values, statements, [BadLine(lines[i], statements[i].text.strip(), bad[i]) for i in reported])


def _is_open(text: str) -> bool:
    """Whether a line begins a value of several lines that does not end."""
    _, equals, value = text.partition("=")
    value = value.strip()
    return bool(equals) and (value.startswith(("[", "{", "'''", '"""')) and value_end(value, 0) is None)


def _sound(statements: Sequence[Statement]) -> str:
    return "".join([each.text for each in statements if each.kind != "bad"])


def _leave_out_body(statements: list[Statement], index: int, text: str) -> None:
    """Mark the pairs under a header that cannot be read: to which table they belong is not known."""
    if not text.lstrip().startswith("["):
        return
    for i in range(index + 1, len(statements)):
        if statements[i].kind in ("table", "array"):
            return
        if statements[i].kind == "pair":
            statements[i] = Statement(statements[i].text, "bad")


def _first_bad(statements: Sequence[Statement], problem: str) -> int:
    """The first statement with which the file is not TOML."""

    def is_sound(count: int) -> bool:
        try:
            parse(_sound(statements[:count]))
        except (ValueError, RecursionError):
            return False
        return True

    sound, faulty = 0, len(statements)  # how many of the first are sound, and are not
    place = re.search(r"\(at line (\d+)", problem)
    if place:  # where TOML's reader has noticed it is mostly where it is
        line, wanted = 1, int(place[1])
        for index, statement in enumerate(statements):
            if statement.kind != "bad":
                line += statement.text.count("\n")
            if line > wanted:
                if is_sound(index):
                    sound = index
                if not is_sound(index + 1):
                    faulty = index + 1
                break
    while faulty - sound > 1:
        middle = (sound + faulty) // 2
        if is_sound(middle):
            sound = middle
        else:
            faulty = middle
    return faulty - 1


def _problem_of(text: str) -> str:
    try:
        parse(text)
    except (ValueError, RecursionError) as error:
        return toml_problem(error, text)
    return plain_problem()


def line_numbers(statements: Sequence[Statement]) -> list[int]:
    """The line, counted from 1, that each statement begins in."""
    numbers, line = [], 1
    for statement in statements:
        numbers.append(line)
        line += statement.text.count("\n")
    return numbers


def line_of(
    statements: Sequence[Statement], layout: Layout, path: Path_, numbers: Sequence[int] | None = None
) -> int | None:
    """The line, counted from 1, for a path, or for the nearest thing above it; None if there is none.

    `numbers` are the statements' `line_numbers`, counted here if they are not given.
    """
    numbers = line_numbers(statements) if numbers is None else numbers
    spot = layout.pair_over(path)
    if spot is not None:
        index, rest = spot
        statement = statements[index]
        at, member, _ = find(statement.text, statement.first, rest)
        inside = statement.text[: at if member is None else member.start].count("\n")
        return numbers[index] + inside
    for length in range(len(path), 0, -1):
        under = layout.under(path[:length])
        if under:
            own = layout.headers.get(path[:length])
            return numbers[own if own is not None else under[0]]
    return None
