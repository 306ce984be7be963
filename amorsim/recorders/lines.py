"""Tables of numbers into lines of text."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from amorsim.kernels.decimals import EMPTY, NAME, TOKEN, WIDEST, write_lines

__all__ = ["EXACT", "NAME", "NOTHING", "Lines", "Names", "as_lines"]

Array = npt.NDArray[np.float64]

EXACT = TOKEN
"""A column of numbers that are written as the shortest decimals that read back the same."""
NOTHING = EMPTY
"""A column whose cells stay empty."""
_MOST_DECIMALS = 13
_CELLS_AT_ONCE = 1 << 15


class Names:
    """Texts that a column of `NAME` counts."""

    def __init__(self, texts: Sequence[str]) -> None:
        self.texts = [text.encode() for text in texts]
        self.longest = max((len(text) for text in self.texts), default=0)
        self.bytes = np.frombuffer(bytearray(b"".join(self.texts) or b","), dtype=np.uint8)
        self.ends = np.cumsum([len(text) for text in self.texts], dtype=np.int64)


class Lines(NamedTuple):
    """Whole lines, and where each ends."""

    data: bytes
    ends: npt.NDArray[np.int64]


def as_lines(values: Array, kinds: Sequence[int], names: Names) -> Lines:
    """A line for each row of `values` `(n, k)`, its cells after their columns' kinds `(k,)`, commas between.

    A kind is a number of decimals, `NAME`, `EXACT` or `NOTHING`. What is written is to the byte what Python's
    ``f"{value:.6f}"``, of as many decimals, and ``repr(value)`` give.
    """
    rows, columns = values.shape
    at_once = max(1, _CELLS_AT_ONCE // max(columns, 1))
    if rows > at_once:
        parts = [as_lines(values[first : first + at_once], kinds, names) for first in range(0, rows, at_once)]
        starts = np.cumsum([0] + [len(part.data) for part in parts])
        moved = [part.ends + start for part, start in zip(parts, starts.tolist(), strict=False)]
        return Lines(b"".join(part.data for part in parts), np.concatenate(moved))
    if max(kinds) > _MOST_DECIMALS:
        return _slowly(values, kinds, names)
    kind = np.array(kinds, dtype=np.int64)
    exact = values[:, kind == EXACT]
    # Python writes them: its shortest decimals, in one call.
    tokens = repr(exact.ravel().tolist())[1:-1].replace(" ", "").encode() + b","
    out = np.empty(rows * (columns * WIDEST + names.longest) + len(tokens), dtype=np.uint8)
    ends = np.empty(rows, dtype=np.int64)
    given = np.frombuffer(bytearray(tokens), dtype=np.uint8)
    if not write_lines(np.ascontiguousarray(values), kind, names.bytes, names.ends, given, ends, out):
        return _slowly(values, kinds, names)
    return Lines(out[: ends[-1] if rows else 0].tobytes(), ends)


def _slowly(values: Array, kinds: Sequence[int], names: Names) -> Lines:
    """The same, cell by cell: for numbers of more digits than the kernel tells apart."""
    lines = []
    for row in values.tolist():
        cells = []
        for value, kind in zip(row, kinds, strict=True):
            if kind == NAME:
                cells.append(names.texts[int(value)])
            elif kind == NOTHING:
                cells.append(b"")
            else:
                cells.append((repr(value) if kind == EXACT else f"{value:.{kind}f}").encode())
        lines.append(b",".join(cells) + b"\n")
    return Lines(b"".join(lines), np.cumsum([len(line) for line in lines], dtype=np.int64))
