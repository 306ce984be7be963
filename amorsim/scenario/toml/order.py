"""The order of items in a list or a table, and how to change it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from amorsim.scenario.toml.layout import Path_, changed, found_at

__all__ = ["exchanged", "order_of", "reordered"]

Run = tuple[int, int]


def order_of(holder: Any) -> list[Any]:
    """The numbers of a list's items, or the keys of a table, in their order."""
    return list(range(len(holder))) if isinstance(holder, list) else list(holder)


def reordered(values: dict[str, Any], path: Path_, number: int, place: int) -> dict[str, Any]:
    """The values with item `number` of the list or table at a path elsewhere, number `place` afterwards."""
    holder = found_at(values, path)
    order = order_of(holder)
    order.insert(place, order.pop(number))
    inner = [holder[key] for key in order] if isinstance(holder, list) else {key: holder[key] for key in order}
    whole: dict[str, Any] = changed(values, path, inner)
    return whole


def exchanged(lines: Sequence[str], own: Run, other: Run, newline: str) -> tuple[int, int, list[str]]:
    """The replacements of lines by which a run of lines moves to where another one is.

    A blank line keeps runs of several lines (tables with a header) apart, but not single lines (pairs).
    """
    (start, stop), (first, last) = own, other
    moved = list(lines[start:stop])
    gap = [newline] if any(line.lstrip().startswith("[") for line in (*moved, *lines[first:last])) else []
    if first < start:
        return first, stop - first, [*moved, *gap, *_stripped(lines[first:start])]
    return start, last - start, [*_stripped(lines[stop:last]), *gap, *moved]


def _stripped(lines: Sequence[str]) -> list[str]:
    """Lines without the blank ones at both ends."""
    start, stop = 0, len(lines)
    while start < stop and not lines[start].strip():
        start += 1
    while stop > start and not lines[stop - 1].strip():
        stop -= 1
    return list(lines[start:stop])
