"""Files of models and devices: checked on their own, and written as what differs from what they build on."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from amorsim.core.arguments import checked, path_of
from amorsim.core.errors import RunError
from amorsim.core.files.atomic_files import write_text
from amorsim.plugins.manager import default_registry
from amorsim.plugins.registry import Registry
from amorsim.scenario.documents.elsewhere import near
from amorsim.scenario.files.data_files import files_of_robot, files_of_sensor
from amorsim.scenario.files.devices import load_device
from amorsim.scenario.files.models import FORMAT, MODEL_KEYS, are_of_one_kind, check_format, drop_removed
from amorsim.scenario.files.resolved import robot_table, sensor_table
from amorsim.scenario.programs.controller_files import tables_of_programs
from amorsim.scenario.reading.components import read_sensor
from amorsim.scenario.reading.faults import FaultCollector, Node
from amorsim.scenario.reading.fields import NONE
from amorsim.scenario.reading.robots import load_robot, read_robot
from amorsim.scenario.reading.worlds import Maps
from amorsim.scenario.spec import MountedSensor, Robot
from amorsim.scenario.toml.layout import MISSING
from amorsim.scenario.toml.literals import are_same, as_toml, keys_as_toml

__all__ = ["check_model", "read_model", "save_device", "save_robot"]


def check_model(values: Mapping[str, Any], kind: str, book: FaultCollector) -> None:
    """Note what is wrong at the top of the file of a model or a device."""
    top = Node(values, (), book)
    check_format(top.child("format"))
    if kind == "model":
        top.refuse_unknown(MODEL_KEYS)
    if "description" in top:
        top.child("description").text("a text")


def read_model(robot: dict[str, Any], kind: str, book: FaultCollector, registry: Registry) -> None:
    """Note what is wrong with a robot into which a model was merged, or with its sensor that is the device."""
    node = Node(robot, ("robots", "0"), book)
    if kind == "device":
        if isinstance(robot.get("sensors"), dict) and "device" in robot["sensors"]:
            read_sensor(node.child("sensors").child("device"), registry)
        return
    for key in [key for key in robot if key not in (*MODEL_KEYS, "resolved_from")]:
        del robot[key]  # reported at the top
    drop_removed(robot)
    read_robot(node, Maps(registry), None, registry)


@checked
def save_robot(
    robot: Robot, path: str | os.PathLike[str], *, model: str | None = None, registry: Registry | None = None
) -> Path:
    """Write a robot as a model into a file: what differs from the model that it builds on, and nothing else.

    Its name, where it starts and what it knows of the world are not part of a model.

    Parameters
    ----------
    robot
        Its parts must have names in files: registered components, and programs in files of their own.
    path
        The file, with the ending ``.toml``; it is replaced if it is there.
    model
        What it builds on: the name of a registered model, or the path of a file. Without it, the robot's own model if
        that is a registered one; ``""`` for none.

    Raises
    ------
    RunError
        If it cannot be written, or its model has a controller or errors that it has not; what was there is there still.
    ScenarioError
        If a file cannot name something in the robot, or the model has faults.
    """
    registry = registry or default_registry()
    target = path_of(path, "path")
    if model is None:
        model = robot.model if robot.model in registry.names("robot") else ""
    own = _robot(robot, target, registry)
    parent = _robot(load_robot(model, registry=registry), target, registry) if model else {}
    return _write(own, parent, model, target)


@checked
def save_device(
    device: MountedSensor, path: str | os.PathLike[str], *, model: str = "", registry: Registry | None = None
) -> Path:
    """Write a sensor as a device into a file: what differs from the device that it builds on, and nothing else.

    Parameters
    ----------
    device
        Its parts must be registered.
    path
        The file, with the ending ``.toml``; it is replaced if it is there.
    model
        What it builds on: the name of a registered device, or the path of a file; none if empty.

    Raises
    ------
    RunError
        If it cannot be written; what was there is there still.
    ScenarioError
        If a file cannot name something in the sensor, or the device has faults.
    """
    registry = registry or default_registry()
    target = path_of(path, "path")
    own = _sensor(device, target, registry)
    parent = _sensor(load_device(model, registry=registry), target, registry) if model else {}
    return _write(own, parent, model, target)


def _robot(robot: Robot, target: Path, registry: Registry) -> dict[str, Any]:
    table = robot_table(robot, registry)
    return _named(table, files_of_robot(robot, table), target)


def _sensor(sensor: MountedSensor, target: Path, registry: Registry) -> dict[str, Any]:
    table = sensor_table(sensor, registry)
    return _named(table, files_of_sensor(sensor, table), target)


def _write(own: dict[str, Any], parent: dict[str, Any], model: str, target: Path) -> Path:
    lines = [f"format = {FORMAT}"]
    if model:
        name = near(Path(model).absolute(), target.absolute().parent) if model.endswith(".toml") else model
        lines.append(f"model = {as_toml(name)}")
    differs = _difference(own, parent, ())
    lines += [_line((key,), value) for key, value in differs.items() if not _is_headed(key, value)]
    for key, value in differs.items():
        if _is_headed(key, value):
            lines += _section((key,), value)
    write_text(target, "\n".join(lines) + "\n")
    return target


def _named(table: dict[str, Any], files: Iterable[tuple[dict[str, Any], str]], target: Path) -> dict[str, Any]:
    """The table of a robot or sensor, its program and files named from where it is written."""
    folder = target.absolute().parent
    for holder, key in files:
        holder[key] = near(Path(holder[key]), folder)
    for program in tables_of_programs(table):
        file, _, name = program["use"].rpartition(":")
        program["use"] = f"{near(Path(file), folder)}:{name}"
    return table


def _difference(own: dict[str, Any], parent: dict[str, Any], path: tuple[str, ...]) -> dict[str, Any]:
    """The table that makes `own` when it is laid over the parent's."""
    differs: dict[str, Any] = {}
    for key, value in own.items():
        at, old = (*path, key), parent.get(key, MISSING)
        if isinstance(value, dict) and isinstance(old, dict) and are_of_one_kind(at, old, value):
            inner = _difference(value, old, at)
            if inner:
                differs[key] = inner
        elif not are_same(value, old):
            differs[key] = value
    for key in parent:
        if key not in own:
            differs[key] = _nothing((*path, key), parent[key])
    return differs


def _nothing(path: tuple[str, ...], value: Any) -> Any:
    """The entry that removes a value of the parent."""
    if path[0] in ("sensors", "estimators") and len(path) == 2:
        return False
    if path[0] in ("controller", "errors"):
        raise RunError(
            f"{'.'.join(path)}: the model has this and the robot has not, which no file can say; save it with model=''"
        )
    return [] if isinstance(value, list) else NONE


def _is_headed(key: str, value: Any) -> bool:
    return isinstance(value, dict) and key not in ("shape", "mount")


def _section(path: tuple[str, ...], table: dict[str, Any]) -> list[str]:
    """A table under a header of its own; of sensors, estimators and errors the tables in it."""
    inner = {key: item for key, item in table.items() if isinstance(item, dict) and path[-1] in _OF_TABLES}
    pairs = [_line((key,), item) for key, item in table.items() if key not in inner]
    lines = ["", f"[{keys_as_toml(path)}]", *pairs] if pairs or not inner else []
    for key, item in inner.items():
        lines += _section((*path, key), item)
    return lines


_OF_TABLES = ("sensors", "estimators", "errors")


def _line(keys: tuple[str, ...], value: Any) -> str:
    if isinstance(value, list) and len(as_toml(value)) > 100:
        items = "".join(f"    {as_toml(item)},\n" for item in value)
        return f"{keys_as_toml(keys)} = [\n{items}]"
    return f"{keys_as_toml(keys)} = {as_toml(value)}"
