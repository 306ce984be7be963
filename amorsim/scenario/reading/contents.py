"""The content of a scenario's tables: completed from models, read and checked."""

from __future__ import annotations

import functools
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import attrs

from amorsim.core.errors import MapError, did_you_mean
from amorsim.core.maps.map import Map
from amorsim.plugins.registry import Registry
from amorsim.scenario.files.models import check_format, drop_removed, merge_models
from amorsim.scenario.reading.components import read_recording, read_task
from amorsim.scenario.reading.faults import FaultCollector, Node, Source
from amorsim.scenario.reading.fields import file_fields, read_component, read_fields
from amorsim.scenario.reading.floor_file import read_floor
from amorsim.scenario.reading.read_once import read_alike
from amorsim.scenario.reading.robots import read_obstacle, read_robot, read_zone
from amorsim.scenario.reading.starts import MOST, Placed, check_starts, placed, read_series, series_names
from amorsim.scenario.reading.worlds import Maps, start_of
from amorsim.scenario.spec import Landmark, Light, Obstacle, Robot, Scenario
from amorsim.scenario.toml.parse import Written
from amorsim.worlds.drawn import origin_of

__all__ = ["book_of", "read_top", "read_values"]

_KEYS = (
    *("format", "description", "world", "simulation", "recording", "task"),
    *("robots", "obstacles", "landmarks", "lights", "zones", "floor"),
)
_TIMES = ("dt", "duration", "seed")


def book_of(written: Written, path: Path) -> FaultCollector:
    """A book for a file's content, with the faults of its lines that are not TOML."""
    book = FaultCollector(Source(file=str(path), folder=path.parent))
    book.has_lost_lines = bool(written.bad)
    for fault in written.faults(str(path)):
        book.add(fault)
    return book


def read_values(
    document: dict[str, Any],
    book: FaultCollector,
    registry: Registry,
    maps: Maps,
    starts: bool,
    is_map_alone: bool,
) -> dict[str, Any]:
    """The arguments of a `Scenario`; usable if there is no fault in the book afterwards."""
    book.document = document
    if problem := _not_a_scenario(document):
        Node(document, (), book).fault(problem)
        return {}
    merge_models(document, book, registry)
    return read_top(Node(document, (), book), registry, maps, starts, is_map_alone)


_OTHERS = {"metrics": "a study runs with `amorsim sweep`", "criteria": "a rubric is for `amorsim grade`"}


def _not_a_scenario(document: Mapping[str, Any]) -> str:
    """The message for a file whose tables are not a scenario's, however misspelt; empty for a scenario."""
    others = [str(key) for key in document if key not in _KEYS]
    if len(others) < 2 or set(_KEYS[2:]) & set(document) or any(did_you_mean(key, _KEYS) for key in others):
        return ""
    keys = ", ".join([str(key)[:40] for key in document][:12])
    other = next((f"; {hint}" for key, hint in _OTHERS.items() if key in document), "")
    return f"not a scenario: expected [world] and [[robots]], got the keys {keys}{other}"


def read_top(top: Node, registry: Registry, maps: Maps, starts: bool, is_map_alone: bool) -> dict[str, Any]:
    """The arguments of a `Scenario`, from the whole table, into which models were merged."""
    check_format(top.child("format"))
    top.refuse_unknown(_KEYS, {"map": "[world]"} | dict.fromkeys(_TIMES, "[simulation]"))
    if "description" in top:
        top.child("description").text("a text")
    values: dict[str, Any] = {}
    world = None
    if "world" in top:
        world = maps.read(top.child("world"))
        if world is not None:
            top.book.warnings = tuple(f"{world.name}: {warning}" for warning in world.warnings)
    else:
        top.child("world").fault("missing; expected [world] with map = the path of a map file")
    if "simulation" in top and (node := top.child("simulation")).expect_table():
        fields = file_fields(Scenario, names=_TIMES)
        node.refuse_unknown(fields)
        values.update(read_fields(node, fields))
    if "recording" in top:
        values["recording"] = read_recording(top.child("recording"), registry)
    if "task" in top:
        values["task"] = read_task(top.child("task"), registry)
    for key, kind in (("landmarks", Landmark), ("lights", Light)):
        things = top.child(key)
        if things.value is not None and things.expect_list(f"a list of tables, [[{key}]]"):
            values[key] = [thing for thing in (read_component(kind, item) for item in things.items()) if thing]

    zones = top.child("zones")
    if zones.value is not None and zones.expect_list("a list of tables, [[zones]]"):
        read_zones = [read_zone(node, number, registry) for number, node in enumerate(zones.items(), start=1)]
        values["zones"] = [zone for zone in read_zones if zone]
    _check_names({}, zones)
    if "floor" in top and (floor := read_floor(top.child("floor"))) is not None:
        values["floor"] = floor
    marks = values.get("landmarks", ())
    robots, obstacles, stand = _read_bodies(top, maps, world, registry, marks, is_map_alone)
    if starts and world is not None:
        check_starts(world, stand)
    values.update(map=world, robots=robots, obstacles=obstacles)
    return values


def _read_bodies(
    top: Node,
    maps: Maps,
    world: Map | None,
    registry: Registry,
    marks: Sequence[Landmark],
    is_map_alone: bool,
) -> tuple[list[Robot], list[Obstacle], list[Placed]]:
    """The robots and obstacles of a document, those of a table with `count` one by one, and where they stand."""
    robots, obstacles = top.child("robots"), top.child("obstacles")
    fleet: list[Robot] = []
    others: list[Obstacle] = []
    stand: list[Placed] = []
    names: dict[tuple[str, ...], list[str]] = {}
    if robots.value is None or robots.value == []:
        robots.fault("missing; expected one robot at least, [[robots]] with name, model and controller")
    elif robots.expect_list("a list of tables, [[robots]]"):
        for node in robots.items():
            drop_removed(node.value)
            robot = read_alike(node, lambda node: read_robot(node, maps, world, registry, marks))
            if robot is not None and world is not None and not {"pose", "start"} & set(node.value):
                robot = _put(node, robot, world, is_map_alone)
            series = read_series(node, robot, world)
            fleet += series
            names[node.path] = [one.name for one in series]
            stand += placed(node, series) if node.is_table else []
    if obstacles.value is not None and obstacles.expect_list("a list of tables, [[obstacles]]"):
        for number, node in enumerate(obstacles.items(), start=1):
            obstacle = read_alike(node, functools.partial(read_obstacle, number=number, registry=registry))
            bodies = read_series(node, obstacle, world)
            others += bodies
            names[node.path] = [one.name for one in bodies]
            stand += placed(node, bodies) if node.is_table else []
    _check_names(names, robots, obstacles)
    return fleet, others, stand


def _check_names(names: Mapping[tuple[str, ...], list[str]], *lists: Node) -> None:
    """A fault for everything in these lists that is called as something before it.

    `names` are those of what was read, by the table's path; of others the name may be all that could be read.
    """
    seen: dict[str, str] = {}
    for group in lists:
        for node in group.items() if isinstance(group.value, list) else ():
            for name in names.get(node.path) or _said_names(node):
                if name in seen:
                    node.child("name").fault(f"{seen[name]} is called {name!r} too; names must differ")
                    break
                seen[name] = ".".join(node.path)


def _said_names(node: Node) -> list[str]:
    """The names of the bodies of a faulty table, as far as they can be read."""
    name = node.value.get("name") if node.is_table else None
    if not isinstance(name, str):
        return []
    count = node.value.get("count")
    if count is None:
        return [name]
    return series_names(name, count) if type(count) is int and 1 <= count <= MOST else []


def _put(node: Node, robot: Robot, world: Map, is_map_alone: bool) -> Robot | None:
    """A robot without a pose, at the place that the map has for it; for a map alone elsewhere if it does not fit there.

    Where replicas have different maps it is put there when a simulation is made.
    """
    if origin_of(world) is not None:
        return robot
    try:
        start = start_of(world, robot, must_be_free=is_map_alone)
    except MapError as error:
        node.child("pose").fault(f"missing, and {error}")
        return None
    return attrs.evolve(robot, pose=start)
