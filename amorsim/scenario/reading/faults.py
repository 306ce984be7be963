"""Values of a document with their paths: where each came from, and its faults."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import attrs

from amorsim.core.errors import Fault, ScenarioError
from amorsim.core.unknown_names import unknown_key
from amorsim.plugins.checks import check_name
from amorsim.scenario.reading.lines import with_lines

__all__ = ["FaultCollector", "Node", "Source"]

Path_ = tuple[str, ...]


@attrs.frozen(kw_only=True)
class Source:
    """A file, or a setting of the command line, that values came from.

    `folder` is where relative paths in it start; `depth` how many parts of a path in the whole document are
    left off to get the path in the file (a robot's model begins at the robot); `kind` is ``"file"``, ``"model"`` or
    ``"device"``.
    """

    file: str
    folder: Path
    depth: int = 0
    kind: str = "file"


@attrs.define
class Branch:
    """A part of the document: its origin, if that is known, and the parts below whose origin is."""

    source: Source | None = None
    below: dict[str, Branch] = attrs.field(factory=dict)

    def copy(self) -> Branch:
        """The same, for changes of its own."""
        return Branch(self.source, {part: branch.copy() for part, branch in self.below.items()})


class FaultCollector:
    """The faults found so far, and which parts of the document came from which source."""

    def __init__(self, source: Source) -> None:
        self._root = Branch(source)
        self._faults: dict[Fault, None] = {}  # in order
        self._count = 0
        self.places: list[Path_] = []
        """Where in the whole document the faults are, each as often as it was found."""
        self.incomplete: set[Path_] = set()
        """Tables that lack what a file which could not be read would have given them."""
        self.has_lost_lines = False
        """Whether lines that are not TOML were left out: what is missing may stand there, and is not a fault itself."""
        self.document: Any = None
        """The whole document, for the names of what stands in its lists."""
        self.warnings: tuple[str, ...] = ()
        """Warnings about the map, reported with the faults."""
        self.remarks: tuple[str, ...] = ()
        """On what was left out of another program's file."""
        self.lines: Mapping[str, int] = {}
        """The lines of another program's file that say what is at a path."""
        self.is_foreign = False
        """Whether this is another program's file, so that a robot without a pose goes where there is room."""
        self.shares_alike = False
        """Whether of robots and obstacles that differ in name and pose alone one is read, as to look at them."""
        self.alike: dict[str, Any] = {}
        """Those that were read."""

    @classmethod
    def silent(cls) -> FaultCollector:
        """A book that does not record where its values came from."""
        return cls(Source(file="", folder=Path()))

    def again(self, document: Any) -> FaultCollector:
        """An empty collector for another reading of what came from the same sources."""
        other = FaultCollector.silent()
        other._root = self._root.copy()
        other.has_lost_lines = self.has_lost_lines
        other.shares_alike, other.alike = self.shares_alike, self.alike
        other.document = document
        return other

    def set_source(self, path: Path_, source: Source) -> None:
        """From now on, everything at `path` and below came from `source`."""
        self.set_branch(path, Branch(source))

    def set_branch(self, path: Path_, branch: Branch) -> None:
        """From now on, the origin of `path` is that of `branch`."""
        place = self._root
        for part in path:
            place = place.below.setdefault(part, Branch())
        place.source, place.below = branch.source, branch.below

    def branch(self, path: Path_) -> Branch:
        """Where what is at `path` came from, and the parts below; a copy."""
        branch = self._root
        for part in path:
            if part not in branch.below:
                return Branch(self.source(path))
            branch = branch.below[part]
        return Branch(self.source(path), branch.copy().below)

    def source(self, path: Path_) -> Source:
        """Where the value at `path` came from."""
        branch = self._root
        found = branch.source
        for part in path:
            if part not in branch.below:
                break
            branch = branch.below[part]
            found = branch.source or found
        assert found is not None
        return found

    def fault(self, path: Path_, message: str, value: Any = None) -> None:
        """Note what is wrong at `path`, with the value that is there."""
        self.places.append(path)
        if self.has_lost_lines and (message.startswith("missing") or message.endswith("got nothing")):
            self._count += 1
            return
        self.add(self.at(path, message, value))

    def at(self, path: Path_, message: str, value: Any = None) -> Fault:
        """A fault at `path`, without noting it."""
        source = self.source(path)
        place, named = (".".join(parts[source.depth :]) for parts in (path, self._named(path)))
        return Fault(file=source.file, path=place, message=message, named="" if named == place else named, value=value)

    def _named(self, path: Path_) -> Path_:
        """A path with a robot's, obstacle's or zone's name in place of its number, if the name is unique."""
        things = self.document.get(path[0]) if isinstance(self.document, dict) and len(path) > 1 else None
        if path[:1] not in (("robots",), ("obstacles",), ("zones",)) or not isinstance(things, list):
            return path
        names = [thing.get("name") if isinstance(thing, dict) else None for thing in things]
        name = names[int(path[1])] if path[1].isdigit() and int(path[1]) < len(names) else None
        is_unique = isinstance(name, str) and not check_name(name) and names.count(name) == 1
        return (path[0], str(name), *path[2:]) if is_unique else path

    def add(self, fault: Fault) -> None:
        """Note a fault, once: a model's is found for every robot that is of the model."""
        self._count += 1
        self._faults[fault] = None

    @property
    def faults(self) -> tuple[Fault, ...]:
        """The faults so far, each once."""
        return tuple(self._faults)

    @property
    def count(self) -> int:
        """How often a fault was noted; it has grown where something is wrong."""
        return self._count

    def raise_if_any(self) -> None:
        """Raise `ScenarioError` with all faults and their lines, if there are any."""
        if self._faults:
            raise ScenarioError(with_lines(self._faults, lines=self.lines), (*self.remarks, *self.warnings))


@attrs.frozen
class Node:
    """A value in a document, its path, and the book that takes its faults."""

    value: Any
    path: Path_
    book: FaultCollector

    def fault(self, message: str) -> None:
        """Note what is wrong with this value."""
        self.book.fault(self.path, message, self.value)

    @property
    def folder(self) -> Path:
        """Where relative paths in this value start."""
        return self.book.source(self.path).folder

    @property
    def is_table(self) -> bool:
        """Whether the value is a table."""
        return isinstance(self.value, dict)

    def __contains__(self, key: str) -> bool:
        return key in self.value

    def child(self, key: str) -> Node:
        """The value under a key of this table; None if there is none."""
        return Node(self.value.get(key), (*self.path, key), self.book)

    def children(self) -> Iterator[tuple[str, Node]]:
        """The keys and values of this table."""
        for key in self.value:
            yield key, self.child(key)

    def items(self) -> Iterator[Node]:
        """The elements of this list."""
        for index, value in enumerate(self.value):
            yield Node(value, (*self.path, str(index)), self.book)

    def expect_table(self, what: str = "a table") -> bool:
        """Whether this is a table; a fault if not."""
        if isinstance(self.value, dict):
            return True
        self.fault(f"expected {what}, got {shown(self.value)}")
        return False

    def expect_list(self, what: str) -> bool:
        """Whether this is a list; a fault if not."""
        if isinstance(self.value, list):
            return True
        self.fault(f"expected {what}, got {shown(self.value)}")
        return False

    def text(self, what: str, default: str | None = None) -> str | None:
        """The value as a text; a fault and None if it is something else, or absent without a default."""
        if self.value is None and default is not None:
            return default
        if isinstance(self.value, str) and self.value:
            return self.value
        self.fault(f"expected {what}, got {shown(self.value)}")
        return None

    def refuse_unknown(
        self, known: Mapping[str, Any] | tuple[str, ...], elsewhere: Mapping[str, str] | None = None
    ) -> None:
        """Note a fault for every key of this table that is unknown, with what may have been meant.

        `elsewhere` has keys of other tables that are often written here, each with the name of its table.
        """
        for key, node in self.children():
            if key in known:
                continue
            if f"{key}_deg" in known:
                node.fault(f"this is an angle: write {key}_deg, in degrees")
            elif key.endswith("_deg") and key[:-4] in known:
                node.fault(f"this is not an angle: write {key[:-4]}")
            elif elsewhere and key in elsewhere:
                node.fault(f"unknown key; it belongs in {elsewhere[key]}")
            else:
                node.fault(unknown_key(key, known))


def shown(value: Any) -> str:
    """A value as a message shows it: at most some eighty characters."""
    if value is None:
        return "nothing"
    try:
        text = repr(value)
    except ValueError:  # a whole number of thousands of digits
        text = "a number of thousands of digits"
    except RecursionError:
        text = "tables or lists in one another, too many to show"
    return text if len(text) <= 80 else f"{text[:77]}..."
