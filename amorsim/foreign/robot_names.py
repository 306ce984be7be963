"""Valid names of robots and obstacles, made from those of other programs."""

from __future__ import annotations

import re

__all__ = ["Names"]

_OTHER = re.compile(r"[^A-Za-z0-9_-]+")
_MOST = 64


class Names:
    """Gives each thing a name of its own."""

    def __init__(self) -> None:
        self._taken: set[str] = set()
        self._last: dict[str, int] = {}

    def free(self, wanted: str) -> str:
        """The name as scenarios spell it: letters, digits, '-' and '_'; with a number if it is taken."""
        stem = _OTHER.sub("_", wanted).strip("_") or "thing"
        stem = (stem if stem[0].isalpha() else f"n{stem}")[:_MOST]
        name, number = stem, self._last.get(stem, 1)
        while name in self._taken:
            number += 1
            name = f"{stem[: _MOST - 8]}_{number}"
        self._last[stem] = number
        self._taken.add(name)
        return name
