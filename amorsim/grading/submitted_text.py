"""Text that a submission sent, made fit for a terminal, a table and a page."""

from __future__ import annotations

__all__ = ["as_line", "csv_cell"]

_LINES = 2
_LONGEST = 400  # characters
_END = 100  # of these, from the end of a longer text
_FORMULA = ("=", "+", "-", "@")


def as_line(text: str) -> str:
    """The first two lines of a text as one, at most 400 characters long, with unprintable ones escaped."""
    lines = [line.strip() for line in text[: 10 * _LONGEST].splitlines() if line.strip()]
    line = " / ".join(lines[:_LINES]) + (" ..." if len(lines) > _LINES else "")
    # Control characters, marks that turn the direction of writing, and halves of surrogate pairs.
    shown = "".join(each if each.isprintable() else each.encode("unicode_escape").decode("ascii") for each in line)
    return shown if len(shown) <= _LONGEST else f"{shown[: _LONGEST - _END - 5]} ... {shown[-_END:]}"


def csv_cell(text: str) -> str:
    """A text as a cell that no spreadsheet takes for a formula."""
    return f"'{text}" if text.lstrip().startswith(_FORMULA) else text
