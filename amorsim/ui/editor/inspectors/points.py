"""Points in the world other than poses of things: paths, goals, and areas of random starts."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, TypedDict

from amorsim.core.numbers import is_number
from amorsim.plugins.registry import Registry
from amorsim.scenario.documents.field_at import component_at
from amorsim.scenario.reading.fields import file_fields
from amorsim.scenario.toml.layout import found_at

__all__ = ["Place", "places_at"]

MOST = 2000  # points of one list


class Place(TypedDict):
    """Points that the file has at a path.

    `kind` is ``"path"`` for a list that may grow, ``"point"`` for one point, ``"box"`` for two opposite corners.
    """

    path: str
    kind: str
    points: list[list[float]]
    closed: bool


def places_at(values: Mapping[str, Any], path: str, registry: Registry, folder: Path) -> list[Place]:
    """The places of a robot, an obstacle or the floor at a path of a scenario's own tables."""
    at = tuple(int(part) if part.isdigit() else part for part in path.split("."))
    return list(_places(values, at, registry, folder))


def _places(values: Mapping[str, Any], at: tuple[str | int, ...], registry: Registry, folder: Path) -> Iterator[Place]:
    table = found_at(values, at)
    if not isinstance(table, dict):
        return
    if at == ("floor",):
        for number, marking in enumerate(_items(table.get("markings"))):
            yield from _fields(values, (*at, "markings", number), marking, registry, folder)
        for key in ("markings", "drops"):
            for number, one in enumerate(_items(table.get(key))):
                pose = one.get("pose") if isinstance(one, dict) else None
                if isinstance(pose, dict) and _is_length(pose.get("x")) and _is_length(pose.get("y")):
                    path = f"floor.{key}.{number}.pose"
                    yield {"path": path, "kind": "point", "points": [[pose["x"], pose["y"]]], "closed": False}
        return
    for part in ("controller", "motion"):
        inner = table.get(part)
        if isinstance(inner, dict):
            yield from _fields(values, (*at, part), inner, registry, folder)
    for part in ("sensors", "estimators"):
        parts = table.get(part)
        for name, inner in parts.items() if isinstance(parts, dict) else ():
            yield from _fields(values, (*at, part, name), inner, registry, folder)
    for number, one in enumerate(_items(table.get("kidnappings"))):
        yield from _fields(values, (*at, "kidnappings", number), one, registry, folder)
    yield from _known(table.get("knowledge"), ".".join(map(str, (*at, "knowledge"))))
    start = table.get("start")
    if isinstance(start, dict):
        yield from _start(start, ".".join(map(str, (*at, "start"))))


def _fields(
    values: Mapping[str, Any], at: tuple[str | int, ...], table: Any, registry: Registry, folder: Path
) -> Iterator[Place]:
    """Points in a component's fields that lie in the world."""
    if not isinstance(table, dict):
        return
    try:
        cls = component_at(values, at, registry, folder)
        fields = {} if cls is None else file_fields(cls)
    except Exception:  # what a plugin's class may raise; it has no places then
        return
    in_world = [name for name, parameter in fields.items() if parameter.frame == "world"]
    path = ".".join(map(str, at))
    is_closed = table.get("use") == "loop" or table.get("loop") is True or table.get("closed") is True
    if {"x", "y"} <= set(in_world) and _is_length(table.get("x")) and _is_length(table.get("y")):
        yield {"path": path, "kind": "point", "points": [[table["x"], table["y"]]], "closed": False}
    for name in in_world:
        found: Any = table.get(name)
        if _is_point(found):
            yield {"path": f"{path}.{name}", "kind": "point", "points": [list(found)], "closed": False}
        elif isinstance(found, list) and 0 < len(found) <= MOST and all(map(_is_point, found)):
            points = [list(point) for point in found]
            yield {"path": f"{path}.{name}", "kind": "path", "points": points, "closed": is_closed}
    for name, parameter in fields.items():
        if parameter.component:
            yield from _fields(values, (*at, name), table.get(name), registry, folder)


def _known(knowledge: Any, path: str) -> Iterator[Place]:
    """Landmarks that a robot knows by places of its own."""
    for number, one in enumerate(_items(knowledge.get("landmarks") if isinstance(knowledge, dict) else None)[:MOST]):
        point: Any = [one.get("x"), one.get("y")] if isinstance(one, dict) else one
        if _is_point(point):
            yield {"path": f"{path}.landmarks.{number}", "kind": "point", "points": [list(point)], "closed": False}


def _start(start: Mapping[str, Any], path: str) -> Iterator[Place]:
    box = start.get("random")
    if isinstance(box, list) and len(box) == 4 and all(map(_is_length, box)):
        yield {"path": f"{path}.random", "kind": "box", "points": [box[:2], box[2:]], "closed": False}
    if _is_point(start.get("grid")):
        yield {"path": f"{path}.grid", "kind": "point", "points": [list(start["grid"])], "closed": False}
    poses = start.get("poses")
    if isinstance(poses, list) and 0 < len(poses) <= MOST:
        for number, pose in enumerate(poses):
            if isinstance(pose, dict) and _is_length(pose.get("x")) and _is_length(pose.get("y")):
                yield {
                    "path": f"{path}.poses.{number}",
                    "kind": "point",
                    "points": [[pose["x"], pose["y"]]],
                    "closed": False,
                }


def _items(found: Any) -> list[Any]:
    return found if isinstance(found, list) else []


def _is_point(value: Any) -> bool:
    return isinstance(value, list) and len(value) == 2 and all(map(_is_length, value))


def _is_length(value: Any) -> bool:
    return is_number(value, below=1e6)
