"""The JSON Schema of a component's fields, from their declarations."""

from __future__ import annotations

import types
import typing
from collections.abc import Callable
from typing import Any

import attrs

from amorsim.core.parameters import LARGEST, LARGEST_WHOLE, Parameter, ParameterError
from amorsim.scenario.reading.fields import NONE, default_in_file, file_fields, in_file

__all__ = ["Schema", "closed", "field_schema", "required_fields", "table_schema"]

Schema = dict[str, Any]
_PLAIN: dict[Any, str] = {bool: "boolean", str: "string"}


def closed(properties: Schema, *, required: list[str] | None = None, about: str = "") -> Schema:
    """A table with these keys and no others."""
    return {
        **({"description": about} if about else {}),
        "type": "object",
        "properties": properties,
        **({"required": required} if required else {}),
        "additionalProperties": False,
    }


def _first_sentence(cls: type) -> str:
    """The first sentence of a class's docstring."""
    return (cls.__doc__ or "").strip().partition("\n\n")[0].replace("\n", " ").strip()


def table_schema(
    cls: type,
    *,
    unit: str = "",
    names: tuple[str, ...] | None = None,
    beside: Schema | None = None,
    about: str = "",
) -> Schema:
    """The table of a class's fields, all optional; `beside` are further keys, `unit` is its sensor's."""
    fields = {key: field_schema(key, parameter) for key, parameter in file_fields(cls, unit, names).items()}
    return {
        "description": about or _first_sentence(cls),
        "type": "object",
        "properties": {**(beside or {}), **fields},
        "additionalProperties": False,
    }


def required_fields(cls: type, unit: str = "") -> list[str]:
    """The keys of a class's fields that have no default."""
    return [key for key, parameter in file_fields(cls, unit).items() if parameter.is_required]


def field_schema(key: str, parameter: Parameter) -> Schema:
    """The value of one field as a file has it: an angle in degrees."""
    expected = in_file(key, parameter)
    value = _component(parameter) if parameter.component else _of_type(expected, expected.type)
    if parameter.help or expected.unit:
        unit = f" [{expected.unit}]" if expected.unit not in ("", "sensor") else ""
        value = {"description": f"{parameter.help}{unit}".strip(), **value}
    try:
        default = default_in_file(parameter)
    except ParameterError:  # a component that no file can name
        return value
    return value if default is None else {**value, "default": default}


def _component(parameter: Parameter) -> Schema:
    """A field that holds a component."""
    value: Schema = {"$ref": f"#/$defs/{parameter.component}"}
    return {"anyOf": [value, {"const": NONE}]} if parameter.is_optional else value


def _of_type(parameter: Parameter, kind: Any) -> Schema:
    if isinstance(kind, types.UnionType) or typing.get_origin(kind) is typing.Union:
        options = [
            {"const": NONE} if option is types.NoneType else _of_type(parameter, option)
            for option in typing.get_args(kind)
        ]
        return {"anyOf": options}
    if typing.get_origin(kind) is tuple:
        return _of_tuple(typing.get_args(kind), lambda item: _of_type(parameter, item))
    if kind in (int, float):
        return {"type": "integer" if kind is int else "number", **_bounds(parameter, kind)}
    if kind in _PLAIN:
        choices: Schema = {"enum": list(parameter.choices)} if parameter.choices and kind is str else {}
        return {"type": _PLAIN[kind], **choices}
    if isinstance(kind, type) and attrs.has(kind):
        needed = required_fields(kind)
        return {**table_schema(kind), **({"required": needed} if needed else {})}
    return {}


def _of_tuple(items: tuple[Any, ...], schema_of: Callable[[Any], Schema]) -> Schema:
    if len(items) == 2 and items[1] is Ellipsis:
        return {"type": "array", "items": schema_of(items[0])}
    size = {"minItems": len(items), "maxItems": len(items)}
    if len(set(items)) == 1:
        return {"type": "array", "items": schema_of(items[0]), **size}
    return {"type": "array", "prefixItems": [schema_of(item) for item in items], **size}


def _bounds(parameter: Parameter, kind: type) -> Schema:
    """The bounds of a number; those of all numbers if it has none."""
    largest = LARGEST_WHOLE if kind is int else LARGEST
    found: Schema = {}
    if parameter.le is None and parameter.lt is None:
        found = {"minimum": -largest, "maximum": largest}
    own = (("exclusiveMinimum", "gt"), ("minimum", "ge"), ("exclusiveMaximum", "lt"), ("maximum", "le"))
    for key, name in own:
        if (bound := getattr(parameter, name)) is not None:
            found[key] = bound
    if parameter.gt is not None:
        found.pop("minimum", None)
    return found
