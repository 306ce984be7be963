"""Items of lists by the names that they have in a scenario."""

from __future__ import annotations

from typing import Any

from amorsim.core.unknown_names import no_such

__all__ = ["index_of"]


_KINDS = {"noise": "element", "ground": "element", "also": "recorder"}  # of items, where the list has another name


def index_of(items: list[Any], part: str, of: str = "") -> int | str:
    """The index of the item that a part of a path names, by name or number; or what is wrong with it.

    `of` is the name of the list: ``"robots"``.
    """
    names = [_name(item) for item in items]
    if part in names:
        return names.index(part)
    if part.isascii() and part.isdigit() and int(part[:9]) < len(items):
        return int(part)
    known = list(filter(None, names)) or ([f"0 to {len(items) - 1}"] if items else [])
    return no_such(_KINDS.get(of, of.removesuffix("s")) or "item", part, known)


def _name(item: Any) -> str:
    name = item.get("name", item.get("use")) if isinstance(item, dict) else None
    return name if isinstance(name, str) else ""
