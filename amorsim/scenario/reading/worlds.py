"""Maps in documents: the world's and the robots' own, and where a robot starts."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path

import attrs
import numpy as np

from amorsim.core.errors import MapError, PluginError, did_you_mean
from amorsim.core.maps.footprint_room import freest_start, least_gaps
from amorsim.core.maps.map import Map
from amorsim.core.numbers import is_number
from amorsim.core.parameters import parameter
from amorsim.core.shapes import Shape
from amorsim.plugins.registry import Registry
from amorsim.scenario.files.maps import MapFile, find_loader, read_map
from amorsim.scenario.knowledge import Knowledge
from amorsim.scenario.parts import at_start
from amorsim.scenario.reading.faults import Node, shown
from amorsim.scenario.reading.fields import read_component
from amorsim.scenario.reading.generated import read_generated
from amorsim.scenario.spec import Landmark, Pose, Robot
from amorsim.worlds.drawn import DrawnWorld
from amorsim.worlds.made import MadeWorld, make_world

__all__ = ["Maps", "is_free_at", "start_of"]

_FAR = 1e100  # larger numbers are taken for mistakes


class Maps:
    """The maps of one scenario; a file that is read in the same way for several robots is read once.

    With `are_read` false none is: a document's entries for them are looked at alone, for which nothing is compiled.
    """

    def __init__(self, registry: Registry, *, are_read: bool = True) -> None:
        self._registry = registry
        self._are_read = are_read
        self._read: dict[MapFile | MadeWorld | DrawnWorld, Map] = {}

    def read(self, node: Node, beside: tuple[str, ...] = (), like: Map | None = None) -> Map | None:
        """The map in a table ``{ map = "file", options ... }``; None after faults, or where none is read.

        `beside` are keys of the table that are not options. If the file is that of the map `like`, and there
        are not options, it is read as that one was. The map may also be a table, of a world to generate.
        """
        if not node.expect_table():
            return None
        if node.child("map").is_table:
            node.refuse_unknown(("map", *beside))
            return self.generated(node.child("map"))
        path = self._path(node.child("map"))
        use = node.child("use").text("the name of a map loader") if "use" in node else None
        if path is None:
            return None
        other = None if like is None else like.source
        if isinstance(other, MapFile) and other.path == path and not set(node.value) - {"map", *beside}:
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
        if loader is None or not self._are_read:
            return None
        return self._found(MapFile(path=path, loader=loader), node.child("map"))

    def generated(self, node: Node) -> Map | None:
        """The world in a table ``{ generate = "office", seed = 7, ... }``; None as for `read`.

        Where replicas have different worlds it is that of replica 0.
        """
        made = read_generated(node, self._registry)
        return None if made is None or not self._are_read else self._found(made, node)

    def _found(self, source: MapFile | MadeWorld | DrawnWorld, node: Node) -> Map | None:
        """The map of a file or a generator, or None after a fault of the node."""
        if source not in self._read:
            try:
                self._read[source] = _make(source)
            except MapError as error:
                node.fault(str(error))
                return None
        return self._read[source]

    def read_knowledge(self, node: Node, world: Map | None, marks: Sequence[Landmark]) -> Knowledge | None:
        """A robot's knowledge: ``{ map = "file", options ..., landmarks = [[x, y], ...] }``.

        A landmark may be ``{ id, x, y }`` too; ``"world"`` for all of them is what there really is, `marks`.
        """
        if not node.expect_table():
            return None
        before = node.book.count
        known = None
        keys = ("map", "use", "landmarks")
        if not {"map", "use"} & set(node.value) and any(did_you_mean(key, keys) for key in set(node.value) - set(keys)):
            node.refuse_unknown(keys)  # a misspelt key is not an option of a map that is missing
            return None
        if set(node.value) - {"landmarks"}:
            known = self.read(node, ("landmarks",), like=world)
        landmarks: list[tuple[int, float, float]] = []
        child = node.child("landmarks")
        if child.value == "world":
            landmarks = [(mark.id, mark.x, mark.y) for mark in marks]
        elif "landmarks" in node and child.expect_list("a list of points [[x, y], ...] [m], or 'world'"):
            landmarks = [mark for mark in map(_read_landmark, child.items()) if mark is not None]
        if node.book.count > before:
            return None
        ids = tuple(number for number, _, _ in landmarks)
        return Knowledge(
            map=known,
            landmarks=tuple((x, y) for _, x, y in landmarks),
            landmark_ids=ids if any(ids) else (),
        )

    def _path(self, node: Node) -> Path | None:
        name = node.text("the path of a map file")
        # Not resolve(): where a link leads is the file system's business, what the file is called the user's.
        return None if name is None else Path(os.path.abspath(node.folder / name))  # noqa: PTH100


def _make(source: MapFile | MadeWorld | DrawnWorld) -> Map:
    if isinstance(source, MapFile):
        return read_map(source)
    return source.make() if isinstance(source, DrawnWorld) else make_world(source)


def _read_landmark(node: Node) -> tuple[int, float, float] | None:
    """A landmark that a robot knows, as [x, y] or { id, x, y }; id 0 for none."""
    if node.is_table:
        mark = read_component(KnownLandmark, node)
        return None if mark is None else (mark.id, mark.x, mark.y)
    pair = node.value
    if not (isinstance(pair, list) and len(pair) == 2 and all(is_number(number, below=_FAR) for number in pair)):
        node.fault(f"expected [x, y], two finite numbers [m], or {{ id, x, y }}, got {shown(pair)}")
        return None
    return 0, float(pair[0]), float(pair[1])


@attrs.frozen(kw_only=True)
class KnownLandmark:
    """A landmark that a robot knows, with its id."""

    id: int = parameter(ge=1, le=2**31 - 1, help="what is written on it")
    x: float = parameter(unit="m", help="to the right in the world")
    y: float = parameter(unit="m", help="up in the world")


def start_of(world: Map, robot: Robot, *, must_be_free: bool = False) -> Pose:
    """Where a robot without a pose starts: at the map's start, or else at a free place with much room.

    Also where the map's start leaves it no room, if that `must_be_free`.

    Raises
    ------
    MapError
        If there is no free place for its footprint.
    """
    if world.start is not None and (not must_be_free or is_free_at(world, robot, world.start)):
        x, y, heading = world.start
        return Pose(x=float(x), y=float(y), heading=float(heading))
    x, y, heading = freest_start(world, *_footprint(robot))
    return Pose(x=x, y=y, heading=heading)


def is_free_at(world: Map, robot: Robot, pose: Sequence[float]) -> bool:
    """Whether a robot and its parts stand free of walls at a pose, before they move."""
    shape, parts = _footprint(robot)
    return bool(least_gaps(world, [(shape, (0.0, 0.0, 0.0)), *parts], np.array([pose], dtype=np.float64))[0] >= 0.0)


def _footprint(robot: Robot) -> tuple[Shape, list[tuple[Shape, Sequence[float]]]]:
    """A robot's shape, and those of its parts where they are in its frame."""
    inside = at_start(robot.drive).tolist()
    return robot.shape, [(part.shape, pose) for part, pose in zip(robot.drive.parts, inside, strict=True)]
