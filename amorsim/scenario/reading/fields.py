"""The fields of a component, in a table of a file: read and checked, and written again.

A field is spelt as in Python, an angle in degrees as ``<name>_deg``. A list stands for a tuple, a table for a
nested class, ``"none"`` for None where a field admits it. Nothing is coerced; an int may stand for a float.
"""

from __future__ import annotations

import math
import os
import types
import typing
from collections.abc import Iterable, Mapping
from typing import Any

import attrs

from amorsim.core.error_text import RAISED, error_in_words, in_words
from amorsim.core.errors import PluginError
from amorsim.core.parameters import Parameter, ParameterError, check_value, describe
from amorsim.core.user_code import UserCode
from amorsim.plugins.manager import default_registry
from amorsim.plugins.registry import Registry
from amorsim.scenario.programs.controller_files import reference_of_class
from amorsim.scenario.programs.user_components import USER_CODE, program_in, read_program_in
from amorsim.scenario.reading.faults import Node, shown
from amorsim.scenario.toml.angles import to_degrees, to_radians

__all__ = [
    "NONE",
    "default_in_file",
    "file_fields",
    "in_file",
    "read_component",
    "read_fields",
    "write_component",
    "write_fields",
]

NONE = "none"
_MOST = 2**63 - 1
_BAD: Any = object()


def file_fields(cls: type, sensor_unit: str = "", names: Iterable[str] | None = None) -> dict[str, Parameter]:
    """The parameters of a class by their keys in files; the unit ``"sensor"`` becomes the sensor's."""
    found = {}
    for name, parameter in describe(cls).items():
        if names is not None and name not in names:
            continue
        if parameter.unit == "sensor":
            parameter = attrs.evolve(parameter, unit=sensor_unit)
        found[f"{name}_deg" if parameter.is_angle else name] = parameter
    return found


def read_component(cls: type, node: Node, *, sensor_unit: str = "", beside: tuple[str, ...] = ()) -> Any:
    """An instance of `cls` from a table, or None after faults; `beside` are keys that are not fields."""
    if not node.expect_table():
        return None
    fields = file_fields(cls, sensor_unit)
    node.refuse_unknown((*beside, *fields))
    before = node.book.count
    values = read_fields(node, fields, skip=beside)
    if node.book.count > before:
        return None
    try:
        return cls(**values)
    except ParameterError as error:
        names = [key for key, parameter in fields.items() if parameter.name == error.name]
        (node.child(names[0]) if names else node).fault(error.problem if names else str(error))
    except RAISED as error:  # a third party's own checks
        node.fault(f"{cls.__name__} refuses these values: {error_in_words(error)}")
    return None


def read_fields(node: Node, fields: Mapping[str, Parameter], skip: tuple[str, ...] = ()) -> dict[str, Any]:
    """The values of a table's fields by their names in Python, in SI units; those at fault are left out."""
    values = {}
    for key, parameter in fields.items():
        if key in skip:
            continue
        child = node.child(key)
        if key not in node:
            if parameter.is_required:
                about = f" ({parameter.help})" if parameter.help else ""
                expected = parameter.file_type_name if parameter.component else in_file(key, parameter).expectation
                child.fault(f"missing; expected {expected}{about}")
            continue
        value = _read(child, key, parameter)
        if value is not _BAD:
            values[parameter.name] = value
    return values


def in_file(key: str, parameter: Parameter) -> Parameter:
    """The parameter as the file has it: an angle's bounds and unit in degrees."""
    if not parameter.is_angle:
        return parameter if parameter.name == key else attrs.evolve(parameter, name=key)
    bounds: dict[str, Any] = {
        name: None if bound is None else to_degrees(bound)
        for name, bound in (
            ("gt", parameter.gt),
            ("ge", parameter.ge),
            ("lt", parameter.lt),
            ("le", parameter.le),
        )
    }
    return attrs.evolve(parameter, name=key, unit=parameter.unit.replace("rad", "deg", 1), **bounds)


def _read(node: Node, key: str, parameter: Parameter) -> Any:
    if parameter.component:
        return _read_component_of(node, parameter)
    expected = in_file(key, parameter)
    before = node.book.count
    value = _native(node, parameter.type)
    if node.book.count > before:
        return _BAD
    if _is_oversized(value):
        node.fault(f"expected {expected.expectation}, got {shown(node.value)}")
        return _BAD
    try:
        check_value(expected, value)
        value = _map_numbers(to_radians, value) if parameter.is_angle else _plain(parameter.type, value)
        if parameter.file and value:
            # As for maps: what a link is called is the user's.
            value = os.path.abspath(node.folder / value)  # noqa: PTH100
        if expected is not parameter:
            check_value(parameter, value)
    except ParameterError as error:
        problem = error.problem.replace(f"got {in_words(value)}", f"got {shown(node.value)}")
        node.fault(problem if len(problem) < 500 else f"{problem[:500]}...")
        return _BAD
    return value


def _read_component_of(node: Node, parameter: Parameter) -> Any:
    """The component in a table with ``use = NAME``, for a field that holds one."""
    kind, registry = parameter.component, default_registry()
    if parameter.is_optional and node.value == NONE:
        return None
    table = f"a table with use = one of: {', '.join(registry.names(kind))}"
    if not node.expect_table(f'{table}, or "{NONE}"' if parameter.is_optional else table):
        return _BAD
    if program_in(node) and issubclass(USER_CODE[kind], parameter.contract):
        own = read_program_in(node, kind)
        return _BAD if own is None else own
    name = node.child("use").text(f"the name of a {kind}")
    if name is None:
        return _BAD
    try:
        cls = registry.get(kind, name)
    except PluginError as error:
        node.child("use").fault(str(error))
        return _BAD
    if not issubclass(cls, parameter.contract):
        fitting = [other for other in registry.names(kind) if issubclass(registry.get(kind, other), parameter.contract)]
        node.child("use").fault(f"the {kind} {name!r} cannot be used here; expected one of: {', '.join(fitting)}")
        return _BAD
    found = read_component(cls, node, beside=("use",))
    return _BAD if found is None else found


def _native(node: Node, kind: Any) -> Any:
    """The value with tuples and nested classes where the type has them; the rest stays as it is."""
    value = node.value
    if isinstance(kind, type):
        return read_component(kind, node) if isinstance(value, dict) and attrs.has(kind) else value
    if isinstance(kind, types.UnionType) or typing.get_origin(kind) is typing.Union:
        options = typing.get_args(kind)
        if value == NONE and types.NoneType in options:
            return None
        fitting = [option for option in options if _fits(option, value)]
        return _native(node, fitting[0]) if fitting else value
    if typing.get_origin(kind) is tuple and isinstance(value, list):
        items = typing.get_args(kind)
        if len(items) == 2 and items[1] is Ellipsis:
            items = (items[0],) * len(value)
        if len(items) != len(value):
            return tuple(value)
        return tuple(_native(child, item) for child, item in zip(node.items(), items, strict=True))
    return value


def _fits(kind: Any, value: Any) -> bool:
    if typing.get_origin(kind) is tuple:
        return isinstance(value, list)
    return isinstance(kind, type) and attrs.has(kind) and isinstance(value, dict)


def _is_oversized(value: Any) -> bool:
    # The engine's whole numbers have 64 bits, and beyond 1e308 an int has no float either.
    if isinstance(value, dict):
        value = tuple(value.values())
    if isinstance(value, (tuple, list)):
        return any(_is_oversized(item) for item in value)
    return isinstance(value, int) and not -_MOST <= value <= _MOST


def _map_numbers(function: Any, value: Any) -> Any:
    if isinstance(value, tuple):
        return tuple(_map_numbers(function, item) for item in value)
    return function(value) if isinstance(value, (int, float)) and not isinstance(value, bool) else value


def _plain(kind: Any, value: Any) -> Any:
    """The value with a float wherever the type has one: an int there would make another kind of array."""
    if isinstance(kind, types.UnionType) or typing.get_origin(kind) is typing.Union:
        options = [option for option in typing.get_args(kind) if option is not types.NoneType]
        if value is None or (isinstance(value, int) and int in options):
            return value
        if isinstance(value, tuple):
            options = [option for option in options if typing.get_origin(option) is tuple]
        return _plain(options[0], value) if options else value
    if typing.get_origin(kind) is tuple and isinstance(value, tuple):
        items = typing.get_args(kind)
        if len(items) == 2 and items[1] is Ellipsis:
            items = (items[0],) * len(value)
        return tuple(_plain(item, part) for item, part in zip(items, value, strict=True)) if items else value
    if kind is float and isinstance(value, (int, float)) and not isinstance(value, bool):
        return float(value) if type(value) is not float else value
    return value


def write_component(kind: str, component: Any, registry: Registry, unit: str = "") -> dict[str, Any]:
    """The table of a component: its name in files, and its fields.

    Raises
    ------
    PluginError
        If no file can name it.
    ParameterError
        If that is so of a component within it.
    """
    if isinstance(component, UserCode):
        if component.source:
            return {"use": component.source, **dict(component.options)}
        name = getattr(component.function, "__qualname__", repr(component.function))
        raise PluginError(
            f"{name} was given as an object, so a file cannot name it; put it into a file of its own, and say use = "
            f"'FILE.py:{name}'"
        )
    name = registry.name_of(kind, type(component)) or (reference_of_class(type(component)) if kind in USER_CODE else "")
    if not name:
        what = f"{type(component).__module__}.{type(component).__qualname__}"
        remedy = "register it in a plugin" + (", or put it into a file of its own" if kind in USER_CODE else "")
        raise PluginError(f"{what} is not registered, so a file cannot name it; {remedy}")
    return {"use": name, **write_fields(component, unit)}


def write_fields(component: Any, sensor_unit: str = "", names: Iterable[str] | None = None) -> dict[str, Any]:
    """All fields of a component as in a file; a field is left out if it is None and that is its default."""
    written = {}
    for key, parameter in file_fields(type(component), sensor_unit, names).items():
        value = getattr(component, parameter.name)
        if value is None:
            if parameter.default is not None:
                written[key] = NONE
            continue
        written[key] = _write_value(value, parameter)
    return written


def _write_value(value: Any, parameter: Parameter) -> Any:
    if parameter.component and value is not None:
        try:
            return write_component(parameter.component, value, default_registry())
        except PluginError as error:
            raise ParameterError(parameter.name, str(error)) from None
    return _written(value, parameter.type, parameter.is_angle)


def default_in_file(parameter: Parameter) -> Any:
    """The default of a parameter as a file has it; None where a value must be given."""
    if parameter.is_required:
        return None
    if parameter.default is None:
        return NONE if parameter.is_optional else None
    return _write_value(parameter.default, parameter)


def _written(value: Any, kind: Any, is_angle: bool) -> Any:
    if isinstance(value, tuple):
        return [_written(item, kind, is_angle) for item in value]
    if attrs.has(type(value)):
        return write_fields(value)
    if is_angle and isinstance(value, (int, float)) and not isinstance(value, bool):
        return to_degrees(value)
    # A component built in Python may hold an int where a float is meant.
    if isinstance(value, int) and not isinstance(value, bool) and _is_float(kind) and abs(value) <= 2**53:
        return float(value)
    return float(value) if isinstance(value, float) and not math.isnan(value) else value


def _is_float(kind: Any) -> bool:
    args = typing.get_args(kind)
    return any(_is_float(option) for option in args) and int not in args if args else kind is float
