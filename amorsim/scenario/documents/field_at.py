"""The parameter that a path in a scenario's tables leads to, as its component has it: unit, bounds, default."""

from __future__ import annotations

import typing
from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

import attrs

from amorsim.contracts import Mount
from amorsim.core.errors import MapError, PluginError
from amorsim.core.parameters import Parameter
from amorsim.plugins.registry import Registry
from amorsim.scenario.files.maps import find_loader
from amorsim.scenario.files.models import LOOKS
from amorsim.scenario.floor import Drop, Floor, Marking
from amorsim.scenario.initial_belief import InitialBelief
from amorsim.scenario.kidnapping import Kidnapping
from amorsim.scenario.random_start import RandomStart
from amorsim.scenario.reading.fields import file_fields
from amorsim.scenario.reading.starts import GridStart
from amorsim.scenario.spec import Deviation, Landmark, Light, MountedSensor, Obstacle, Pose, Recording, Robot, Scenario
from amorsim.scenario.toml.layout import MISSING, Path_, found_at

__all__ = ["component_at", "field_at"]

_TIMING = ("rate", "latency")
_COMPONENTS = {"drive": "drive", "controller": "controller", "motion": "motion"}


class _At(NamedTuple):
    """A class whose fields are the keys of a table, and the rest of the path in it."""

    cls: type
    rest: Path_
    unit: str = ""
    names: tuple[str, ...] | None = None  # of the fields that count
    default: Any = None  # where there is no table: the component that it is by default,
    use: str = ""  # and the name of its class


def field_at(values: Mapping[str, Any], path: Path_, registry: Registry, folder: Path) -> Parameter | None:
    """The parameter at a path in tables that models were merged into; None if there is none.

    Parameters
    ----------
    folder
        Where the map's path starts, by whose extension its loader is known.
    """
    if len(path) > 2 and path[2] == "errors":
        name = path[-1]
        if not isinstance(name, str) or _leads_nowhere(values, (*path[:2], *path[3:-1]), registry, folder):
            return None
        return file_fields(Deviation).get(name)
    at = _innermost(values, path, registry, folder)
    if at is None or not at.rest or not isinstance(at.rest[0], str):
        return None
    found = file_fields(at.cls, at.unit, at.names).get(at.rest[0])
    if at.default is not None:
        if at.rest == ("use",):
            return Parameter(name="use", type=str, default=at.use)
        found = None if found is None else attrs.evolve(found, default=getattr(at.default, found.name))
    for part in at.rest[1:]:
        if found is None:
            return None
        if isinstance(part, str):
            inner = _class_in(found.type)
            found = None if inner is None else file_fields(inner).get(part)
    return found


def _leads_nowhere(values: Mapping[str, Any], path: Path_, registry: Registry, folder: Path) -> bool:
    """Whether a path that should lead to a number of a robot names a sensor or a field that is not there."""
    if path[2:3] == ("sensors",) and found_at(values, path[:4]) is MISSING:
        return True
    at = _at(values, path, registry, folder)
    return at is not None and bool(at.rest) and at.rest[0] not in file_fields(at.cls, at.unit, at.names)


def component_at(values: Mapping[str, Any], path: Path_, registry: Registry, folder: Path) -> type | None:
    """The class of the component, or of another thing with fields, that the table at a path is for."""
    at = _innermost(values, (*path, "use"), registry, folder)
    return at.cls if at is not None and at.rest == ("use",) else None


def _innermost(values: Mapping[str, Any], path: Path_, registry: Registry, folder: Path) -> _At | None:
    """The component that `_at` finds, or the one within it that a field is, however deep."""
    at = _at(values, path, registry, folder)
    while at is not None and len(at.rest) > 1 and isinstance(at.rest[0], str):
        field = file_fields(at.cls, at.unit, at.names).get(at.rest[0])
        if field is None or not field.component:
            return at
        table = path[: len(path) - len(at.rest) + 1]
        if found_at(values, table) is not MISSING:
            at = _of_use(values, table, field.component, registry, at.rest[1:])
            continue
        default = field.default if at.default is None else getattr(at.default, field.name)
        name = registry.name_of(field.component, type(default))
        at = None if name is None else _At(type(default), at.rest[1:], default=default, use=name)
    return at


def _class_in(kind: Any) -> type | None:
    """The class of fields that a type has within it, as in ``tuple[Mount, ...]``."""
    if isinstance(kind, type) and attrs.has(kind):
        return kind
    return next((found for inner in typing.get_args(kind) if (found := _class_in(inner))), None)


def _at(values: Mapping[str, Any], path: Path_, registry: Registry, folder: Path) -> _At | None:
    match path:
        case ("simulation", *rest):
            return _At(Scenario, tuple(rest), names=("dt", "duration", "seed"))
        case ("recording", "also", int(), *rest):
            return _of_use(values, path[:3], "recorder", registry)
        case ("recording", *rest):
            return _At(Recording, tuple(rest), names=("sensors", "picture"))
        case ("task", *rest):
            return _of_use(values, ("task",), "task", registry, tuple(rest))
        case ("landmarks", int(), *rest):
            return _At(Landmark, tuple(rest))
        case ("lights", int(), *rest):
            return _At(Light, tuple(rest))
        case ("floor", "markings" | "drops" as kind, int(), *rest):
            if rest[:1] == ["pose"]:
                return _At(Pose, tuple(rest[1:]))
            return _At(Marking if kind == "markings" else Drop, tuple(rest))
        case ("floor", *rest):
            return _At(Floor, tuple(rest), names=("reflectance",))
        case ("world", "map", *rest):
            return _of_use(values, path[:2], "world_generator", registry, tuple(rest), key="generate")
        case ("world", *rest):
            return _of_map(values, ("world",), tuple(rest), registry, folder)
        case ("robots" | "obstacles" | "zones", int(), *rest):
            return _of_body(values, path[:2], tuple(rest), registry, folder)
    return None


def _of_body(values: Mapping[str, Any], body: Path_, rest: Path_, registry: Registry, folder: Path) -> _At | None:
    match rest:
        case ("pose", *inner):
            return _At(Pose, tuple(inner))
        case ("start", *inner):
            start = found_at(values, (*body, "start"))
            return _At(GridStart if isinstance(start, dict) and "grid" in start else RandomStart, tuple(inner))
        case ("drive" | "controller" | "motion" as part, *inner):
            return _of_use(values, (*body, part), _COMPONENTS[part], registry, tuple(inner))
        case ("estimators", name, *inner):
            return _of_use(values, (*body, "estimators", name), "estimator", registry, tuple(inner))
        case ("ground", int() as number, *inner):
            return _of_use(values, (*body, "ground", number), "noise", registry, tuple(inner), "m")
        case ("sensors", name, "mount", *inner):
            return _At(Mount, tuple(inner))
        case ("sensors", name, "rate" | "latency", *inner):
            return _At(MountedSensor, rest[2:], names=_TIMING)
        case ("sensors", name, "noise", int() as number, *inner):
            unit = _unit(values, (*body, "sensors", name), number, registry)
            return _of_use(values, (*body, "sensors", name, "noise", number), "noise", registry, tuple(inner), unit)
        case ("sensors", name, *inner):
            return _of_use(values, (*body, "sensors", name), "sensor", registry, tuple(inner))
        case ("initial_belief", *inner):
            return _At(InitialBelief, tuple(inner))
        case ("kidnappings", int(), *inner):
            return _At(Kidnapping, tuple(inner))
        case ("knowledge", "map", *inner) if isinstance(found_at(values, (*body, "knowledge", "map")), dict):
            known = (*body, "knowledge", "map")
            return _of_use(values, known, "world_generator", registry, tuple(inner), key="generate")
        case ("knowledge", *inner):
            return _of_map(values, (*body, "knowledge"), tuple(inner), registry, folder)
    if body[0] == "zones":
        return None
    return _At(Robot, rest, names=("on_collision", *LOOKS)) if body[0] == "robots" else _At(Obstacle, rest, names=LOOKS)


def _of_use(
    values: Mapping[str, Any],
    table: Path_,
    kind: str,
    registry: Registry,
    rest: Path_ = (),
    unit: str = "",
    key: str = "use",
) -> _At | None:
    use = found_at(values, (*table, key))
    if not isinstance(use, str) or use not in registry.names(kind):
        return None
    try:
        return _At(registry.get(kind, use), rest, unit)
    except PluginError:
        return None


def _unit(values: Mapping[str, Any], sensor: Path_, number: int, registry: Registry) -> str:
    """The unit of the values that an element of a sensor's chain is for."""
    found = _of_use(values, sensor, "sensor", registry)
    if found is None:
        return ""
    cls: Any = found.cls
    column = found_at(values, (*sensor, "noise", number, "column"))
    unit = getattr(cls, "unit", "")
    if column is not MISSING:
        try:
            unit = cls().columns().get(column, unit)
        except Exception:  # one that cannot be made without its fields
            return ""
    return unit if isinstance(unit, str) else ""


def _of_map(values: Mapping[str, Any], table: Path_, rest: Path_, registry: Registry, folder: Path) -> _At | None:
    written = found_at(values, table)
    name = written.get("map") if isinstance(written, dict) else None
    if not isinstance(name, str):
        return None
    use = written.get("use")
    try:
        _, cls = find_loader(folder / name, use if isinstance(use, str) else None, registry)
    except (MapError, PluginError):
        return None
    return _At(cls, rest)
