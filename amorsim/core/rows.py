"""Components over rows: many of one class as one, with arrays as fields whose first axis is the row."""

from __future__ import annotations

import functools
from collections.abc import Hashable, Sequence
from typing import Any, TypeVar

import attrs
import numpy as np
import numpy.typing as npt

from amorsim.array_types import AnyArray
from amorsim.core.arguments import checked
from amorsim.core.error_text import in_words
from amorsim.core.numbers import is_number
from amorsim.core.parameters import Parameter, ParameterError, describe

__all__ = ["signature", "stack", "take"]

T = TypeVar("T")


def _varies(parameter: Parameter, value: Any) -> bool:
    """Whether rows of one group may differ in this value: numbers may, unless they fix a shape."""
    if parameter.static:
        return False
    if isinstance(value, tuple):
        return bool(value) and (_is_table(value) or all(is_number(item) or attrs.has(type(item)) for item in value))
    return is_number(value) or attrs.has(type(value))


def _is_table(value: tuple[Any, ...]) -> bool:
    """Whether these are tuples of numbers of one length, such as points."""
    return len({len(item) if isinstance(item, tuple) else 0 for item in value}) == 1 and all(
        isinstance(item, tuple) and item and all(map(is_number, item)) for item in value
    )


def signature(component: Any) -> Hashable:
    """The key that components must share to be rows of one group: class, static fields, lengths of rings."""
    kind: Any = type(component)
    parts: list[Hashable] = [kind]
    for name, parameter in describe(kind).items():
        value = getattr(component, name)
        if type(value) is float and not parameter.static:
            parts.append(name)  # as by the rules below; a short cut, because most values are floats
        elif not _varies(parameter, value):
            parts.append((name, value))
        elif isinstance(value, tuple):
            inner: Any = signature(value[0]) if attrs.has(type(value[0])) else type(None)
            if isinstance(value[0], tuple):
                inner = len(value[0])
            parts.append((name, len(value), inner))
        elif attrs.has(type(value)):
            parts.append((name, signature(value)))
        else:
            parts.append(name)
    return tuple(parts)


@checked
def stack(components: Sequence[T]) -> T:
    """One component of the same class whose numbers are read-only arrays over the rows.

    A number becomes `(N, 1)`, so that ``values * self.scale`` broadcasts; a tuple of k numbers `(N, k)`, of k tuples of
    m numbers `(N, k, m)`; a nested table one of such arrays; a tuple of k tables one table of `(N, k)` arrays.
    Everything else stays as it is and is equal in all rows (`signature`). The fields were checked when each row's own
    component was made.
    """
    components = list(components)
    if not components or not all(attrs.has(type(one)) for one in components):
        raise ParameterError("components", f"expected one component at least, got {in_words(components)}")
    first = components[0]
    values = {}
    for name, parameter in describe(type(first)).items():
        column = [getattr(component, name) for component in components]
        values[name] = _stack_column(column, parameter) if _varies(parameter, column[0]) else column[0]
    return _assemble(type(first), values)


def _stack_column(column: list[Any], parameter: Parameter) -> Any:
    first = column[0]
    if isinstance(first, tuple) and attrs.has(type(first[0])):
        rows = [stack(items) for items in column]  # each field (k, 1)
        fields = {
            field.name: _frozen([np.ravel(getattr(row, field.name)) for row in rows])
            for field in attrs.fields(type(first[0]))
        }
        return _assemble(type(first[0]), fields)
    if attrs.has(type(first)):
        return stack(column)
    # As annotated, not as given: an int given for a float is a float in every row.
    dtype = np.float64 if "float" in str(parameter.type) else np.int64
    if isinstance(first, tuple):
        return _frozen(column, dtype)
    return _frozen(np.array(column, dtype=dtype)[:, None], dtype)


def _frozen(rows: Any, dtype: npt.DTypeLike = np.float64) -> AnyArray:
    array = np.ascontiguousarray(rows, dtype=dtype)
    array.flags.writeable = False
    return array


def _assemble(cls: type[T], values: dict[str, Any]) -> T:
    # Skips the validators: they check one row's numbers, and have done so already.
    made = cls.__new__(cls)
    for name, value in values.items():
        object.__setattr__(made, name, value)
    return made


def take(component: T, rows: npt.NDArray[np.intp]) -> T:
    """The same stacked component with only the given rows, in the given order."""
    values = {}
    kind: Any = type(component)
    for name in _field_names(kind):
        value = getattr(component, name)
        if isinstance(value, np.ndarray):
            value = value[rows]
            value.flags.writeable = False
        elif attrs.has(type(value)):
            value = take(value, rows)
        values[name] = value
    return _assemble(type(component), values)


@functools.cache
def _field_names(cls: Any) -> tuple[str, ...]:
    return tuple(field.name for field in attrs.fields(cls))
