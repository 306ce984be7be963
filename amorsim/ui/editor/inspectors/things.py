"""The things of a scenario, as a list and as the canvas finds them: robots, obstacles, zones, landmarks, lights."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import PurePath
from typing import Any, TypedDict

from amorsim.core.poses import Mount
from amorsim.core.shapes import Shape
from amorsim.plugins.registry import Registry
from amorsim.scenario.documents.document import Document
from amorsim.scenario.reading.partial import Partial
from amorsim.scenario.spec import MountedSensor, Obstacle, Pose, Robot
from amorsim.ui.editor.inspectors.points import Place, places_at
from amorsim.ui.editor.inspectors.sections import SHAPES
from amorsim.ui.scene.bodies import outline_of
from amorsim.ui.scene.wire import Outline

__all__ = ["MountAt", "Thing", "things_of"]

_NAMED = {"robots": "robot", "obstacles": "obstacle", "zones": "zone", "landmarks": "landmark", "lights": "light"}


class MountAt(TypedDict):
    """Where a sensor sits on its robot: x, y [m] and heading [rad]; and what it sees, where the file can hold that.

    `range_max` [m] is how far it sees, `opening` [rad] the angle between the edges of what it sees. `key` is the key
    of the file that holds the opening or a half of it, ``"fov_deg"`` or ``"half_angle_deg"``.
    """

    sensor: str
    pose: list[float]
    range_max: float | None
    opening: float | None
    key: str


class Thing(TypedDict):
    """A thing of a scenario: a table of its file.

    `footprint` and `pose` (x, y [m], heading [rad]) are there if it stands in one place that can be read; `moves` is
    whether the file can hold it. `robots` and `obstacles` are its places in the scene; `places` are points of it
    that lie elsewhere in the world.
    """

    path: str
    kind: str  # "robot", "obstacle", "zone", "landmark", "light", or of what has no place "settings"
    name: str
    note: str
    footprint: Outline | None
    shape: str  # the kind of the shape that the file gives it: "circle", "rectangle", "polygon", or ""
    pose: list[float] | None
    moves: bool
    turns: bool
    robots: list[int]
    obstacles: list[int]
    places: list[Place]
    mounts: list[MountAt]
    faults: int


def things_of(document: Document, partial: Partial, registry: Registry) -> list[Thing]:
    """The things in a scenario's own tables, with as much of them as could be read."""
    values, folder = document.values, document.path.absolute().parent
    found = [_thing("simulation", "settings", "simulation", "time, seed"), _thing("world", "settings", "world", "map")]
    world = values.get("world")
    if isinstance(world, dict) and isinstance(world.get("map"), str):
        found[1]["note"] = PurePath(world["map"]).name
    elif isinstance(world, dict) and isinstance(world.get("map"), dict):
        found[1]["note"] = f"generated: {world['map'].get('generate', '?')}"
    robots = list(enumerate(partial.robots))
    order = sorted(range(len(partial.obstacles)), key=lambda number: partial.obstacles[number].name)
    place_of = {number: place for place, number in enumerate(order)}
    obstacles = [(place_of[number], one) for number, one in enumerate(partial.obstacles)]
    outlines = {outline.name: outline for outline in partial.outlines}
    for number, table in _tables(values, "robots"):
        thing = _body("robots", number, table, robots, outlines, "robot")
        thing["note"] = _both(str(table.get("model", "")), thing["note"])
        found.append(thing)
    for number, table in _tables(values, "obstacles"):
        default = f"obstacle{number + 1}_" if "count" in table else f"obstacle{number + 1}"
        thing = _body("obstacles", number, table, obstacles, outlines, default)
        motion = table.get("motion")
        moves = str(motion.get("use", "")) if isinstance(motion, dict) else "stands still"
        thing["note"] = _both(moves, thing["note"])
        found.append(thing)
    zones = list(enumerate(partial.zones))
    for number, table in _tables(values, "zones"):
        thing = _thing(f"zones.{number}", "zone", _name(table, f"zone{number + 1}"), "ground")
        for place, zone in zones:
            if zone.name == thing["name"]:
                thing |= {
                    "footprint": outline_of(zone.shape),
                    "pose": _numbers(zone.pose),
                    "moves": True,
                    "turns": True,
                }
                zones.remove((place, zone))
                break
        found.append(thing)
    for key in ("landmarks", "lights"):
        read: Sequence[Any] = getattr(partial, key)
        tables = _tables(values, key)
        for number, table in tables:
            name = f"landmark {table.get('id', '?')}" if key == "landmarks" else f"light {number + 1}"
            thing = _thing(f"{key}.{number}", _NAMED[key], name, "")
            if len(read) == len(tables):  # else one of them cannot be read, and nobody knows which
                one = read[number]
                shape = Shape.circle(max(getattr(one, "radius", 0.1), 0.01))
                thing |= {"footprint": outline_of(shape), "pose": [one.x, one.y, 0.0], "moves": True}
            found.append(thing)
    found.insert(2, _thing("recording", "settings", "recording", "what a run writes"))
    found.insert(3, _thing("floor", "settings", "floor", "lines, areas, drops"))
    task = values.get("task")
    learned = str(task.get("use", "?")) if isinstance(task, dict) else "what a policy learns"
    found.insert(4, _thing("task", "settings", "task", learned))
    counts = Counter(before for fault in partial.faults for before in _starts_of(fault.path))
    for thing in found:
        if thing["kind"] in ("robot", "obstacle") or thing["path"] == "floor":
            thing["places"] = places_at(values, thing["path"], registry, folder)
        thing["faults"] = counts[thing["path"]]
        key, _, place_in_list = thing["path"].partition(".")
        if place_in_list and thing["footprint"] is not None:
            thing["shape"] = _shape(dict(_tables(values, key))[int(place_in_list)])
    return found


def _starts_of(path: str) -> list[str]:
    """The paths of the table and of the item in a list of tables that a path may lead into: ``a`` and ``a.b``."""
    parts = path.split(".")
    return [".".join(parts[:count]) for count in (1, 2) if count <= len(parts)]


def _both(*notes: str) -> str:
    return ", ".join(note for note in notes if note)


def _thing(path: str, kind: str, name: str, note: str) -> Thing:
    return {
        "path": path,
        "kind": kind,
        "name": name,
        "note": note,
        "footprint": None,
        "shape": "",
        "pose": None,
        "moves": False,
        "turns": False,
        "robots": [],
        "obstacles": [],
        "places": [],
        "mounts": [],
        "faults": 0,
    }


def _tables(values: Mapping[str, Any], key: str) -> list[tuple[int, dict[str, Any]]]:
    """The tables of a list; an item that is not a table counts as an empty one."""
    items = values.get(key)
    found = items if isinstance(items, list) else []
    return [(number, item if isinstance(item, dict) else {}) for number, item in enumerate(found)]


def _name(table: Mapping[str, Any], default: str) -> str:
    name = table.get("name")
    return name if isinstance(name, str) else default


def _body(
    key: str,
    number: int,
    table: Mapping[str, Any],
    bodies: list[tuple[int, Any]],
    outlines: Mapping[str, Any],
    default: str,
) -> Thing:
    """A robot or an obstacle, or many of one table; `bodies` are those not yet assigned to a table."""
    thing = _thing(f"{key}.{number}", _NAMED[key], _name(table, default), "")
    name = thing["name"]
    is_series = "count" in table or "start" in table
    if is_series:
        own = [(place, body) for place, body in bodies if body.name == name or _is_of(body.name, name)]
    else:  # which is mostly the first of them, for tables and bodies have the same order
        first = next((one for one in bodies if one[1].name == name), None)
        own = [] if first is None else [first]
    for one in own:
        bodies.remove(one)
    places = [place for place, _ in own]
    if key == "robots":
        thing["robots"] = places
    else:
        thing["obstacles"] = places
    if is_series:
        start = table.get("start")
        is_drawn = isinstance(start, dict) and "random" in start
        thing["note"] = f"{len(own)} of them" + (", placed by the run" if is_drawn else "")
        return thing
    outline = outlines.get(name)
    body: Robot | Obstacle | None = own[0][1] if own else None
    shape = body.shape if body is not None else None if outline is None else outline.shape
    pose = body.pose if body is not None else None if outline is None else outline.pose
    if shape is not None:
        thing["footprint"] = outline_of(shape)
    if pose is not None:
        thing["pose"] = _numbers(pose)
    if isinstance(body, Robot):
        thing["mounts"] = [_mount(key, one) for key, one in body.sensors.items()]
    written = table.get("pose", {})
    thing["moves"] = thing["turns"] = isinstance(written, dict)
    return thing


def _shape(table: Mapping[str, Any]) -> str:
    """The kind of the one shape that a table gives."""
    shape = table.get("shape")
    kinds = [kind for kind in SHAPES if kind in shape] if isinstance(shape, dict) else []
    return kinds[0] if len(kinds) == 1 else ""


_OPENINGS = {"fov": 1.0, "half_angle": 2.0}  # fields of sensors, and how often each is in the opening


def _mount(name: str, mounted: MountedSensor) -> MountAt:
    sensor = mounted.sensor
    key = next((key for key in _OPENINGS if isinstance(getattr(sensor, key, None), float)), "")
    far = getattr(sensor, "range_max", None)
    return {
        "sensor": name,
        "pose": _numbers(mounted.mount),
        "range_max": far if isinstance(far, float) and math.isfinite(far) else None,
        "opening": _OPENINGS[key] * getattr(sensor, key) if key else None,
        "key": f"{key}_deg" if key else "",
    }


def _is_of(name: str, stem: str) -> bool:
    return name.startswith(stem) and name[len(stem) :].isdigit()


def _numbers(pose: Pose | Mount) -> list[float]:
    return [pose.x, pose.y, pose.heading]
