"""Maps in documents: the world's, and those that robots are told; and where a robot starts on one."""

from __future__ import annotations

import math
import os
from pathlib import Path

from amorsim.core.errors import MapError, PluginError
from amorsim.core.map import Map
from amorsim.plugins.registry import Registry
from amorsim.scenario.faults import Node
from amorsim.scenario.fields import read_component
from amorsim.scenario.maps import MapFile, find_loader, read_map
from amorsim.scenario.spec import Knowledge, Pose

__all__ = ["Maps", "start_of"]


class Maps:
    """The maps of one scenario; a file that is read in the same way for several robots is read once."""

    def __init__(self, registry: Registry) -> None:
        self._registry = registry
        self._read: dict[MapFile, Map] = {}

    def read(self, node: Node, beside: tuple[str, ...] = (), like: Map | None = None) -> Map | None:
        """The map in a table ``{ map = "file", options ... }``, or None after faults.

        `beside` are keys of the table that are no options. If the file is that of the map `like`, and there
        are no options, it is read as that one was.
        """
        if not node.expect_table():
            return None
        path = self._path(node.child("map"))
        use = node.child("use").text("the name of a map loader") if "use" in node else None
        if path is None:
            return None
        other = None if like is None else like.source
        if other is not None and other.path == path and not set(node.value) - {"map", *beside}:
            return like
        try:
            _, cls = find_loader(path, use, self._registry)
        except PluginError as error:
            node.child("use").fault(str(error))
            return None
        except MapError as error:
            node.child("map").fault(str(error))
            return None
        loader = read_component(cls, node, beside=("map", "use", *beside))
        if loader is None:
            return None
        file = MapFile(path=path, loader=loader)
        if file not in self._read:
            try:
                self._read[file] = read_map(file)
            except MapError as error:
                node.child("map").fault(str(error))
                return None
        return self._read[file]

    def read_knowledge(self, node: Node, world: Map | None) -> Knowledge | None:
        """What a robot is told: ``{ map = "file", options ..., landmarks = [[x, y], ...] }``."""
        if not node.expect_table():
            return None
        before = node.book.count
        known = None
        if set(node.value) - {"landmarks"}:
            known = self.read(node, ("landmarks",), like=world)
        landmarks = []
        child = node.child("landmarks")
        if "landmarks" in node and child.expect_list("a list of points [[x, y], ...] [m]"):
            for point in child.items():
                pair = point.value
                if not (isinstance(pair, list) and len(pair) == 2 and all(_is_number(number) for number in pair)):
                    point.fault(f"expected [x, y], two finite numbers [m], got {pair!r}")
                    continue
                landmarks.append((float(pair[0]), float(pair[1])))
        return None if node.book.count > before else Knowledge(map=known, landmarks=tuple(landmarks))

    def _path(self, node: Node) -> Path | None:
        name = node.text("the path of a map file")
        # Not resolve(): where a link leads is the file system's business, what the file is called the user's.
        return None if name is None else Path(os.path.abspath(node.folder / name))  # noqa: PTH100


def _is_number(value: object) -> bool:
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        return False
    return abs(value) < 1e100 if isinstance(value, int) else math.isfinite(value)


def start_of(world: Map) -> Pose:
    """Where a robot starts that is not told where: the map's start, or else the free place with most room.

    Raises
    ------
    MapError
        If there is no free place.
    """
    if world.start is not None:
        x, y, heading = world.start
        return Pose(x=float(x), y=float(y), heading=float(heading))
    x, y = world.freest_place()
    return Pose(x=float(x), y=float(y))
