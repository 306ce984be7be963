"""The JSON Schema of a scenario's file."""

from __future__ import annotations

from amorsim.plugins.registry import Registry
from amorsim.scenario.files.models import ERROR_KEYS, FORMAT, LOOKS, read_layers
from amorsim.scenario.floor import Drop, Floor, Marking
from amorsim.scenario.initial_belief import InitialBelief
from amorsim.scenario.kidnapping import Kidnapping
from amorsim.scenario.random_start import RandomStart
from amorsim.scenario.reading.fields import file_fields
from amorsim.scenario.reading.starts import MOST as MOST_BODIES
from amorsim.scenario.reading.starts import GridStart
from amorsim.scenario.reading.worlds import KnownLandmark
from amorsim.scenario.spec import Landmark, Light, Obstacle, Pose, Recording, Robot, Scenario
from amorsim.schemas.components import (
    MOST,
    NAME,
    chain_schema,
    component_schemas,
    distribution,
    model_schema,
    mounted,
    ref,
    registered,
    sensor_fields,
    variant,
)
from amorsim.schemas.fields import Schema, closed, field_schema, required_fields, table_schema

__all__ = ["FORMAT_SCHEMA", "scenario_schema"]

FORMAT_SCHEMA: Schema = {"description": "the format of this file", "const": FORMAT}
_FAR = 1e100  # [m] larger numbers are taken for mistakes
_NUMBER: Schema = {"type": "number", "minimum": -_FAR, "maximum": _FAR}
_LENGTH: Schema = {"type": "number", "exclusiveMinimum": 0, "maximum": _FAR}
_POINT: Schema = {"type": "array", "items": _NUMBER, "minItems": 2, "maxItems": 2}
_SEED: Schema = {"type": "integer", "minimum": 0, "maximum": 2**63 - 1}
_COUNT: Schema = {"type": "integer", "minimum": 1, "maximum": MOST_BODIES, "description": "how many of these there are"}
_PER: Schema = {"enum": ["replica", "study"], "description": "who draws: each replica, or the study once"}

# No component of its own is named in a table, so that it changes the model's; or it is not a table.
_NAMED: Schema = {"type": "object", "anyOf": [{"required": ["use"]}, {"required": ["model"]}]}
_UNNAMED: Schema = {"not": _NAMED}


def scenario_schema(registry: Registry) -> Schema:
    """The schema of a scenario, with the components, robots and devices that are registered."""
    return {
        **closed(
            {
                "format": FORMAT_SCHEMA,
                "description": {"type": "string", "description": "a text for readers"},
                "world": ref("world"),
                "simulation": table_schema(Scenario, names=("dt", "duration", "seed"), about="time and seed"),
                "recording": table_schema(Recording, beside={"also": _list(ref("recorder"))}),
                "task": ref("task"),
                "robots": {**_list(ref("robot")), "minItems": 1},
                "obstacles": _list(ref("obstacle")),
                "landmarks": _list(_alone(Landmark)),
                "lights": _list(_alone(Light)),
                "zones": _list(ref("zone")),
                "floor": _floor(),
            },
            required=["format", "world", "robots"],
        ),
        "$defs": {
            **component_schemas(registry),
            **_geometry(),
            **_worlds(registry),
            **_errors(),
            "robot": _robot(registry),
            "obstacle": _obstacle(),
            "zone": _zone(),
        },
    }


def _list(items: Schema) -> Schema:
    return {"type": "array", "items": items}


def _alone(cls: type) -> Schema:
    """The table of a class, with its required fields."""
    needed = required_fields(cls)
    return {**table_schema(cls), **({"required": needed} if needed else {})}


def _by_name(values: Schema) -> Schema:
    return {"type": "object", "propertyNames": NAME, "additionalProperties": values}


def _geometry() -> Schema:
    shapes = [
        closed({"circle": _LENGTH, "x": _NUMBER, "y": _NUMBER}, required=["circle"], about="a radius [m]"),
        closed(
            {"rectangle": {**_POINT, "items": _LENGTH}, "x": _NUMBER, "y": _NUMBER},
            required=["rectangle"],
            about="[LENGTH, WIDTH] [m]",
        ),
        closed(
            {"polygon": {**_list(_POINT), "minItems": 3}, "rounding": {"type": "number", "minimum": 0}},
            required=["polygon"],
            about="[[X, Y], ...] [m]",
        ),
    ]
    poses = closed({"poses": _list(ref("pose"))}, required=["poses"])
    return {
        "shape": {"description": "a circle, a rectangle or a polygon, in the body's frame", "oneOf": shapes},
        "pose": table_schema(Pose),
        "start": {
            "description": "where many start",
            "oneOf": [{**_alone(RandomStart), "required": ["random"]}, _alone(GridStart), poses],
        },
    }


def _errors() -> Schema:
    """An error, or a table of errors below one name; no path ends with a key of an error."""
    drawn = [closed({key: value}, required=[key]) for key, value in distribution().items()]
    error = closed({**{key: ref("number") for key in ("scale", "add", "value")}, "per": _PER})
    below = {**_by_path(ref("error")), "propertyNames": {"not": {"enum": sorted(ERROR_KEYS)}}}
    about = "how the true value differs"
    return {
        "number": {
            "description": "a number, or one that is drawn",
            "anyOf": [{"type": "number", "minimum": -MOST, "maximum": MOST}, *drawn],
        },
        "error_of_number": {"description": about, "anyOf": [ref("number"), error]},
        "error": {"description": about, "anyOf": [ref("number"), error, below]},
    }


def _by_path(values: Schema) -> Schema:
    return {"type": "object", "additionalProperties": values}


def _worlds(registry: Registry) -> Schema:
    """A map's file with its loader's options, or a world to generate."""
    drawn = closed({**distribution(), "per": _PER})
    beside: Schema = {
        "seed": _SEED,
        "per": {"enum": ["study", "replica"], "description": "a world for all, or for each"},
    }
    worlds = []
    for name, cls in registered(registry, "world_generator"):
        table = table_schema(cls)
        fields = {key: {"anyOf": [field, drawn]} for key, field in table["properties"].items()}
        required = required_fields(cls)
        worlds.append(variant(name, {**table, "properties": {**beside, **fields}}, required, key="generate"))
    found: Schema = {"generated": {"type": "object", "oneOf": worlds}}
    loaders = registered(registry, "map_loader")
    path: Schema = {
        "description": "the path of a map's file, or a table of a world to generate",
        "anyOf": [{"type": "string", "minLength": 1}, ref("generated")],
    }
    options: dict[str, list[Schema]] = {}
    for _, cls in loaders:
        for key, field in file_fields(cls).items():
            if (schema := field_schema(key, field)) not in options.setdefault(key, []):
                options[key].append(schema)
    keys: Schema = {"map": path, "use": {"description": "name of a map loader", "enum": [name for name, _ in loaders]}}
    keys |= {key: fields[0] if len(fields) == 1 else {"anyOf": fields} for key, fields in options.items()}
    known = {"anyOf": [{"const": "world"}, _list({"anyOf": [_POINT, _alone(KnownLandmark)]})]}
    return {
        **found,
        "world": {**closed(keys, required=["map"], about="the map")},
        "knowledge": closed({**keys, "landmarks": known}, about="what the robot knows of the world"),
    }


def _robot(registry: Registry) -> Schema:
    looks = ("on_collision", *LOOKS)
    parts: Schema = {"sensors": "sensor", "estimators": "estimator"}
    properties: Schema = {
        "name": NAME,
        "model": model_schema("robot", registry),
        "resolved_from": {"type": "string", "description": "the model that it came from; has no effect"},
        "count": {
            "type": "integer",
            "minimum": 1,
            "maximum": MOST_BODIES,
            "description": "how many of these there are",
        },
        "pose": ref("pose"),
        "start": ref("start"),
        "shape": {"$ref": "#/$defs/shape"},
        "drive": ref("drive.part"),
        "sensors": _by_name({"anyOf": [{"const": False}, ref("sensor.part")]}),
        "ground": chain_schema("ground"),
        "estimators": _by_name({"anyOf": [{"const": False}, ref("estimator.part")]}),
        "controller": ref("controller.part"),
        "errors": closed(
            {"drive": _by_path(ref("error")), "sensors": _by_path(ref("error")), "pose": _by_path(ref("error"))},
            about="how true parameters differ from nominal ones",
        ),
        "initial_belief": _alone(InitialBelief),
        "kidnappings": _list(_alone(Kidnapping)),
        "knowledge": ref("knowledge"),
        **table_schema(Robot, names=looks)["properties"],
    }
    alone: Schema = {
        "properties": {
            "drive": ref("drive"),
            "controller": ref("controller"),
            **{key: _by_name({"anyOf": [{"const": False}, ref(kind)]}) for key, kind in parts.items()},
        },
        "required": ["shape", "drive"],
    }
    has_model = {"if": {"required": ["model"]}, "else": alone}
    return {
        **closed(properties, about="a robot: its model, where it starts, its errors and its software"),
        "allOf": [
            has_model,
            *(_if_model(name, registry) for name in _models(registry)),
            *(_if_drive(name, cls) for name, cls in registered(registry, "drive")),
        ],
    }


def _models(registry: Registry) -> list[str]:
    return [name for name in registry.names("robot") if read_layers(name, "robot", registry)[1] is not None]


def _if_model(name: str, registry: Registry) -> Schema:
    """What a table over this model may have: changes of the model's parts, and complete new parts."""
    _, model = read_layers(name, "robot", registry)
    assert model is not None
    drive = model["drive"]["use"]
    changes: Schema = {"drive": _change("drive", drive, registry)}
    changes["controller"] = _change("controller", _use(model.get("controller"), registry), registry)
    errors: Schema = {"drive": _errors_of(registry.get("drive", drive))}
    for key, kind in (("sensors", "sensor"), ("estimators", "estimator")):
        uses = {part: _use(table, registry) for part, table in model.get(key, {}).items()}
        changes[key] = {
            "properties": {part: _change(kind, use, registry) for part, use in uses.items()},
            "additionalProperties": {"anyOf": [{"const": False}, ref(kind)]},
        }
        if kind == "sensor":
            known = {part: _errors_of(registry.get("sensor", use), "mount") for part, use in uses.items() if use}
            errors["sensors"] = {"properties": known}
    is_kept = {"drive": _UNNAMED, "sensors": {"properties": dict.fromkeys(model.get("sensors", {}), _UNNAMED)}}
    then = {
        "properties": changes,
        "if": {"properties": is_kept},
        "then": {"properties": {"errors": {"properties": errors}}},
    }
    return {"if": {"properties": {"model": {"const": name}}, "required": ["model"]}, "then": then}


def _if_drive(name: str, cls: type) -> Schema:
    """The errors that a robot may have whose table names its drive."""
    drive = {"properties": {"use": {"const": name}}, "required": ["use"]}
    then = {"properties": {"errors": {"properties": {"drive": _errors_of(cls)}}}}
    return {"if": {"properties": {"drive": drive}, "required": ["drive"]}, "then": then}


def _use(table: Schema | None, registry: Registry) -> str:
    """The component named in a model's table, or in its device's; empty if there is none."""
    if table is not None and table.get("model") in registry.names("device"):
        table = read_layers(table["model"], "device", registry)[1]
    use = (table or {}).get("use", "")
    return use if isinstance(use, str) and ".py" not in use else ""


def _change(kind: str, use: str, registry: Registry) -> Schema:
    """A table without a component's name changes fields of the model's, if it has one; else it is complete."""
    if not use:
        return ref(kind)
    cls = registry.get(kind, use)
    table = table_schema(cls)
    if kind == "sensor":
        table = sensor_fields(cls)
        table["properties"] = {**mounted(registry), **table["properties"]}
    return {"if": {"type": "object", **_UNNAMED}, "then": table}


def _errors_of(cls: type, *beside: str) -> Schema:
    """Errors of a component of the model."""
    fields = {
        key: {"description": field.help, **ref("error_of_number" if field.type in (int, float) else "error")}
        for key, field in file_fields(cls).items()
    }
    return {"properties": {**fields, **{key: ref("error") for key in beside}}, "additionalProperties": False}


def _obstacle() -> Schema:
    properties = {
        "name": NAME,
        "count": {
            "type": "integer",
            "minimum": 1,
            "maximum": MOST_BODIES,
            "description": "how many of these there are",
        },
        "shape": ref("shape"),
        "pose": ref("pose"),
        "start": ref("start"),
        "motion": ref("motion"),
        **table_schema(Obstacle, names=LOOKS)["properties"],
    }
    return closed(properties, required=["shape"], about="a body that is not a robot")


def _zone() -> Schema:
    properties = {"name": NAME, "shape": ref("shape"), "pose": ref("pose"), "ground": chain_schema("ground")}
    return closed(properties, required=["shape"], about="a part of the floor with noise of its own for wheels")


def _floor() -> Schema:
    lines = ("points", "closed", "width", "reflectance", "colour")
    placed: Schema = {"shape": ref("shape"), "pose": ref("pose")}
    marking = table_schema(Marking, names=lines, beside=placed)
    drop = {**table_schema(Drop, names=("depth",), beside=placed), "required": ["shape"]}
    beside: Schema = {"markings": _list(marking), "drops": _list(drop)}
    return table_schema(Floor, names=("reflectance",), beside=beside)
