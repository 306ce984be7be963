"""The readable part of a scenario that has faults, so that it can be shown."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import attrs

from amorsim.core.errors import Fault
from amorsim.core.maps.map import Map
from amorsim.core.parameters import describe
from amorsim.core.shapes import Shape
from amorsim.plugins.registry import Registry
from amorsim.scenario.floor import Floor
from amorsim.scenario.reading.bodies import read_pose, read_shape
from amorsim.scenario.reading.contents import read_top
from amorsim.scenario.reading.faults import FaultCollector, Node, Path_
from amorsim.scenario.reading.worlds import Maps
from amorsim.scenario.spec import Landmark, Light, Obstacle, Pose, Recording, Robot, Scenario, Zone

__all__ = ["Outline", "Partial", "read_partial", "whole_of"]

# Of a robot, each of these is a part that it can be shown without; a sensor or an estimator too.
_NAMED = ("sensors", "estimators")
_NEEDED = ("shape", "drive", "pose", "start", "count")


@attrs.frozen(kw_only=True)
class Outline:
    """The outline of a robot or an obstacle that cannot be read further; it stands at `pose`."""

    name: str
    shape: Shape
    pose: Pose


@attrs.frozen(kw_only=True)
class Partial:
    """The readable part of a scenario, as `Scenario` has it; faulty parts are missing, or have their defaults.

    A robot is there without the sensors, estimators, controller and errors that are at fault. Of a body whose drive or
    other needed part cannot be read, there is an `Outline`, if its shape and pose can. `map` is None where none can be
    read, and a robot without a pose has none then.
    """

    faults: tuple[Fault, ...]
    map: Map | None = None
    robots: tuple[Robot, ...] = ()
    obstacles: tuple[Obstacle, ...] = ()
    landmarks: tuple[Landmark, ...] = ()
    lights: tuple[Light, ...] = ()
    zones: tuple[Zone, ...] = ()
    floor: Floor = attrs.field(factory=Floor)
    dt: float = describe(Scenario)["dt"].default
    duration: float = describe(Scenario)["duration"].default
    seed: int = describe(Scenario)["seed"].default
    recording: Recording = attrs.field(factory=Recording)
    outlines: tuple[Outline, ...] = ()


def read_partial(
    tables: dict[str, Any], book: FaultCollector, registry: Registry, maps: Maps, faults: Iterable[Fault]
) -> Partial:
    """The readable part of tables that models were merged into; `book` has their origins.

    What is at fault is taken out of the tables.
    """
    whole: set[Path_] = set()  # the bodies with nothing but an outline left
    is_left_out = True
    while is_left_out:  # a part less each time
        silent = book.again(tables)
        # Copies of robots, from which reading leaves out what is false.
        robots = tables.get("robots")
        copies = [dict(one) if isinstance(one, dict) else one for one in robots] if isinstance(robots, list) else robots
        values = read_top(Node({**tables, "robots": copies}, (), silent), registry, maps, False, False)
        parts = {part for path in silent.places if (part := _part(path, whole))}
        is_left_out = sum(_leave_out(tables, part) for part in sorted(parts)) > 0
    return _partial(values, faults, [outline for path in sorted(whole) if (outline := _outline(tables, path))])


def whole_of(values: dict[str, Any]) -> Partial:
    """The partial scenario of one without faults, from the result of `read_top`."""
    return _partial(values, (), ())


def _partial(values: dict[str, Any], faults: Iterable[Fault], outlines: Iterable[Outline]) -> Partial:
    known = attrs.fields_dict(Partial)
    found = {name: value for name, value in values.items() if name in known and value is not None}
    found = {name: tuple(value) if isinstance(value, list) else value for name, value in found.items()}
    return Partial(**found, faults=tuple(faults), outlines=tuple(outlines))


def _part(path: Path_, whole: set[Path_]) -> Path_:
    """The part to leave out for a fault at a path; empty where reading leaves it out by itself."""
    kind = path[0]
    if kind in ("world", "landmarks", "lights", "zones"):
        return ()
    if kind not in ("robots", "obstacles") or len(path) == 1:
        return path[:2]
    part = path[2] if len(path) > 2 else ""
    if part in ("", *_NEEDED) or path[:2] in whole:
        whole.add(path[:2])
        return ()
    return path[:4] if part in _NAMED else path[:3]


def _leave_out(tables: dict[str, Any], path: Path_) -> bool:
    """Take a part out of the tables; whether it was there. A name gives way to another."""
    *before, last = path
    holder: Any = tables
    for part in before:
        holder = holder[int(part)] if isinstance(holder, list) else holder.get(part)
        if not isinstance(holder, (dict, list)):
            return False
    if not isinstance(holder, dict) or last not in holder:
        return False
    other = "-".join(path[:2]) if last == "name" else None
    if holder[last] == other:
        return False
    del holder[last]
    if other:
        holder["name"] = other
    return True


def _outline(tables: dict[str, Any], path: Path_) -> Outline | None:
    thing = tables[path[0]][int(path[1])]
    if not isinstance(thing, dict) or not {"shape", "pose"} <= set(thing):
        return None
    silent = FaultCollector.silent()
    shape, pose = read_shape(Node(thing["shape"], (), silent)), read_pose(Node(thing["pose"], (), silent))
    name = thing.get("name")
    if shape is None or pose is None:
        return None
    return Outline(name=name if isinstance(name, str) else "-".join(path), shape=shape, pose=pose)
