"""Chains of noise in forms: their elements, what can be added, and errors for numbers in lists."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any, TypedDict

import attrs

from amorsim.core.errors import AmorsimError
from amorsim.core.parameters import describe
from amorsim.plugins.manager import default_registry
from amorsim.scenario.reading.chains import chain_at, paths_of_chains, tables_of
from amorsim.scenario.reading.fields import NONE
from amorsim.scenario.spec import Robot
from amorsim.ui.forms.description import Choice, FieldForm, choices_of

__all__ = ["ChainForm", "ElementForm", "TargetForm", "chains_of", "noises_for", "targets_of", "with_element", "without"]


class ElementForm(TypedDict):
    """An element of a chain: its name, its class's name, and whether it is not in the scenario."""

    name: str
    use: str
    path: str
    is_added: bool


class ChainForm(TypedDict):
    """A chain of noise, in order; `group` is that of its fields. `gone` are elements that the scenario has in it."""

    path: str
    group: str
    elements: list[ElementForm]
    gone: list[str]


class TargetForm(TypedDict):
    """A number in a list that has no error yet and may be given one."""

    path: str
    label: str


def chains_of(robot: Robot, scenario: Robot) -> list[ChainForm]:
    """All chains of a robot, also the empty ones; `scenario` is the robot as the scenario has it."""
    registry, found = default_registry(), list[ChainForm]()
    for path in paths_of_chains(robot):
        known = {element.name for element in chain_at(scenario, path)}
        elements = chain_at(robot, path)
        names = {element.name for element in elements}
        found.append(
            {
                "path": path,
                "group": "ground" if path == "ground" else path.rpartition(".")[0],
                "elements": [
                    {
                        "name": element.name,
                        "use": registry.name_of("noise", type(element.noise)) or type(element.noise).__name__,
                        "path": f"{path}.{element.name}",
                        "is_added": element.name not in known,
                    }
                    for element in elements
                ],
                "gone": sorted(known - names),
            }
        )
    return found


def noises_for(robot: Robot, path: str, written: Mapping[str, Any] | None = None) -> list[Choice]:
    """The noises that can be in a chain, with forms as files spell them, in the sensor's unit.

    `written` is the table of an element that is being made, which fills the form of its noise.
    """
    registry = default_registry()
    sensor = None if path == "ground" else chain_owner(robot, path)
    unit = "m" if sensor is None else sensor.unit
    choices = choices_of("noise", registry, written=written, spelling="file", sensor_unit=unit)
    fitting = [one for one in choices if sensor is None or not registry.get("noise", one["name"]).for_ground]
    columns = {} if sensor is None else sensor.columns()
    for one in fitting if columns else ():
        several = len(set(columns.values())) > 1
        field = _column(list(columns), several and _has_unit(registry.get("noise", one["name"])))
        if written is not None and written.get("use") == one["name"]:
            field["value"], field["is_given"] = written.get("column"), "column" in written
        one["fields"].insert(0, field)
    return fitting


def chain_owner(robot: Robot, path: str) -> Any:
    """The sensor whose chain it is."""
    chain_at(robot, path)
    return robot.sensors[path.split(".")[1]].sensor


def _has_unit(cls: type) -> bool:
    return any(parameter.unit == "sensor" for parameter in describe(cls).values())


def _column(columns: list[str], is_required: bool) -> FieldForm:
    return {
        "path": "column",
        "label": "column",
        "help": "which of the sensor's quantities it is for",
        "widget": {"kind": "choice", "is_optional": not is_required, "choices": columns},
        "value": None,
        "default": None,
        "is_given": False,
        "is_required": is_required,
        "fixed": "",
    }


def with_element(robot: Robot, path: str, table: dict[str, Any], index: int | None = None) -> list[dict[str, Any]]:
    """The tables of a chain with one more, at its end or before the element of that index.

    What is null in its table is ``"none"``, as in files; a column that is null is left out.
    """
    tables = tables_of(robot, path)
    element = {key: _in_file(part) for key, part in table.items() if part is not None or key != "column"}
    tables.insert(len(tables) if index is None else index, element)
    return tables


def _in_file(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _in_file(part) for key, part in value.items()}
    return NONE if value is None else value


def without(robot: Robot, path: str) -> tuple[str, list[dict[str, Any]]]:
    """The path of the chain that an element is in, and the tables of the chain without it.

    Raises
    ------
    AmorsimError
        If there is no such element.
    """
    for chain in paths_of_chains(robot):
        names = [element.name for element in chain_at(robot, chain)]
        name = path.removeprefix(f"{chain}.")
        if path != name and name in names:
            return chain, [table for table in tables_of(robot, chain) if table["name"] != name]
    raise AmorsimError(f"robot {robot.name!r}: there is no element of noise at {path!r}")


def targets_of(robot: Robot) -> list[TargetForm]:
    """The numbers in lists of a robot's drive and sensors, such as a ring's elements, that have no error yet."""
    places = [("drive", robot.drive), *((f"sensors.{name}", unit.sensor) for name, unit in robot.sensors.items())]
    found: list[TargetForm] = []
    for path, thing in places:
        for name, parameter in describe(type(thing)).items():
            if isinstance(getattr(thing, name), tuple) and not parameter.static:
                found += _numbers_in(f"{path}.{name}", getattr(thing, name))
    return [target for target in found if target["path"] not in robot.errors]


def _numbers_in(path: str, items: tuple[Any, ...]) -> Iterator[TargetForm]:
    for i, item in enumerate(items):
        inner = describe(type(item)) if attrs.has(type(item)) else {}
        paths = [f"{path}.{i}.{name}" for name, parameter in inner.items() if parameter.live]
        for one in paths or ([f"{path}.{i}"] if isinstance(item, (int, float)) else []):
            yield {"path": one, "label": one.removeprefix("sensors.").replace(".", " ").replace("_", " ")}
