"""A window's scenario written into a file, with the changes that were made in the window."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Callable, Sequence
from pathlib import Path

import attrs

from amorsim.core.errors import DocumentError, RunError, ScenarioError
from amorsim.core.files.atomic_files import copy_file
from amorsim.plugins.manager import default_registry
from amorsim.plugins.registry import Registry
from amorsim.scenario.documents.changed_robots import robot_of, set_robots
from amorsim.scenario.documents.document import Document, open_document
from amorsim.scenario.documents.names import name_from, rename_maps
from amorsim.scenario.documents.overrides import override
from amorsim.scenario.files.maps import MapFile, companions_of
from amorsim.scenario.files.write import resolved_table, write_table
from amorsim.scenario.spec import Robot, Scenario
from amorsim.scenario.toml.literals import are_same
from amorsim.simulation.simulation import Simulation

__all__ = ["save_scenario"]


def save_scenario(simulation: Simulation, path: Path, *, changes: Sequence[str] = (), passing: str = "") -> None:
    """Write a simulation's scenario with the present parameters of its robots.

    The file that it was read from is written as its author wrote it, except for what was changed: by `changes` when it
    was read, and since. All is written out for a scenario without a file, and where the file cannot (robots of one
    table that differ by now), and where it has been edited since it was read.

    Parameters
    ----------
    simulation
        The simulation; its scenario's robots are those that were read.
    path
        The file.
    changes
        The settings that the scenario was read with, as of ``--set``.
    passing
        A folder whose files are not there for long; its maps are copied, as are those that come with amorsim.

    Raises
    ------
    RunError
        If the file or a map's copy cannot be written.
    ScenarioError
        If a file cannot name something in the scenario.
    """
    scenario = simulation.scenario
    robots = [simulation.robot(robot.name).nominal for robot in scenario.robots]
    folders = _not_the_users(scenario, passing)
    is_authored = scenario.source is not None and not (passing and scenario.source.is_relative_to(passing))
    document = _authored(scenario, robots, changes, simulation.seed) if is_authored else None
    if document is not None:
        _name_copies(document, scenario, folders, path)
        document.save(path)
        return
    scenario = attrs.evolve(scenario, robots=robots, seed=simulation.seed)
    tables = resolved_table(scenario)
    rename_maps(tables, _copying(scenario, folders, path))
    name_from(path.parent, tables, scenario)
    write_table(tables, path)


def _authored(scenario: Scenario, robots: Sequence[Robot], changes: Sequence[str], seed: int) -> Document | None:
    """The document of the scenario's file with the changes; None if it does not have the same robots."""
    registry = default_registry()
    with contextlib.suppress(DocumentError, ScenarioError, OSError):
        assert scenario.source is not None
        document = open_document(scenario.source, registry=registry)
        override(document, changes, registry)
        for key, value in (("simulation.seed", seed), ("simulation.duration", scenario.duration)):
            if document.get(key) != value:
                document.set(key, value)
        set_robots(document, scenario.robots, robots, registry)
        if _is_meant(document.scenario(), scenario, robots, registry):
            return document
    return None


def _is_meant(found: Scenario, scenario: Scenario, robots: Sequence[Robot], registry: Registry) -> bool:
    """Whether a scenario is this one with these robots."""
    before, after = scenario.resolved or {}, found.resolved or {}
    rest = {*before, *after} - {"robots", "simulation"}
    return (
        all(are_same(before.get(key), after.get(key)) for key in rest)
        and [one.name for one in found.robots] == [one.name for one in robots]
        and all(
            are_same(robot_of(one, registry), robot_of(other, registry))
            for one, other in zip(found.robots, robots, strict=True)
        )
    )


def _name_copies(document: Document, scenario: Scenario, folders: Sequence[Path], path: Path) -> None:
    """Copy the maps of some folders next to the file that is to be, and name the copies in a document."""
    here = document.path.absolute().parent
    places = {"world.map": document.values["world"]["map"]}
    for number, robot in enumerate(document.values["robots"]):
        places[f"robots.{number}.knowledge.map"] = robot.get("knowledge", {}).get("map")
    copy_of = _copying(scenario, folders, path)
    for place, name in places.items():
        if isinstance(name, str):  # else there is none, or it is generated
            file = os.path.abspath(here / name)  # noqa: PTH100 - a link stays
            if (copy := copy_of(file)) != file:
                document.set(place, os.path.abspath(copy))  # noqa: PTH100


def _not_the_users(scenario: Scenario, passing: str) -> list[Path]:
    """Folders whose files a saved scenario should not name: they are temporary, or belong to a program."""
    registry = default_registry()
    bundled = {registry.file("scenario", name).parent for name in registry.names("scenario")}
    folders = {Path(passing)} if passing else set()
    if scenario.source is not None:
        folders |= {scenario.source.parent} & bundled
    return sorted(folders)


def _copying(scenario: Scenario, folders: Sequence[Path], path: Path) -> Callable[[str], str]:
    """A function that copies maps from some folders to the folder of the new file, and returns the copy's name.

    The copy is named after that file. Other maps, and those of several files, stay where they are.
    """
    copies: dict[str, str] = {}
    maps = [scenario.map, *(robot.knowledge.map for robot in scenario.robots if robot.knowledge.map is not None)]
    files = [found.source for found in maps if isinstance(found.source, MapFile)]
    whole = {str(file.path.absolute()) for file in files if not companions_of(file)}

    def kept(name: str) -> str:
        file = Path(name)
        if name not in whole or not any(file.is_relative_to(folder) for folder in folders):
            return name
        if name not in copies:
            number, copy = 1, path.with_suffix(file.suffix)
            while not _is_copied(file, copy):
                number += 1
                copy = path.with_name(f"{path.stem}-{number}{file.suffix}")
            copies[name] = str(copy)
        return copies[name]

    return kept


def _is_copied(file: Path, copy: Path) -> bool:
    """Copy a file unless its target exists, be it a link; returns whether it was copied."""
    try:
        copy.touch(exist_ok=False)
    except FileExistsError:
        return False
    except OSError as error:
        raise RunError(f"{copy}: cannot be written: {error.strerror or error}") from error
    try:
        copy_file(file, copy)
    except RunError:
        copy.unlink(missing_ok=True)
        raise
    return True
