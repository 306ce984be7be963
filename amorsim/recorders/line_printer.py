"""Tables of numbers into lines of text."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from amorsim.array_types import Array, Ints
from amorsim.kernels.text.decimals import EMPTY, EXACT, MISSING, NAME, SPAN, WIDEST, write_lines
from amorsim.kernels.text.shortest import powers_of_ten

__all__ = ["EXACT", "MISSING", "NAME", "NOTHING", "Columns", "Lines", "Printer", "Span"]


NOTHING = EMPTY
"""A column whose cells stay empty."""
_MOST_DECIMALS = 13
_CELLS_AT_ONCE = 1 << 15


class Span(NamedTuple):
    """Adjacent columns of one kind, in a table whose lines hold the numbers of several rows.

    `kind` is a number of decimals, `EXACT` for the shortest decimals that read back the same, `NOTHING`, `MISSING` for
    nan, or `NAME`; with `NAME` the other fields count names instead of numbers.
    """

    kind: int
    first: int = 0  # where the columns of row 0 begin
    per_row: int = 0  # offset from one row's columns to the next row's
    cells: int = 1


class Columns:
    """The columns of a file's lines: spans, and the names that they write."""

    def __init__(self, spans: Sequence[Span], names: Sequence[str] = ()) -> None:
        self.spans = np.array(spans, dtype=np.int64).reshape(-1, SPAN)
        self.longest = max((span.cells for span in spans), default=0)
        self.names = [name.encode() for name in names]
        self.bytes = np.frombuffer(bytearray(b"".join(self.names) or b","), dtype=np.uint8)
        self.ends = np.cumsum([len(name) for name in self.names], dtype=np.int64)
        self.needs_python = any(span.kind > _MOST_DECIMALS for span in spans)
        names_width = sum(span.kind == NAME for span in spans) * max((len(name) for name in self.names), default=0)
        self.cells = sum(span.cells for span in spans)
        self.width = self.cells * WIDEST + names_width  # bytes that a line takes at most


class Lines(NamedTuple):
    """Whole lines, valid until the next ones are made, and where each ends."""

    data: memoryview
    ends: Ints


class Printer:
    """Makes lines of tables, always in the same buffer: fresh memory costs more time than the digits."""

    def __init__(self) -> None:
        self._out = np.empty(0, dtype=np.uint8)
        self._words = np.empty(0, dtype=np.uint64)

    def print(self, table: Array, rows: int, lines: Ints, columns: Columns) -> Iterator[Lines]:
        """Lines with `columns`, some at a time, from `table` `(s, w)`, which holds numbers of `rows` rows.

        `lines` `(n,)` holds the step and row of each line, ``step * rows + row``. The text equals, to the byte, that of
        Python's ``f"{value:.6f}"`` with the same decimals, and of ``repr(value)``.
        """
        at_once = max(1, _CELLS_AT_ONCE // max(columns.cells, 1))
        for first in range(0, len(lines), at_once):
            yield self._print(table, rows, lines[first : first + at_once], columns)

    def _print(self, table: Array, rows: int, lines: Ints, columns: Columns) -> Lines:
        room = len(lines) * columns.width
        if len(self._out) < room:
            self._out = np.empty(room, dtype=np.uint8)
        if len(self._words) < columns.longest:
            self._words = np.empty(columns.longest, dtype=np.uint64)
        ends = np.empty(len(lines), dtype=np.int64)
        is_written = not columns.needs_python and write_lines(
            table,
            rows,
            lines,
            columns.spans,
            columns.bytes,
            columns.ends,
            powers_of_ten(),
            self._words,
            ends,
            self._out,
        )
        return Lines(self._out.data[: ends[-1]], ends) if is_written else _slowly(table, rows, lines, columns)


def _slowly(table: Array, rows: int, lines: Ints, columns: Columns) -> Lines:
    """The same, cell by cell: for numbers with more digits than the kernel resolves."""
    made = []
    for line in lines.tolist():
        step, row = divmod(line, rows)
        cells: list[bytes] = []
        for kind, first, per_row, count in columns.spans.tolist():
            for place in range(first + row * per_row, first + row * per_row + count):
                cells.append(columns.names[place] if kind == NAME else _cell(kind, table, step, place))
        made.append(b",".join(cells) + b"\n")
    return Lines(memoryview(b"".join(made)), np.cumsum([len(line) for line in made], dtype=np.int64))


def _cell(kind: int, table: Array, step: int, place: int) -> bytes:
    if kind in (NOTHING, MISSING):
        return b"" if kind == NOTHING else b"nan"
    value = float(table[step, place])
    return (repr(value) if kind == EXACT else f"{value:.{kind}f}").encode()
