"""Scenarios from files: read, completed from models and defaults, checked; all faults are reported at once.

The scenario's own words are checked here, also whether bodies start in free places. Starts that are drawn, and
true poses that differ from the nominal ones, are known to `amorsim.Simulation` only, which reports in the same form.
"""

from __future__ import annotations

import copy
import os
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Annotated, Any

import attrs

from amorsim.core.arguments import checked, path_of
from amorsim.core.errors import Fault, ScenarioError
from amorsim.core.files.reading import is_file
from amorsim.core.maps.map import Map
from amorsim.core.parameters import ParameterError
from amorsim.plugins.manager import default_registry
from amorsim.plugins.registry import Registry
from amorsim.scenario.documents.overrides import overridden
from amorsim.scenario.documents.settings import parse_settings, setting_texts
from amorsim.scenario.files.foreign import find_scenario_loader, read_foreign, split_options
from amorsim.scenario.files.mistaken import SCENARIO_PATH, mistaken
from amorsim.scenario.files.models import FORMAT, read_file, read_toml
from amorsim.scenario.files.other_files import map_alone
from amorsim.scenario.files.resolved import resolved_table
from amorsim.scenario.reading.contents import book_of, read_values
from amorsim.scenario.reading.faults import FaultCollector, Node, Source
from amorsim.scenario.reading.worlds import Maps
from amorsim.scenario.spec import Scenario

__all__ = [
    "check_words",
    "is_model",
    "load",
    "loads",
    "map_alone",
    "read_generated_alone",
    "read_map_alone",
    "scenario_for_map",
    "scenario_for_model",
]

_MODEL = {"drive", "shape"}


@checked
def load(
    source: str | os.PathLike[str],
    overrides: Annotated[Iterable[str], "a list of settings"] = (),
    *,
    registry: Registry | None = None,
) -> Scenario:
    """The scenario in a file, or the bundled one of that name.

    Nothing of a user's runs: of components in files the text is checked. `Simulation` loads them.

    Parameters
    ----------
    source
        Path of a ``.toml`` file or of one that a scenario loader reads (``.world``), or the name of a registered
        scenario such as ``"demo"``.
    overrides
        Settings as of the command line: ``"robots.rover.controller.speed=0.2"``; those of a scenario loader are
        ``"loader.crop_bitmaps=true"``.

    Raises
    ------
    ScenarioError
        With all the faults that were found, each with file, key path, and what would be right.
    """
    registry = registry or default_registry()
    path, book, tables = _find(source, overrides, registry)
    return _read(tables, book, registry, path, is_map_alone=book.is_foreign)


def _find(
    source: str | os.PathLike[str], overrides: Iterable[str], registry: Registry
) -> tuple[Path, FaultCollector, dict[str, Any]]:
    """The file that is meant by a path or by the name of a registered scenario, and its content, with settings.

    The book has the faults of lines that are not TOML, and of the settings. Nothing else has been looked at.

    Raises
    ------
    ScenarioError
        If there is no such file, it is not a text, or it is another program's and has faults.
    """
    try:
        path = path_of(source, "source", SCENARIO_PATH)
    except ParameterError as error:
        raise ScenarioError([Fault(file="", path=error.name, message=error.problem)]) from None
    overrides = setting_texts(overrides)
    names = registry.names("scenario")
    if str(source) in names and not is_file(path):
        path = registry.file("scenario", str(source))
    if (found := find_scenario_loader(path, registry)) is not None:
        options, overrides = split_options(overrides)
        document = read_foreign(path, *found, options)
        book = FaultCollector(Source(file=str(path), folder=path.parent))
        book.remarks, book.lines, book.is_foreign = document.remarks, document.lines, True
        book.shares_alike = True
        return path, book, overridden(document.tables, path, overrides, book, registry)
    written = read_file(path)
    if isinstance(written, str):
        raise ScenarioError([Fault(file=str(source), path="", message=mistaken(path, written, names))])
    book = book_of(written, path)
    tables = overridden(written.text, path, overrides, book, registry) if overrides else written.values
    return path, book, tables


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
    registry = registry or default_registry()
    book = FaultCollector(Source(file=name, folder=Path(folder)))
    tables = overridden(copy.deepcopy(dict(document)), Path(folder) / name, overrides, book, registry)
    return _read(tables, book, registry, starts=starts)


def scenario_for_map(
    path: str | Path, overrides: Iterable[str] = (), *, registry: Registry | None = None, **options: Any
) -> Scenario:
    """A Pioneer 2DX, "rover", that wanders for a minute on a map from its start or its freest place.

    `options` are the map loader's, spelt as in a file: ``resolution=0.05``, ``origin_yaw_deg=90``. What is
    raised is as for `load`.
    """
    registry = registry or default_registry()
    tables, book = _of_map(Path(path), options, overrides, registry)
    return _read(tables, book, registry, is_map_alone=True)


def _of_map(
    path: Path, options: Mapping[str, Any], overrides: Iterable[str], registry: Registry
) -> tuple[dict[str, Any], FaultCollector]:
    book = FaultCollector(Source(file="", folder=path.parent))
    return overridden(map_alone(path, options), path, overrides, book, registry), book


def read_map_alone(
    path: str | Path, overrides: Iterable[str] = (), *, registry: Registry | None = None, **options: Any
) -> Map:
    """The map in a file, with no robot in it; `overrides` name its options as those of a scenario's world do.

    `options` and what is raised are as for `scenario_for_map`.
    """
    path = Path(path)
    registry = registry or default_registry()
    book = FaultCollector(Source(file="", folder=path.parent))
    tables = {"world": {**options, "map": str(path.absolute())}}
    book.document = overridden(tables, path, overrides, book, registry)
    top = Node(book.document, (), book)
    top.refuse_unknown(("world",))
    world = Maps(registry).read(top.child("world"))
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
    made: dict[str, Any] = {"generate": kind, "seed": seed}
    book = FaultCollector(Source(file="", folder=Path()))
    book.document = made
    for setting in parse_settings(overrides, book):
        made[".".join(setting.path)] = setting.value
        book.set_source(setting.path, Source(file=setting.file, folder=Path.cwd(), depth=0))
    world = Maps(registry or default_registry(), are_read=is_made).generated(Node(made, (), book))
    book.raise_if_any()
    return world


def check_words(
    source: str | Path,
    overrides: Iterable[str] = (),
    *,
    of_map: Mapping[str, Any] | None = None,
    registry: Registry | None = None,
) -> None:
    """Raise the faults of a scenario's own text: all that `load` would find, except what depends on the maps.

    No map is read, so nothing is compiled: after a fresh installation, faults are reported before that wait.

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
        _, book, tables = _find(source, overrides, registry)
    else:
        tables, book = _of_map(path, of_map, overrides, registry)
    read_values(tables, book, registry, Maps(registry, are_read=False), False, False)
    book.raise_if_any()


def is_model(path: str | Path) -> bool:
    """Whether a file holds a robot's model: it has a drive or a shape, and neither world nor robots."""
    document = read_toml(Path(path)) if Path(path).suffix.lower() == ".toml" and is_file(path) else ""
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
    book = FaultCollector(Source(file=str(path), folder=path.parent))
    return _read(overridden(document, path, overrides, book, registry), book, registry)


def _read(
    document: dict[str, Any],
    book: FaultCollector,
    registry: Registry,
    file: Path | None = None,
    starts: bool = True,
    is_map_alone: bool = False,
) -> Scenario:
    values = read_values(document, book, registry, Maps(registry), starts, is_map_alone)
    book.raise_if_any()
    try:
        scenario = Scenario(**values, source=file, remarks=book.remarks)
    except ParameterError as error:
        book.fault((error.name,), error.problem)
        book.raise_if_any()
        raise
    return attrs.evolve(scenario, resolved=resolved_table(scenario, registry=registry))
