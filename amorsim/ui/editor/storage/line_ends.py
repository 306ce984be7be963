"""The ends of lines of a text that was changed in a browser."""

from __future__ import annotations

import io
from collections import Counter

__all__ = ["with_line_ends"]


def with_line_ends(typed: str, before: str) -> str:
    """The typed text with the line ends of the text that it replaces.

    A browser gives all lines the same end. Lines above and below what was changed keep the ends that they had, and
    those between get the commonest one.
    """
    if "\r" not in before or "\r" in typed:
        return typed
    old, new = _lines(before), _lines(typed)
    shorter = min(len(old), len(new))
    above = next((n for n in range(shorter) if not _is_same(old[n], new[n])), shorter)
    rest = shorter - above
    below = next((n for n in range(rest) if not _is_same(old[-1 - n], new[-1 - n])), rest)
    usual = Counter(end for _, end in old if end).most_common(1)[0][0]
    between = [(words, usual if end else "") for words, end in new[above : len(new) - below]]
    return "".join(words + end for words, end in [*old[:above], *between, *old[len(old) - below :]])


def _lines(text: str) -> list[tuple[str, str]]:
    """The words of each line, and its line end; the last may have none."""
    whole = io.StringIO(text, newline="")
    return [(words := line.rstrip("\r\n"), line[len(words) :]) for line in whole]


def _is_same(one: tuple[str, str], other: tuple[str, str]) -> bool:
    return one[0] == other[0] and bool(one[1]) == bool(other[1])
