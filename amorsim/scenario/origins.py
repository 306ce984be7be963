"""Where the values of a document come from: the file, a robot's model, a device, or a default."""

from __future__ import annotations

import copy
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import attrs

from amorsim.core.parameters import Parameter
from amorsim.plugins.registry import Registry
from amorsim.scenario.faults import Book, Source
from amorsim.scenario.field_at import field_at
from amorsim.scenario.fields import default_in_file
from amorsim.scenario.layout import MISSING, Path_, found_at, without
from amorsim.scenario.lines import line_at
from amorsim.scenario.models import MODEL_KEYS, merge_models

__all__ = ["Origin", "Origins"]


@attrs.frozen(kw_only=True)
class Origin:
    """Where a value comes from.

    Parameters
    ----------
    source
        ``"file"``, ``"model"``, ``"device"`` or ``"default"``.
    value
        The value, as files say it.
    file
        The file that says it; None for a default.
    line
        The line in that file, counted from 1, where one is known.
    under
        What would hold if the file did not say it; None where nothing would, and for what it does not say.
    """

    source: str
    value: Any
    file: Path | None = None
    line: int | None = None
    under: Origin | None = None


class Origins:
    """Looks values of one document up, in the files that it builds on."""

    def __init__(self, file: Path, registry: Registry) -> None:
        self._file = file
        self._registry = registry
        self._merged: tuple[Any, dict[str, Any], Book] | None = None

    def merged(self, values: dict[str, Any], path: Path_) -> dict[str, Any]:
        """The values with the model and the devices of the robot that a path leads to under what is said of it."""
        if not _may_inherit(values, path):
            return values
        robot, _ = self._robot(values["robots"][path[1]])
        robots = [robot if i == path[1] else each for i, each in enumerate(values["robots"])]
        return {**values, "robots": robots}

    def _robot(self, said: dict[str, Any]) -> tuple[dict[str, Any], Book]:
        if self._merged is None or self._merged[0] is not said:
            book = Book(Source(file=str(self._file), folder=self._file.parent))
            tables = {"robots": [copy.deepcopy(said)]}
            merge_models(tables, book, self._registry)
            (robot,) = tables["robots"]
            robot.pop("resolved_from", None)
            self._merged = said, {**robot, "model": said["model"]}, book
        return self._merged[1], self._merged[2]

    def find(self, values: dict[str, Any], path: Path_) -> Origin | None:
        """Where the value at a path comes from; None where nothing says it."""
        if found_at(values, path) is MISSING:
            return self._inherited(values, path)
        under = self._inherited(without(values, path), path)
        return Origin(source="file", value=found_at(self.merged(values, path), path), file=self._file, under=under)

    def _inherited(self, values: dict[str, Any], path: Path_) -> Origin | None:
        merged = self.merged(values, path)
        value = found_at(merged, path)
        if value is not MISSING and merged is not values:
            _, book = self._robot(values["robots"][path[1]])
            said = book.source(("robots", "0", *map(str, path[2:])))
            if said.kind != "file":
                line = line_at(said.file, ".".join(map(str, path[said.depth :])))
                return Origin(source=said.kind, value=value, file=Path(said.file), line=line)
        field = field_at(merged, path, self._registry, self._file.parent)
        return None if field is None else _default(field)


def _default(field: Parameter) -> Origin | None:
    value = default_in_file(field)
    return None if value is None else Origin(source="default", value=value)


def _may_inherit(values: Mapping[str, Any], path: Path_) -> bool:
    """Whether a model may say what is at a path: it says nothing of where a robot is, and of what it is called."""
    if len(path) < 2 or path[0] != "robots":
        return False
    robot = found_at(values, path[:2])
    if not isinstance(robot, dict) or "model" not in robot:
        return False
    return len(path) == 2 or (path[2] in MODEL_KEYS and path[2] not in ("model", "format", "description"))
