"""Scenarios on the disk: their tables written as readable TOML, with copies of the files that they name."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import attrs
import tomlkit
from tomlkit.items import Array, Float, InlineTable, Item, Table, Trivia

from amorsim.core.files.atomic_files import write_text
from amorsim.core.maps.map import Map
from amorsim.scenario.files.copied_files import Copies
from amorsim.scenario.files.data_files import files_of_scenario
from amorsim.scenario.files.maps import MapFile
from amorsim.scenario.files.resolved import resolved_table
from amorsim.scenario.programs.controller_files import tables_of_programs
from amorsim.scenario.reading.starts import series_of
from amorsim.scenario.spec import Scenario
from amorsim.scenario.toml.angles import LongDegrees
from amorsim.worlds.drawn import origin_of

__all__ = ["resolved_table", "table_text", "with_copies", "with_maps", "write_table"]

# Tables of a robot that get a header of their own; whatever else holds keys stands on one line.
_HEADED = (
    ("world",),
    ("simulation",),
    ("recording",),
    ("task",),
    ("floor",),
    ("robots", "shape"),
    ("robots", "drive"),
    ("robots", "sensors"),
    ("robots", "sensors", "*"),
    ("robots", "estimators"),
    ("robots", "estimators", "*"),
    ("robots", "knowledge"),
)
_LINE = 100


def write_table(table: Mapping[str, Any], path: str | Path) -> None:
    """Write a scenario's table as TOML; numbers as the shortest decimals that read as the same bits.

    Raises
    ------
    RunError
        If the file cannot be written; one that was there is there still.
    """
    write_text(path, table_text(table))


def table_text(table: Mapping[str, Any], *, with_remarks: bool = False) -> str:
    """A scenario as TOML: a table a thing, mounts, poses and noise on a line each.

    With remarks it also states, in comments, that a sensor has no rate; TOML has no word for that.
    """
    root = tomlkit.document()
    for key, value in table.items():
        if key in ("robots", "obstacles", "landmarks", "lights", "zones"):
            array = tomlkit.aot()
            for item in value:
                array.append(_table(item, (key,)))
            root.append(key, array)
        else:
            root.append(key, _item(value, (key,)))
    if with_remarks:
        for robot in root["robots"]:
            for sensor in robot.get("sensors", {}).values():
                if "rate" not in sensor:
                    sensor.add(tomlkit.comment("rate: none is given, so it reads in every step"))
    return tomlkit.dumps(root)


def _table(values: Mapping[str, Any], path: tuple[str, ...]) -> Table:
    # A table of nothing but tables needs no header of its own.
    is_super = bool(values) and all(_is_headed((*path, key), value) for key, value in values.items())
    table = tomlkit.table(is_super_table=is_super)
    headed = {key: value for key, value in values.items() if _is_headed((*path, key), value)}
    for key, value in values.items():
        if key not in headed:
            table.append(key, _item(value, (*path, key)))
    # TOML wants a table's own keys before its tables.
    for key, value in headed.items():
        table.append(key, _item(value, (*path, key)))
    return table


def _is_headed(path: tuple[str, ...], value: Any) -> bool:
    if not isinstance(value, dict):
        return False
    if path[:2] == ("robots", "errors"):
        # Down to where numbers are named, which stand on a line each.
        return len(path) == 2 or not set(value) <= {"scale", "add", "value", "per"}
    return any(
        len(path) == len(pattern) and all(want in ("*", part) for want, part in zip(pattern, path, strict=True))
        for pattern in _HEADED
    )


def _item(value: Any, path: tuple[str, ...]) -> Item:
    if isinstance(value, dict):
        return _table(value, path) if _is_headed(path, value) else _inline(value)
    return _value(value)


def _inline(values: Mapping[str, Any]) -> InlineTable:
    table = tomlkit.inline_table()
    for key, value in values.items():
        table.append(key, _value(value))
    return table


def _value(value: Any) -> Item:
    if isinstance(value, dict):
        return _inline(value)
    if isinstance(value, (list, tuple)):
        array: Array = tomlkit.array()
        for part in value:
            array.append(_value(part))
        array.multiline(len(array.as_string()) > _LINE)
        return array
    if isinstance(value, float):
        return Float(value, Trivia(), value.text if isinstance(value, LongDegrees) else repr(value))
    item: Item = tomlkit.item(value)
    return item


def with_copies(scenario: Scenario, folder: str | Path) -> dict[str, Any]:
    """The table of a scenario that names copies of its maps and controllers, made in a folder.

    A map that was made in Python gets a file there. Each file is copied once; files of the same name from different
    places get numbers. A map of several files gets a folder of its own, for the files name each other.

    Raises
    ------
    RunError
        If a file cannot be read, or its copy not be written.
    ScenarioError
        As for `resolved_table`; nothing has been copied then.
    """
    copies = Copies(Path(folder))
    resolved_table(scenario, maps_in_files=False)  # complains before anything is written
    scenario = _with_files(scenario, copies)
    table = resolved_table(scenario)
    if isinstance(scenario.map.source, MapFile):
        table["world"]["map"] = copies.of_map(scenario.map.source)
    for (robot, *_), written in zip(series_of(scenario.robots), table["robots"], strict=True):
        if robot.knowledge.map is not None and isinstance(robot.knowledge.map.source, MapFile):
            written["knowledge"]["map"] = copies.of_map(robot.knowledge.map.source)
    for program in tables_of_programs(table):
        copies.of_program(program)
    for written, key in files_of_scenario(scenario, table):
        written[key] = copies.of(written[key])
    return table


def with_maps(scenario: Scenario, folder: str | Path) -> dict[str, Any]:
    """The table of a scenario with the maps made in Python written into a folder; other files stay where they are.

    Raises
    ------
    RunError
        If a map cannot be written.
    ScenarioError
        As for `resolved_table`; nothing has been written then.
    """
    resolved_table(scenario, maps_in_files=False)
    return resolved_table(_with_files(scenario, Copies(Path(folder))))


def _with_files(scenario: Scenario, copies: Copies) -> Scenario:
    """The scenario with a file for every map that was made in Python, or generated, if all replicas have the same."""
    written: dict[int, Map] = {}

    def in_file(found: Map) -> Map:
        if isinstance(found.source, MapFile) or origin_of(found) is not None:
            return found
        if id(found) not in written:
            # Some formats lose the start, and robots without a pose are there.
            written[id(found)] = attrs.evolve(copies.save(found), start=found.start)
        return written[id(found)]

    robots = [
        robot
        if robot.knowledge.map is None
        else attrs.evolve(robot, knowledge=attrs.evolve(robot.knowledge, map=in_file(robot.knowledge.map)))
        for robot in scenario.robots
    ]
    return attrs.evolve(scenario, map=in_file(scenario.map), robots=robots)
