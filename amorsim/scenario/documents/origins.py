"""Where the values of a document come from: the file, a robot's model, a device, or a default."""

from __future__ import annotations

import copy
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import attrs

from amorsim.core.parameters import Parameter
from amorsim.plugins.registry import Registry
from amorsim.scenario.documents.field_at import field_at
from amorsim.scenario.files.models import MODEL_KEYS, merge_models
from amorsim.scenario.reading.faults import FaultCollector, Source
from amorsim.scenario.reading.fields import NONE, default_in_file, file_fields
from amorsim.scenario.reading.lines import line_at
from amorsim.scenario.toml.layout import MISSING, Path_, found_at, without
from amorsim.scenario.toml.literals import are_same

__all__ = ["KINDS", "Origin", "Origins", "kind_of", "lifted"]


_OF_SCENARIOS = {"world", "robots", "simulation", "task"}
_OF_SCENARIOS |= {"recording", "obstacles", "landmarks", "lights", "zones", "floor"}
_OF_MODELS = {"drive", "shape", "sensors", "estimators", "controller", "ground", "errors", "on_collision"}
_INHERITED = set(MODEL_KEYS) - {"model", "format", "description"}


@attrs.frozen(kw_only=True)
class Origin:
    """Where a value comes from.

    Parameters
    ----------
    source
        ``"file"``, ``"model"``, ``"device"`` or ``"default"``.
    value
        The value, as files have it.
    file
        The file that sets it; None for a default.
    line
        The line in that file, counted from 1, where one is known.
    under
        What would hold if the file did not set it; None where nothing would, and for what it does not set.
    """

    source: str
    value: Any
    file: Path | None = None
    line: int | None = None
    under: Origin | None = None


KINDS: dict[str, Path_] = {
    "scenario": (),
    "model": ("robots", 0),
    "device": ("robots", 0, "sensors", "device"),
}
"""The kinds of documents, and where in a scenario a document of the kind would be."""


def kind_of(values: Mapping[str, Any]) -> str:
    """The kind of a document: a scenario, a robot's model, or a device."""
    if _OF_SCENARIOS & set(values):
        return "scenario"
    if _OF_MODELS & set(values):
        return "model"
    return "device" if {"use", "model"} & set(values) else "scenario"


def lifted(values: dict[str, Any]) -> dict[str, Any]:
    """The scenario's tables for a document: its own, those of a robot with the model, or of one with the device."""
    kind = kind_of(values)
    if kind == "scenario":
        return values
    own = {key: value for key, value in values.items() if key not in ("format", "description")}
    return {"robots": [own if kind == "model" else {"sensors": {"device": own}}]}


class Origins:
    """Finds where the values of one document come from in the files that it builds on."""

    def __init__(self, file: Path, registry: Registry) -> None:
        self._file = file
        self._registry = registry
        self._merged: tuple[Any, dict[str, Any], FaultCollector] | None = None

    def merged(self, values: dict[str, Any], path: Path_) -> dict[str, Any]:
        """The values of a robot that a path leads to: its own, and below them those of its model and its devices."""
        at = KINDS[kind_of(values)]
        root = lifted(values)
        if not _may_inherit(root, (*at, *path)):
            return values
        own = found_at(self._lifted_merged(root, (*at, *path)), at)
        if own is MISSING:  # a device that builds on one that cannot be read
            return values
        return {**values, **own} if at else own

    def _lifted_merged(self, root: dict[str, Any], path: Path_) -> dict[str, Any]:
        if not _may_inherit(root, path):
            return root
        robot, _ = self._robot(root["robots"][path[1]])
        return {**root, "robots": [robot if i == path[1] else each for i, each in enumerate(root["robots"])]}

    def _robot(self, written: dict[str, Any]) -> tuple[dict[str, Any], FaultCollector]:
        if self._merged is None or not (self._merged[0] is written or are_same(self._merged[0], written)):
            book = FaultCollector(Source(file=str(self._file), folder=self._file.parent))
            tables = {"robots": [copy.deepcopy(written)]}
            merge_models(tables, book, self._registry)
            (robot,) = tables["robots"]
            robot.pop("resolved_from", None)
            self._merged = written, {**robot, **({"model": written["model"]} if "model" in written else {})}, book
        return self._merged[1], self._merged[2]

    def find(self, values: dict[str, Any], path: Path_) -> Origin | None:
        """Where the value at a path comes from; None where there is no value."""
        if found_at(values, path) is MISSING:
            return self._inherited(values, path)
        under = self._inherited(without(values, path), path)
        return Origin(source="file", value=found_at(self.merged(values, path), path), file=self._file, under=under)

    def _inherited(self, values: dict[str, Any], path: Path_) -> Origin | None:
        root, at = lifted(values), (*KINDS[kind_of(values)], *path)
        merged = self._lifted_merged(root, at)
        value = found_at(merged, at)
        if value is not MISSING and merged is not root:
            _, book = self._robot(root["robots"][at[1]])
            written = book.source(("robots", "0", *map(str, at[2:])))
            if written.kind != "file":
                line = line_at(written.file, ".".join(map(str, at[written.depth :])))
                return Origin(source=written.kind, value=value, file=Path(written.file), line=line)
        default = self._default(merged, at)
        return None if default is None else Origin(source="default", value=default)

    def default(self, values: dict[str, Any], path: Path_) -> Any:
        """The default of the field at a path, as files have it; None where there is none."""
        root, at = lifted(values), (*KINDS[kind_of(values)], *path)
        return self._default(self._lifted_merged(root, at), at)

    def default_over(self, values: dict[str, Any], path: Path_) -> tuple[Path_, dict[str, Any]] | None:
        """The component over a path that neither the file nor a model sets: where it is, and its table.

        That is its default's, without needless keys, and empty if the path leads to ``use``. A file that sets one of
        the component's fields must name the component.
        """
        root, begin = lifted(values), KINDS[kind_of(values)]
        at = (*begin, *path)
        merged = self._lifted_merged(root, at)
        for length in range(len(begin) + 1, len(at)):
            if found_at(merged, at[:length]) is not MISSING:
                continue
            field = field_at(merged, at[:length], self._registry, self._file.parent)
            if field is None or not field.component:
                continue
            if at[length:] == ("use",):
                return path[: length - len(begin)], {}
            if not field.is_required and field.default is not None:
                return path[: length - len(begin)], _without_defaults(default_in_file(field), field)
        return None

    def is_needless(self, values: dict[str, Any], path: Path_) -> bool:
        """Whether a file names at a path the component of a model, or the one that would hold there by default."""
        written = found_at(values, path)
        if not isinstance(written, dict) or "use" not in written:
            return False
        under = self._inherited(without(values, path), path)
        if under is None:
            return False
        if under.source != "default":
            return are_same(under.value, found_at(self.merged(values, path), path))
        root, at = lifted(values), (*KINDS[kind_of(values)], *path)
        field = field_at(self._lifted_merged(root, at), at, self._registry, self._file.parent)
        if field is None or not field.component or field.is_required:
            return False
        default = default_in_file(field)
        if default == NONE or written.get("use") != default["use"]:
            return False
        return are_same(_without_defaults(written, field), _without_defaults(default, field))

    def _default(self, merged: dict[str, Any], at: Path_) -> Any:
        field = field_at(merged, at, self._registry, self._file.parent)
        return None if field is None else default_in_file(field)


def _without_defaults(table: dict[str, Any], field: Parameter) -> dict[str, Any]:
    """The table of a field's class without the values that are the defaults of its fields."""
    fields = file_fields(type(field.default))
    defaults = {key: default_in_file(one) for key, one in fields.items()}
    return {key: value for key, value in table.items() if key not in defaults or not are_same(value, defaults[key])}


def _may_inherit(root: Mapping[str, Any], path: Path_) -> bool:
    """Whether a model or a device may set a path; none of them sets a robot's place or name."""
    if len(path) < 2 or path[0] != "robots":
        return False
    robot = found_at(root, path[:2])
    if not isinstance(robot, dict) or (len(path) > 2 and path[2] not in _INHERITED):
        return False
    sensors = robot.get("sensors")
    devices = sensors.values() if isinstance(sensors, dict) else ()
    return "model" in robot or any(isinstance(sensor, dict) and "model" in sensor for sensor in devices)
