"""Items of lists by the names that they have in a scenario."""

from __future__ import annotations

from typing import Any

from amorsim.core.errors import did_you_mean

__all__ = ["index_of"]


def index_of(items: list[Any], part: str) -> int | str:
    """The index of the item that a part of a path means, by name or number, or what is wrong with it."""
    names = [_name(item) for item in items]
    if part in names:
        return names.index(part)
    if part.isascii() and part.isdigit() and int(part[:9]) < len(items):
        return int(part)
    known = ", ".join(name for name in names if name)
    there = f"{len(items)} of them" + (f": {known}" if known else "")
    return f"there is no {part!r} among these, but {there}.{did_you_mean(part, filter(None, names))}"


def _name(item: Any) -> str:
    name = item.get("name", item.get("use")) if isinstance(item, dict) else None
    return name if isinstance(name, str) else ""
