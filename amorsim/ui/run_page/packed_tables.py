"""Tables of numbers as few bytes: rounded, as differences from row to row, so that compression finds little to keep."""

from __future__ import annotations

from typing import TypedDict

import numpy as np

from amorsim.array_types import AnyArray, Array

__all__ = ["Series", "SeriesWriter", "read_series"]

DIGITS = 5  # of the largest number of a column
_NAN, _INF, _MINUS_INF = -(2**31), 2**31 - 1, -(2**31) + 1  # what these are written as; the script has the same


class Series(TypedDict):
    """A table `(rows, width)` in bytes: where it begins, and the powers of ten by which its columns were rounded."""

    at: int
    rows: int
    width: int
    exponents: list[int]


class SeriesWriter:
    """Appends tables to bytes.

    Attributes
    ----------
    data
        The bytes so far.
    """

    def __init__(self) -> None:
        self.data = bytearray()

    def add(self, table: AnyArray, *, digits: int = DIGITS, finest: int = -4) -> Series:
        """Append a table `(rows, width)` of finite numbers, nan and infinities.

        Parameters
        ----------
        digits
            That are kept of the largest number of each column. At most 9.
        finest
            The least power of ten that any column is rounded to.
        """
        table = np.asarray(table, dtype=float)
        rows, width = table.shape
        size = np.abs(np.where(np.isfinite(table), table, 0.0)).max(axis=0, initial=0.0)
        leading = np.floor(np.log10(np.where(size > 0.0, size, 1.0))).astype(int)
        exponents = np.maximum(leading - digits + 1, finest)
        whole = np.rint(np.where(np.isfinite(table), table, 0.0) / 10.0**exponents).astype(np.int64)
        for which, code in ((np.isnan(table), _NAN), (np.isposinf(table), _INF), (np.isneginf(table), _MINUS_INF)):
            whole[which] = code
        difference = np.diff(whole, axis=0, prepend=0).astype(np.int32)  # wraps around, as the sum does that undoes it
        folded = ((difference << 1) ^ (difference >> 31)).astype("<u4")  # small ones are small, whatever their sign
        series = Series(at=len(self.data), rows=rows, width=width, exponents=exponents.tolist())
        # All lowest bytes first, then all second ones: most of the latter are 0.
        self.data += np.ascontiguousarray(folded.T).view(np.uint8).reshape(-1, 4).T.tobytes()
        return series


def read_series(data: bytes | bytearray, series: Series) -> Array:
    """The table that was added, rounded as `SeriesWriter.add` did; the page's script does the same."""
    count = series["rows"] * series["width"]
    planes = np.frombuffer(data, np.uint8, 4 * count, series["at"]).reshape(4, count)
    folded = np.ascontiguousarray(planes.T).view("<u4").reshape(series["width"], series["rows"]).T
    difference = (folded >> 1).astype(np.int32) ^ -(folded & 1).astype(np.int32)
    whole = np.cumsum(difference, axis=0, dtype=np.int32)
    table = whole * 10.0 ** np.array(series["exponents"], dtype=float)
    for code, value in ((_NAN, np.nan), (_INF, np.inf), (_MINUS_INF, -np.inf)):
        table[whole == code] = value
    return table
