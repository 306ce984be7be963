"""Components made from their classes alone, and copies of one in which every number differs."""

from __future__ import annotations

import math
import types
import typing
from typing import Any, TypeVar

import attrs
import numpy as np

from amorsim.core.arguments import checked
from amorsim.core.errors import ComponentError
from amorsim.core.parameters import Parameter, describe
from amorsim.core.rows import signature
from amorsim.planners import AStar

__all__ = ["example", "variants"]

T = TypeVar("T")


def example(cls: type[T], **given: Any) -> T:
    """A component of a class: its fields are as `given`, else their defaults, else values that should be valid.

    Raises
    ------
    ComponentError
        If no value can be thought of for a field, or the class refuses the values; give such fields by name.
    """
    for name, parameter in describe(cls).items():
        if parameter.is_required and name not in given:
            is_planner = parameter.component == "planner" and not parameter.is_optional
            given[name] = AStar() if is_planner else _value(cls, parameter, parameter.type)
    try:
        return cls(**given)
    except ValueError as error:
        raise ComponentError(
            f"{cls.__name__} takes none of {given}: {error}. Make one yourself, and give it in place of its class"
        ) from error


def _value(cls: type, parameter: Parameter, kind: Any) -> Any:
    if typing.get_origin(kind) in (types.UnionType, typing.Union):
        options = typing.get_args(kind)
        return None if types.NoneType in options else _value(cls, parameter, options[0])
    if typing.get_origin(kind) is tuple:
        items = typing.get_args(kind)
        return tuple(
            _value(cls, parameter, item) for item in (items[:1] * 2 if len(items) == 2 and items[1] is ... else items)
        )
    if isinstance(kind, type) and attrs.has(kind):
        return example(kind)
    if parameter.choices:
        return parameter.choices[0]
    if kind is bool:
        return False
    if kind in (float, int):
        return kind(_number(parameter))
    raise ComponentError(
        f"{cls.__name__}: there is no telling what its field {parameter.name!r} ({parameter.type_name}) takes; "
        "make one yourself, and give it in place of its class"
    )


def _number(parameter: Parameter) -> float:
    lows = [bound for bound in (parameter.gt, parameter.ge) if bound is not None]
    highs = [bound for bound in (parameter.lt, parameter.le) if bound is not None]
    if lows and highs:
        middle = 0.5 * (max(lows) + min(highs))
        return math.ceil(middle) if parameter.type is int else middle
    if lows:
        return max(lows) + 1.0
    return min(highs) - 1.0 if highs else 1.0


@checked
def variants(component: T, count: int) -> list[T]:
    """The component and copies of it, `count` in all, whose numbers differ a little, within their bounds.

    Static fields, texts and flags stay, so that all are rows of one group. Where a class refuses a copy, it is nearer
    to the original; the same copies come every time.
    """
    made = [component]
    for row in range(1, count):
        made.append(_variant(component, row))
    return made


def _variant(component: T, row: int) -> T:
    for spread in (0.1, 0.02, 0.002):
        random = np.random.default_rng(row)
        try:
            changed: T = _changed(component, random, spread)
        except ValueError:
            continue
        if signature(changed) == signature(component):
            return changed
    return component


def _changed(component: Any, random: np.random.Generator, spread: float) -> Any:
    values: dict[str, Any] = {}
    fields = attrs.fields_dict(type(component))
    for name, parameter in describe(type(component)).items():
        if not parameter.static:
            values[fields[name].alias or name] = _near(parameter, getattr(component, name), random, spread)
    return attrs.evolve(component, **values)


def _near(parameter: Parameter, value: Any, random: np.random.Generator, spread: float) -> Any:
    if isinstance(value, tuple):
        return tuple(_near(parameter, item, random, spread) for item in value)
    if attrs.has(type(value)):
        return _changed(value, random, spread)
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        return value
    if isinstance(value, int):
        near: float = value + int(random.integers(-1, 2))
    else:
        # Of few sizes, so that the engine may treat alike rows alike.
        step = spread * (float(random.integers(-2, 3)) / 2.0)
        near = value * (1.0 + step) if value else step
    for candidate in (near, 2 * value - near):  # at a bound, the other side is open
        if _within(parameter, candidate):
            return candidate
    return value


def _within(parameter: Parameter, value: float) -> bool:
    return (
        (parameter.gt is None or value > parameter.gt)
        and (parameter.ge is None or value >= parameter.ge)
        and (parameter.lt is None or value < parameter.lt)
        and (parameter.le is None or value <= parameter.le)
    )
