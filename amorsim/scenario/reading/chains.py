"""Chains of noise by path, ``sensors.laser.noise`` or ``ground``: of a robot, in tables, and replaced by others."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

import attrs

from amorsim.contracts import Noise
from amorsim.core.error_text import in_words
from amorsim.core.errors import AmorsimError, ScenarioError
from amorsim.core.parameters import ParameterError
from amorsim.core.unknown_names import no_such
from amorsim.plugins.manager import default_registry
from amorsim.scenario.files.resolved import chain_table
from amorsim.scenario.reading.components import read_chain
from amorsim.scenario.reading.faults import FaultCollector, Node
from amorsim.scenario.spec import NoiseElement, Robot

__all__ = ["chain_at", "is_chain", "paths_of_chains", "read_elements", "tables_of", "with_chain"]

Elements = tuple[NoiseElement, ...]


def is_chain(path: object) -> bool:
    """Whether a path leads to a chain as a whole."""
    if not isinstance(path, str):
        return False
    parts = path.split(".")
    return path == "ground" or (len(parts) == 3 and parts[0] == "sensors" and parts[2] == "noise")


def paths_of_chains(robot: Robot) -> list[str]:
    """The paths of all chains of a robot, those without elements too."""
    return ["ground", *(f"sensors.{name}.noise" for name in robot.sensors)]


def chain_at(robot: Robot, path: str) -> Elements:
    """A chain of a robot.

    Raises
    ------
    AmorsimError
        If the robot has no such sensor.
    """
    return robot.ground if path == "ground" else robot.sensors[_sensor(robot, path)].noise


def with_chain(robot: Robot, path: str, elements: Elements) -> Robot:
    """The robot with another chain.

    Raises
    ------
    AmorsimError
        If the robot has no such sensor, or its values do not suit an element.
    """
    if path == "ground":
        return attrs.evolve(robot, ground=elements)
    name = _sensor(robot, path)
    try:
        changed = attrs.evolve(robot.sensors[name], noise=elements)
    except ParameterError as error:
        raise AmorsimError(f"robot {robot.name!r}, {path}: {error.problem}") from None
    return attrs.evolve(robot, sensors={**robot.sensors, name: changed})


def _sensor(robot: Robot, path: str) -> str:
    name = path.split(".")[1]
    if name not in robot.sensors:
        raise AmorsimError(no_such("sensor", name, robot.sensors, whose=f"robot {robot.name!r}"))
    return name


def read_elements(robot: Robot, path: str, given: Any) -> Elements:
    """The elements of a chain, given as noises, elements or tables as in files.

    Raises
    ------
    AmorsimError
        If it is none of these, or with all that is wrong with the tables.
    """
    chain_at(robot, path)
    if isinstance(given, (str, Mapping)) or not isinstance(given, Iterable):
        expected = "expected a list of noises, or of tables as {'use': 'gaussian', 'std': 0.01}"
        raise AmorsimError(f"robot {robot.name!r}, {path}: {expected}, got {in_words(given)}")
    given = list(given)
    if all(isinstance(one, (Noise, NoiseElement)) for one in given):
        changed = with_chain(robot, path, tuple(given))
        return chain_at(changed, path)
    book = FaultCollector.silent()
    sensor = None if path == "ground" else robot.sensors[_sensor(robot, path)].sensor
    unit = "m" if sensor is None else sensor.unit
    elements = read_chain(Node(given, (*path.split("."),), book), default_registry(), unit, sensor)
    if book.count:
        problems = "; ".join(f"{fault.path}: {fault.message}" for fault in book.faults)
        raise AmorsimError(f"robot {robot.name!r}, {problems}")
    return elements


def tables_of(robot: Robot, path: str) -> list[dict[str, Any]]:
    """The tables in a file from which `read_elements` makes the same chain.

    Raises
    ------
    AmorsimError
        If a class was not registered, so that no file can name it.
    """
    try:
        return chain_table(robot, path, default_registry())
    except ScenarioError as error:
        problems = "; ".join(fault.message for fault in error.faults)
        raise AmorsimError(f"robot {robot.name!r}, {path}: {problems}") from None
