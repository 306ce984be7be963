"""Scenarios from files: read, completed from models and defaults, checked; all faults are reported at once.

What a scenario's own words tell is checked here, also whether bodies start in free places. Starts that are drawn, and
true poses that differ from the nominal ones, are known to `amorsim.Simulation` only, which reports in the same form.
"""

from __future__ import annotations

import copy
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import attrs

from amorsim.core.errors import Fault, MapError, ScenarioError, did_you_mean
from amorsim.core.map import Map
from amorsim.core.parameters import ParameterError
from amorsim.core.reading import is_file
from amorsim.plugins.manager import default_registry
from amorsim.plugins.registry import Registry
from amorsim.scenario.components import read_recording
from amorsim.scenario.faults import Book, Node, Source
from amorsim.scenario.fields import file_fields, read_component, read_fields
from amorsim.scenario.floor_file import read_floor
from amorsim.scenario.models import FORMAT, check_format, drop_removed, merge_models, read_file, read_toml
from amorsim.scenario.overrides import apply_overrides, parse_overrides
from amorsim.scenario.resolved import resolved_table
from amorsim.scenario.robots import read_obstacle, read_robot, read_zone
from amorsim.scenario.spec import Landmark, Light, Obstacle, Robot, Scenario
from amorsim.scenario.starts import Placed, check_starts, placed, read_series
from amorsim.scenario.worlds import Maps, start_of
from amorsim.scenario.written import Written

__all__ = [
    "check_words",
    "is_model",
    "load",
    "loads",
    "read_generated_alone",
    "read_map_alone",
    "scenario_for_map",
    "scenario_for_model",
]

_KEYS = (
    *("format", "description", "world", "simulation", "recording"),
    *("robots", "obstacles", "landmarks", "lights", "zones", "floor"),
)
_TIMES = ("dt", "duration", "seed")
_MODEL = {"drive", "shape"}


def load(source: str | Path, overrides: Iterable[str] = (), *, registry: Registry | None = None) -> Scenario:
    """The scenario in a file, or the bundled one of that name.

    Parameters
    ----------
    source
        Path of a ``.toml`` file, or the name of a registered scenario such as ``"demo"``.
    overrides
        Settings as of the command line: ``"robots.rover.controller.speed=0.2"``.

    Raises
    ------
    ScenarioError
        With all the faults that were found, each with file, key path, and what would be right.
    """
    registry = registry or default_registry()
    path, book, table = _find(source, registry)
    return _read(table, book, overrides, registry, path)


def _find(source: str | Path, registry: Registry) -> tuple[Path, Book, dict[str, Any]]:
    """The file that is meant by a path or by the name of a registered scenario, and the table in it.

    The book has the faults of lines that are no TOML. Nothing in the table has been looked at.

    Raises
    ------
    ScenarioError
        If there is no such file, or it is no text.
    """
    path = Path(source)
    names = registry.names("scenario")
    if str(source) in names and not is_file(path):
        path = registry.file("scenario", str(source))
    written = read_file(path)
    if isinstance(written, str):
        hint = did_you_mean(str(source), names)
        if not path.suffix:
            written += f"; bundled scenarios: {', '.join(names) or 'none'}.{hint}"
        raise ScenarioError([Fault(file=str(source), path="", message=written)])
    return path, book_of(written, path), written.values


def book_of(written: Written, path: Path) -> Book:
    """A book for what a file says, with the faults of its lines that are no TOML."""
    book = Book(Source(file=str(path), folder=path.parent))
    book.has_lost_lines = bool(written.bad)
    for fault in written.faults(str(path)):
        book.add(fault)
    return book


def loads(
    document: Mapping[str, Any],
    folder: str | Path,
    overrides: Iterable[str] = (),
    *,
    name: str = "",
    registry: Registry | None = None,
    starts: bool = False,
) -> Scenario:
    """The scenario in a document such as `tomllib` gives; relative paths in it start at `folder`.

    `name` stands for the file in faults; what is raised is as for `load`, but for starts that are not free: with
    `starts` only. A simulation refuses them in any case.
    """
    origin = Source(file=name, folder=Path(folder))
    book = Book(origin)
    return _read(copy.deepcopy(dict(document)), book, overrides, registry or default_registry(), starts=starts)


def scenario_for_map(
    path: str | Path, overrides: Iterable[str] = (), *, registry: Registry | None = None, **options: Any
) -> Scenario:
    """A Pioneer 2DX, "rover", that wanders for a minute on a map from its start or its freest place.

    `options` are the map loader's, spelt as in a file: ``resolution=0.05``, ``origin_yaw_deg=90``. What is
    raised is as for `load`.
    """
    origin = Source(file="", folder=Path(path).parent)
    document = _map_alone(Path(path), options)
    return _read(document, Book(origin), overrides, registry or default_registry(), is_map_alone=True)


def read_map_alone(
    path: str | Path, overrides: Iterable[str] = (), *, registry: Registry | None = None, **options: Any
) -> Map:
    """The map in a file, with no robot in it; `overrides` name its options as those of a scenario's world do.

    `options` and what is raised are as for `scenario_for_map`.
    """
    path = Path(path)
    document = {"world": {**options, "map": str(path.absolute())}}
    book = Book(Source(file="", folder=path.parent))
    book.document = document
    apply_overrides(document, parse_overrides(overrides, book), book)
    top = Node(document, (), book)
    top.refuse_unknown(("world",))
    world = Maps(registry or default_registry()).read(top.child("world"))
    book.raise_if_any()
    assert world is not None  # or there would be a fault
    return world


def read_generated_alone(
    kind: str, seed: int, overrides: Iterable[str] = (), *, registry: Registry | None = None, is_made: bool = True
) -> Map | None:
    """A generated world with no robot in it; `overrides` name the generator's fields.

    Unless `is_made`, the words alone are looked at, and there is no map.

    Raises
    ------
    ScenarioError
        With all faults of these words, or what is wrong with the world.
    """
    made = {"generate": kind, "seed": seed}
    book = Book(Source(file="", folder=Path()))
    book.document = made
    apply_overrides(made, parse_overrides(overrides, book), book)
    world = Maps(registry or default_registry(), are_read=is_made).generated(Node(made, (), book))
    book.raise_if_any()
    return world


def _map_alone(path: Path, options: Mapping[str, Any]) -> dict[str, Any]:
    return {
        "format": FORMAT,
        "world": {**options, "map": str(path.absolute())},
        "simulation": {"duration": 60.0},
        "robots": [{"name": "rover", "model": "pioneer2dx", "controller": {"use": "wander"}}],
    }


def check_words(
    source: str | Path,
    overrides: Iterable[str] = (),
    *,
    of_map: Mapping[str, Any] | None = None,
    registry: Registry | None = None,
) -> None:
    """Raise the faults of a scenario's own words: of all that `load` would find, but for what the maps hold.

    No map is read, so that nothing is compiled for it: who has just installed waits for that, and hears this before.
    Nothing of a user's runs: of controllers and motions in files, the text is checked.

    Parameters
    ----------
    source, overrides
        As for `load`.
    of_map
        The options of the map that `source` is, for what `scenario_for_map` reads.

    Raises
    ------
    ScenarioError
        With all these faults.
    """
    registry = registry or default_registry()
    path = Path(source)
    if of_map is None:
        path, book, table = _find(source, registry)
    else:
        table, book = _map_alone(path, of_map), Book(Source(file="", folder=path.parent))
    book.runs_programs = False
    read_values(table, book, overrides, registry, Maps(registry, are_read=False), False, False)
    book.raise_if_any()


def is_model(path: str | Path) -> bool:
    """Whether a file holds a robot's model: it has a drive or a shape, and neither world nor robots."""
    document = read_toml(Path(path)) if is_file(path) else ""
    return isinstance(document, dict) and not {"world", "robots"} & set(document) and bool(_MODEL & set(document))


def scenario_for_model(
    path: str | Path, overrides: Iterable[str] = (), *, registry: Registry | None = None
) -> Scenario:
    """The robot of a model's file, "robot", in the hall of a bundled scenario, to see whether it is whole.

    What is raised is as for `load`.
    """
    path = Path(path)
    registry = registry or default_registry()
    document = {
        "format": FORMAT,
        "world": {"map": str(registry.file("scenario", "synchro-hall").with_name("hall.wld"))},
        "robots": [{"name": "robot", "model": path.name}],
    }
    return _read(document, Book(Source(file=str(path), folder=path.parent)), overrides, registry)


def _read(
    document: dict[str, Any],
    book: Book,
    overrides: Iterable[str],
    registry: Registry,
    file: Path | None = None,
    starts: bool = True,
    is_map_alone: bool = False,
) -> Scenario:
    values = read_values(document, book, overrides, registry, Maps(registry), starts, is_map_alone)
    book.raise_if_any()
    try:
        scenario = Scenario(**values, source=file)
    except ParameterError as error:
        book.fault((error.name,), error.problem)
        book.raise_if_any()
        raise
    return attrs.evolve(scenario, resolved=resolved_table(scenario, registry=registry))


def read_values(
    document: dict[str, Any],
    book: Book,
    overrides: Iterable[str],
    registry: Registry,
    maps: Maps,
    starts: bool,
    is_map_alone: bool,
) -> dict[str, Any]:
    """What a `Scenario` is made with, as far as there is no fault in the book afterwards."""
    book.document = document
    settings = parse_overrides(overrides, book)
    apply_overrides(document, [setting for setting in settings if setting.chooses_model], book)
    merge_models(document, book, registry)
    apply_overrides(document, [setting for setting in settings if not setting.chooses_model], book)
    return read_top(Node(document, (), book), registry, maps, starts, is_map_alone)


def read_top(top: Node, registry: Registry, maps: Maps, starts: bool, is_map_alone: bool) -> dict[str, Any]:
    """What a `Scenario` is made with, of the whole table, into which models were merged."""
    check_format(top.child("format"))
    top.refuse_unknown(_KEYS)
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
            robot = read_robot(node, maps, world, registry, marks)
            if robot is not None and world is not None and not {"pose", "start"} & set(node.value):
                robot = _put(node, robot, world, is_map_alone)
            series = [] if robot is None else read_series(node, robot, world)
            fleet += series
            names[node.path] = [one.name for one in series]
            stand += placed(node, series) if node.is_table else []
    if obstacles.value is not None and obstacles.expect_list("a list of tables, [[obstacles]]"):
        for number, node in enumerate(obstacles.items(), start=1):
            obstacle = read_obstacle(node, number, registry)
            bodies = [] if obstacle is None else read_series(node, obstacle, world)
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
            name = node.value.get("name") if node.is_table else None
            own = [name] if isinstance(name, str) and "count" not in node else []
            for name in names.get(node.path) or own:
                if name in seen:
                    node.child("name").fault(f"{seen[name]} is called {name!r} too; names must differ")
                    break
                seen[name] = ".".join(node.path)


def _put(node: Node, robot: Robot, world: Map, is_map_alone: bool) -> Robot | None:
    """A robot without a pose, put where the map wants it; for a map alone elsewhere if there is no room for it."""
    try:
        start = start_of(world, robot, must_be_free=is_map_alone)
    except MapError as error:
        node.child("pose").fault(f"missing, and {error}")
        return None
    return attrs.evolve(robot, pose=start)
