"""JSON Schemas of components: tables with ``use = NAME`` and the fields of the component of that name."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from amorsim.contracts import Mount, Sensor
from amorsim.core.errors import PluginError
from amorsim.core.parameters import LARGEST
from amorsim.plugins.registry import Registry
from amorsim.scenario.programs.user_components import USER_CODE
from amorsim.scenario.spec import MountedSensor
from amorsim.schemas.fields import Schema, required_fields, table_schema

__all__ = [
    "MOST",
    "NAME",
    "Component",
    "chain_schema",
    "component_schemas",
    "distribution",
    "model_schema",
    "ref",
    "registered",
]

Component = tuple[str, type[Any]]

MOST = 100.0 * LARGEST
"""No number is larger, nor an angle in degrees."""
NAME: Schema = {"type": "string", "pattern": r"^[A-Za-z][A-Za-z0-9_-]{0,63}$"}
"""The name of a robot, an obstacle, a sensor and so on."""
_FILE: Schema = {
    "type": "string",
    "pattern": r"\.py(:|$)",
    "description": "a class or function in a file: FILE.py:NAME",
}
_IN_A_FILE: Schema = {"properties": {"use": _FILE}, "required": ["use"], "additionalProperties": True}
_KINDS = (
    "drive",
    "motion",
    "estimator",
    "controller",
    "planner",
    "recorder",
    "task",
)  # whose tables have their fields alone


def ref(name: str) -> Schema:
    """A reference to a definition."""
    return {"$ref": f"#/$defs/{name}"}


def distribution() -> Schema:
    """The keys of a drawn number, one of which is there."""
    number: Schema = {"type": "number", "minimum": -MOST, "maximum": MOST}
    pair: Schema = {"type": "array", "minItems": 2, "maxItems": 2}
    spread = {"type": "number", "minimum": 0, "maximum": MOST}
    return {
        "normal": {"description": "[MEAN, STANDARD DEVIATION]", **pair, "prefixItems": [number, spread]},
        "uniform": {"description": "[LOW, HIGH]", **pair, "items": number},
    }


def model_schema(kind: str, registry: Registry) -> Schema:
    """A registered robot or device, or a file of one."""
    file = {"type": "string", "pattern": r"\.toml$", "description": "path of a file, which starts at this one"}
    return {"description": f"a registered {kind}, or its file", "anyOf": [{"enum": list(registry.names(kind))}, file]}


def registered(registry: Registry, kind: str) -> list[Component]:
    """The components of a kind that can be loaded, with their names."""
    found = []
    for name in registry.names(kind):
        try:
            found.append((name, registry.get(kind, name)))
        except PluginError as error:
            registry.report(str(error))
    return found


def component_schemas(registry: Registry) -> Schema:
    """Definitions of all components that scenarios may have.

    ``KIND`` is a table that stands alone; ``KIND.part`` one under which a model's may lie, so that nothing must be
    given in it.
    """
    found: Schema = {}
    for kind in _KINDS:
        _define(found, kind, registered(registry, kind), table_schema, {})
    _define(found, "sensor", registered(registry, "sensor"), sensor_fields, mounted(registry))
    noises = registered(registry, "noise")
    for_sensors = [(name, cls) for name, cls in noises if not cls.for_ground]
    _define_noise(found, "ground", noises, ("m",))
    _define_noise(found, "noise", for_sensors, ("m",))
    _define_noise(found, "noise_of_angles", for_sensors, ("rad",))
    _define_noise(found, "noise_of_columns", for_sensors, ("m", "rad"))
    return found


def mounted(registry: Registry) -> Schema:
    """The keys of every sensor's table besides the sensor's own fields and its noise."""
    own = table_schema(MountedSensor, names=("rate", "latency"))["properties"]
    return {"model": model_schema("device", registry), "mount": table_schema(Mount), **own}


def sensor_fields(cls: type[Sensor]) -> Schema:
    """The fields of a sensor and its noise."""
    return table_schema(cls, beside={"noise": chain_schema(_noise_of(cls))})


def chain_schema(of: str) -> Schema:
    """A noise chain, whose elements are of a definition."""
    return {"description": "noise that values go through, in this order", "type": "array", "items": ref(of)}


def variant(name: str, table: Schema, required: list[str], key: str = "use") -> Schema:
    """The table of one component, with its name under `key`."""
    properties = {key: {"const": name, "description": table["description"]}, **table["properties"]}
    return {**table, "title": name, "properties": properties, "required": [key, *required]}


def in_a_file(kind: str) -> list[Schema]:
    """The table of a component in a user's file, with its options; none for kinds without that."""
    return [_IN_A_FILE] if kind in USER_CODE else []


def _define(
    found: Schema, kind: str, components: list[Component], fields: Callable[[type], Schema], beside: Schema
) -> None:
    """Define the tables of a kind: by themselves, and over a model's, where `use` may be left out."""
    alone, part = [], []
    for name, cls in components:
        table = fields(cls)
        table["properties"] = {**beside, **table["properties"]}
        found[f"{kind}.{name}"] = variant(name, table, [])
        part.append(ref(f"{kind}.{name}"))
        required = required_fields(cls)
        alone.append({"allOf": [part[-1]], "required": required} if required else part[-1])
    others = in_a_file(kind)
    with_model = [{"required": ["model"], "not": {"required": ["use"]}}] if "model" in beside else []
    found[kind] = {"type": "object", "oneOf": [*alone, *others, *with_model]}
    found[f"{kind}.part"] = {"type": "object", "oneOf": [*part, *others, {"not": {"required": ["use"]}}]}


def _noise_of(sensor: type[Sensor]) -> str:
    """The definition of a sensor's noise, whose fields are spelt by the unit of its values."""
    if sensor.columns is not Sensor.columns:
        return "noise_of_columns"
    return "noise_of_angles" if sensor.unit.split("/")[0] == "rad" else "noise"


def _define_noise(found: Schema, chain: str, components: list[Component], units: tuple[str, ...]) -> None:
    """Define a chain's elements, whose fields are spelt by the unit of its values, or by any of several."""
    beside: Schema = {"name": NAME}
    if chain != "ground":
        beside["column"] = {"type": "string", "description": "the one of its sensor's columns that it is for"}
    elements = []
    for name, cls in components:
        tables = [table_schema(cls, unit=unit, beside=beside) for unit in units]
        merged: Schema = {key: field for table in tables for key, field in table["properties"].items()}
        needed = [key for key in required_fields(cls, units[0]) if all(key in table["properties"] for table in tables)]
        elements.append(variant(name, {**tables[0], "properties": merged}, needed))
    found[chain] = {"type": "object", "oneOf": elements}
