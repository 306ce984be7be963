"""Robots and obstacles of another program's file that differ in name and pose alone: one of them is read."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar

import attrs

from amorsim.plugins.checks import check_name
from amorsim.scenario.bodies import read_pose
from amorsim.scenario.faults import Node
from amorsim.scenario.spec import Obstacle, Robot

__all__ = ["Alike"]

Body = TypeVar("Body", Robot, Obstacle)


class Alike:
    """Bodies that were read, by all that their tables say but for name and pose."""

    def __init__(self) -> None:
        self._known: dict[str, Robot | Obstacle] = {}

    def read(self, node: Node, read: Callable[[Node], Body | None]) -> Body | None:
        """The body in a table, by `read` if there is none like it yet."""
        own = node.value if node.is_table and node.book.is_foreign else {}
        if not ({"name", "pose"} <= set(own) and isinstance(own["pose"], dict) and not check_name(own["name"])):
            return read(node)
        rest = repr({key: value for key, value in own.items() if key not in ("name", "pose")})
        known = self._known.get(rest)
        if known is None:
            found = read(node)
            if found is not None:
                self._known[rest] = found
            return found
        pose = read_pose(node.child("pose"))
        return None if pose is None else attrs.evolve(known, name=own["name"], pose=pose)  # type: ignore[return-value]
