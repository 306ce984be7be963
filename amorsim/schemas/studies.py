"""The JSON Schemas of the files of studies and rubrics."""

from __future__ import annotations

from amorsim.core.parameters import describe
from amorsim.plugins.registry import Registry
from amorsim.scenario.spec import Scenario
from amorsim.schemas.components import in_a_file, registered, variant
from amorsim.schemas.fields import Schema, closed, field_schema, required_fields, table_schema
from amorsim.schemas.scenario import FORMAT_SCHEMA
from amorsim.simulation.simulation import MAX_REPLICA
from amorsim.sweeps.read import STOPS

__all__ = ["rubric_schema", "study_schema"]

_SCENARIO: Schema = {"type": "string", "minLength": 1, "description": "a bundled scenario, or the path of a file"}
_DURATION: Schema = {"type": "number", "exclusiveMinimum": 0, "description": "in place of the scenario's [s]"}
_NAMES: Schema = {"type": "array", "items": {"type": "string", "minLength": 1}, "minItems": 1}
_NUMBER: Schema = {"type": "number"}
_PAIR: Schema = {"type": "array", "items": _NUMBER, "minItems": 2, "maxItems": 2}


def study_schema(registry: Registry) -> Schema:
    """The schema of a study for `amorsim sweep`."""
    seed = field_schema("seed", describe(Scenario)["seed"])
    return {
        "type": "object",
        "properties": {
            "format": FORMAT_SCHEMA,
            "description": {"type": "string"},
            "scenario": _SCENARIO,
            "replicas": {"type": "integer", "minimum": 1, "maximum": MAX_REPLICA + 1},
            "seeds": {"type": "array", "items": seed, "minItems": 1, "uniqueItems": True},
            "duration": _DURATION,
            "stop": {"enum": list(STOPS), "description": "when an episode ends before its duration"},
            "axes": {
                "description": "paths of the scenario's values, and the values that each takes",
                "type": "object",
                "additionalProperties": {"$ref": "#/$defs/axis"},
            },
            "metrics": {**_metrics(registry, {}, files=True), "minProperties": 1},
        },
        "required": ["format", "scenario", "metrics"],
        "additionalProperties": False,
        "$defs": {"axis": _axis()},
    }


def _axis() -> Schema:
    """A list of values, a range, draws, variants, or a table of more axes."""
    count = {"type": "integer", "minimum": 1}
    ends = {"from": _NUMBER, "to": _NUMBER}
    tables: list[Schema] = [
        closed({"values": {"type": "array", "minItems": 1}}, required=["values"]),
        closed({"variants": {"type": "object", "minProperties": 1}}, required=["variants"]),
        closed({**ends, "count": count}, required=["from", "to", "count"]),
        closed({**ends, "step": _NUMBER}, required=["from", "to", "step"]),
    ]
    for kind in ("normal", "uniform"):
        drawn = {kind: _PAIR, "count": count, "seed": {"type": "integer", "minimum": 0}}
        tables.append(closed(drawn, required=[kind]))
    own = ("values", "variants", "from", "to", "count", "step", "normal", "uniform")
    more: Schema = {
        "type": "object",
        "propertyNames": {"not": {"enum": list(own)}},
        "additionalProperties": {"$ref": "#/$defs/axis"},
    }
    return {"anyOf": [{"type": "array", "minItems": 1}, *tables, more]}


def _metrics(registry: Registry, beside: Schema, *, files: bool) -> Schema:
    """A table of metrics, under any names."""
    robot = {"type": "string", "minLength": 1, "description": "the robot that is measured; without it, their mean"}
    keys: Schema = {"robot": robot, **beside}
    metrics = [
        variant(name, table_schema(cls, beside=keys), required_fields(cls))
        for name, cls in registered(registry, "metric")
    ]
    metric = {"type": "object", "oneOf": [*metrics, *(in_a_file("metric") if files else [])]}
    return {"description": "what is measured, by names of one's own", "type": "object", "additionalProperties": metric}


def rubric_schema(registry: Registry) -> Schema:
    """The schema of a rubric for `amorsim grade`."""
    pair = {"type": "array", "items": {"type": "number"}, "minItems": 2, "maxItems": 2}
    bound: Schema = {"anyOf": [{"type": "number"}, pair]}
    earned = {
        "points": {"type": "number", "minimum": 0, "default": 1.0, "description": "for a value that earns them all"},
        "none": {
            **bound,
            "default": 0.0,
            "description": "the value that earns no points; or two: too small, too large",
        },
        "full": {**bound, "default": 1.0, "description": "the value that earns all points; or the least and the most"},
        "given": {"type": "string", "description": "a criterion above it, without whose points it earns none"},
    }
    positive: Schema = {"type": "number", "exclusiveMinimum": 0}
    return {
        "type": "object",
        "properties": {
            "format": FORMAT_SCHEMA,
            "title": {"type": "string", "minLength": 1},
            "scenario": _SCENARIO,
            "robot": {"type": "string", "minLength": 1, "description": "the robot that submissions drive"},
            "role": {"enum": ["controller", "estimator"], "default": "controller"},
            "function": {"type": "string", "minLength": 1, "description": "the function or class in a submission"},
            "files": {**_NAMES, "description": "files that every submission is given"},
            "beside": {**_NAMES, "description": "names of files that go with a submission where they lie next to it"},
            "runs": {"type": "integer", "minimum": 1, "maximum": 10_000, "description": "runs in each world"},
            "practice": {"type": "boolean", "description": "seeds are known, and no marks depend on it"},
            "seeds": {"type": "array", "items": {"type": "integer", "minimum": 0}, "minItems": 1},
            "worlds": {**_NAMES, "description": "maps in place of the scenario's"},
            "duration": _DURATION,
            "time_limit": {**positive, "description": "of the processor, for one run [s]"},
            "memory_limit": {**positive, "description": "for one run [bytes]"},
            "criteria": {**_metrics(registry, earned, files=False), "minProperties": 1},
            "questions": {"type": "string", "minLength": 1, "description": "the file of questions and their answers"},
        },
        "required": ["format", "scenario", "criteria"],
        "additionalProperties": False,
        "if": {"properties": {"practice": {"const": True}}, "required": ["practice"]},
        "then": {"properties": {"runs": False}},
        "else": {"properties": {"seeds": False}},
    }
