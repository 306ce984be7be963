"""Where tables of components name files: the fields that are made with ``file=True``."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Any

import attrs

from amorsim.core.parameters import describe
from amorsim.scenario.reading.starts import series_of
from amorsim.scenario.spec import MountedSensor, NoiseElement, Robot, Scenario

__all__ = ["files_of_robot", "files_of_scenario", "files_of_sensor"]

Table = dict[str, Any]
Place = tuple[Table, str]


def files_of_scenario(scenario: Scenario, document: Table) -> Iterator[Place]:
    """The tables in a scenario's document that name a file, each with the key that does."""
    for (robot, *_), table in zip(series_of(scenario.robots), document["robots"], strict=True):
        yield from files_of_robot(robot, table)
    for (obstacle, *_), table in zip(series_of(scenario.obstacles), document.get("obstacles", ()), strict=True):
        yield from _of(obstacle.motion, table.get("motion"))
    for zone, table in zip(scenario.zones, document.get("zones", ()), strict=True):
        yield from _of_chain(zone.ground, table.get("ground"))


def files_of_robot(robot: Robot, table: Table) -> Iterator[Place]:
    """The same of a robot's table."""
    yield from _of(robot.drive, table.get("drive"))
    for name, unit in robot.sensors.items():
        yield from files_of_sensor(unit, table["sensors"][name])
    for name, estimator in robot.estimators.items():
        yield from _of(estimator, table["estimators"][name])
    yield from _of(robot.controller, table.get("controller"))
    yield from _of_chain(robot.ground, table.get("ground"))


def files_of_sensor(unit: MountedSensor, table: Table) -> Iterator[Place]:
    """The same of a sensor's table."""
    yield from _of(unit.sensor, table)
    yield from _of_chain(unit.noise, table.get("noise"))


def _of_chain(chain: Iterable[NoiseElement], tables: Any) -> Iterator[Place]:
    for element, table in zip(chain, tables or (), strict=True):
        yield from _of(element.noise, table)


def _of(component: Any, table: Any) -> Iterator[Place]:
    if not attrs.has(type(component)) or not isinstance(table, dict):
        return
    for name, parameter in describe(type(component)).items():
        if parameter.file and isinstance(table.get(name), str) and table[name]:
            yield table, name
        elif parameter.component:
            yield from _of(getattr(component, name), table.get(name))
