"""Values as JSON: those of a component's fields, sent to a window and received from it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import attrs

from amorsim.core.errors import AmorsimError
from amorsim.core.parameters import Parameter, describe
from amorsim.plugins.manager import default_registry
from amorsim.scenario.spec import Distribution

__all__ = ["deviation_of", "field_plain", "number_of", "plain"]


def plain(value: Any) -> Any:
    """A value as JSON has it: lists for tuples, tables for nested classes and distributions."""
    if isinstance(value, Distribution):
        return {value.kind: list(value.values)}
    if isinstance(value, Mapping):
        return {str(key): plain(part) for key, part in value.items()}
    if isinstance(value, (tuple, list)):
        return [plain(part) for part in value]
    if attrs.has(type(value)):
        return {name: field_plain(parameter, getattr(value, name)) for name, parameter in describe(type(value)).items()}
    if value is None or isinstance(value, (bool, int, float, str)):
        return value
    return str(value)  # dates and the like, which no field takes


def field_plain(parameter: Parameter, value: Any) -> Any:
    """A field's value as JSON; of a component, with its registered name under ``use``."""
    if not parameter.component or value is None:
        return plain(value)
    name = default_registry().name_of(parameter.component, type(value))
    return {"use": name or type(value).__name__, **plain(value)}


def number_of(value: Any) -> Any:
    """A number as a window sends it: ``{"normal": [1, 0.1]}`` is a distribution; anything else is returned as it is.

    Raises
    ------
    AmorsimError
        If such a table is none of a distribution.
    """
    if not isinstance(value, Mapping):
        return value
    (kind, values), *others = [*value.items(), ("", ())]
    if len(others) != 1 or not isinstance(values, (list, tuple)):
        raise AmorsimError("expected {normal = [MEAN, STANDARD DEVIATION]} or {uniform = [LOW, HIGH]}")
    return Distribution(kind=kind, values=tuple(values))


def deviation_of(table: Mapping[str, Any]) -> dict[str, Any]:
    """The parts of an error as `Simulation.set` takes them, of a table that a window gives."""
    return {str(name): number_of(part) for name, part in table.items()}
