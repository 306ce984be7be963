"""Parameters of components: attrs fields with units, bounds and help.

The scenario file, the command line, forms and reference pages are all made from `describe`.
"""

from __future__ import annotations

import math
import sys
import types
import typing
from collections.abc import Mapping
from typing import Any

import attrs

from amorsim.core.error_text import in_words
from amorsim.core.errors import AmorsimError, ComponentError

__all__ = [
    "COMPONENTS",
    "FRAMES",
    "LARGEST",
    "LARGEST_WHOLE",
    "REFERS",
    "SMALLEST",
    "Parameter",
    "ParameterError",
    "check_value",
    "describe",
    "own_first",
    "parameter",
]

LARGEST = 1e12
"""No number of a component is larger, whatever its unit: squares and products of such numbers keep all their digits."""
SMALLEST = 1e-12
"""No number that must be above 0 is smaller."""
LARGEST_WHOLE = 2**53
"""No whole number without bounds of its own is larger."""

FRAMES = ("world", "body")
"""The possible values of a parameter's `frame`."""
COMPONENTS = ("planner", "controller", "estimator", "motion", "task")
"""The kinds of component that a parameter may be."""
REFERS = ("sensors", "estimators", "joints")
"""The kinds of things that a parameter may refer to by name."""

_KEY = "amorsim"
_REQUIRED: Any = attrs.NOTHING


class ParameterError(AmorsimError, ValueError):
    """A value that a parameter does not accept; `name` is the parameter, `problem` the fault of the value."""

    def __init__(self, name: str, problem: str) -> None:
        self.name = name
        self.problem = problem
        super().__init__(f"{name}: {problem}")


@attrs.frozen(kw_only=True)
class Parameter:
    """One parameter of a component, as its field declares it.

    `unit` is ``""`` for a pure number and ``"sensor"`` if it is that of the component's sensor.
    `static` parameters fix shapes (a number of beams): rows that differ in one belong to different groups.
    `live` parameters may change between steps. A `file` is a path: in a scenario, relative to the scenario's folder;
    a run's folder gets a copy of the file. `frame` is where points are: ``"world"``, ``"body"`` (the frame of the
    robot or of what it is part of), or ``""`` for what is not a point. `refers` is what a text is the name of: one of
    the robot's ``"sensors"``, ``"estimators"`` or ``"joints"``. `component` is the kind of a value that is a component
    itself, one of `COMPONENTS`; files give it as a table with ``use = NAME``. Annotated with ``| None``, there may be
    none.
    """

    name: str
    type: Any
    default: Any = _REQUIRED
    unit: str = ""
    help: str = ""
    gt: float | None = None
    ge: float | None = None
    lt: float | None = None
    le: float | None = None
    choices: tuple[str, ...] = ()
    static: bool = False
    live: bool = True
    file: bool = False
    frame: str = ""
    refers: str = ""
    component: str = ""

    @property
    def is_required(self) -> bool:
        """Whether a value must be given."""
        return self.default is _REQUIRED

    @property
    def is_optional(self) -> bool:
        """Whether its value may be None."""
        return types.NoneType in typing.get_args(self.type)

    @property
    def contract(self) -> Any:
        """The class of the components that it may be: its type, without None."""
        options = [option for option in typing.get_args(self.type) if option is not types.NoneType]
        return options[0] if self.is_optional and len(options) == 1 else self.type

    @property
    def is_angle(self) -> bool:
        """Whether files give it in degrees, in a key that ends in ``_deg``."""
        return self.unit.split("/")[0] == "rad"

    @property
    def type_name(self) -> str:
        """The kind of value it takes, in words."""
        return _type_name(self.type)

    @property
    def file_type_name(self) -> str:
        """The kind of value it takes in a file, in words: a component is a table there, with the key ``use``."""
        if self.component:
            table = f"a table with use = the name of a {self.component}"
            return f'{table}, or "none"' if self.is_optional else table
        return _type_name(self.type, in_file=True)

    @property
    def bounds(self) -> str:
        """The bounds in words; empty if there are none."""
        if self.choices:
            return "one of " + ", ".join(repr(choice) for choice in self.choices)
        parts = [
            f"{sign} {bound:g}"
            for sign, bound in ((">", self.gt), (">=", self.ge), ("<", self.lt), ("<=", self.le))
            if bound is not None
        ]
        return " and ".join(parts)

    @property
    def expectation(self) -> str:
        """The expected value in words: type, unit and bounds."""
        unit = f" [{self.unit}]" if self.unit not in ("", "sensor") else ""
        options = [option for option in typing.get_args(self.type) if option not in (str, types.NoneType)]
        if self.choices and options and str in typing.get_args(self.type):  # a word, or else a quantity
            return " or ".join([*map(repr, self.choices), *map(_type_name, options)]) + unit
        return f"{self.type_name}{unit}" + (f" {self.bounds}" if self.bounds else "")


def parameter(
    default: Any = _REQUIRED,
    *,
    unit: str = "",
    help: str = "",  # noqa: A002 - the word that users of the field read
    gt: float | None = None,
    ge: float | None = None,
    lt: float | None = None,
    le: float | None = None,
    choices: tuple[str, ...] = (),
    static: bool = False,
    live: bool = True,
    file: bool = False,
    frame: str = "",
    refers: str = "",
    component: str = "",
) -> Any:
    """A field of a component class: a default (or none, then it must be given), its unit, help and bounds.

    Values are checked when a component is made: the type as annotated (nothing is coerced, an int may stand for a
    float), finite, within bounds or among `choices`. Whatever the bounds, no number is larger than `LARGEST`, and none
    that must be above 0 smaller than `SMALLEST`. Annotations may be `float`, `int`, `bool`, `str`, any of these
    ``| None``, a tuple of them, another attrs class with such fields, or a tuple of those (the elements of a ring). A
    field that is a component itself names its kind in `component` and is annotated with a contract, as `am.Planner`, or
    `am.Planner | None` where there may be none.
    """
    for name, given in (("static", static), ("live", live), ("file", file)):
        if not isinstance(given, bool):
            raise ParameterError(name, f"expected True or False, got {in_words(given)}")
    metadata = {
        "unit": unit,
        "help": help,
        "gt": gt,
        "ge": ge,
        "lt": lt,
        "le": le,
        "choices": choices,
        "static": static,
        "live": live and not static,
        "file": file,
        "frame": frame,
        "refers": refers,
        "component": component,
    }
    return attrs.field(default=default, validator=_validate, metadata={_KEY: metadata})


_described: dict[type, Mapping[str, Parameter]] = {}


def own_first(_: type, fields: list[Any]) -> list[Any]:
    """A class's own fields before those it inherits, for forms and pages: attrs' hook `field_transformer`."""
    return sorted(fields, key=lambda field: field.inherited)


def describe(cls: type) -> Mapping[str, Parameter]:
    """The parameters of a component class by name, in the order of its fields."""
    if cls not in _described:
        _described[cls] = types.MappingProxyType(_describe(cls))
    return _described[cls]


def _describe(cls: type) -> dict[str, Parameter]:
    hints = typing.get_type_hints(cls)
    found = {}
    for field in attrs.fields(cls):
        if not field.init:  # internal to a recorder
            continue
        if field.name not in hints:
            words = f"field {field.name!r} of {cls.__name__} has no annotation, such as {field.name}: float"
            raise ComponentError(words)
        default = field.default
        if isinstance(default, attrs.Factory):  # type: ignore[arg-type]
            # A default that depends on other fields is not known beforehand.
            default = None if default.takes_self else default.factory()
        found[field.name] = Parameter(
            name=field.name, type=hints[field.name], default=default, **field.metadata.get(_KEY, {})
        )
    return found


def _validate(instance: Any, attribute: attrs.Attribute[Any], value: Any) -> None:
    check_value(describe(type(instance))[attribute.name], value)


def check_value(expected: Parameter, value: Any) -> None:
    """Raise `ParameterError` unless the parameter accepts `value`."""
    problem = _problem(expected, expected.type, value)
    if problem:
        raise ParameterError(expected.name, problem)


_ELEMENT = " (element "


def _problem(expected: Parameter, kind: Any, value: Any) -> str:
    return _of_one(expected, kind, value) if isinstance(kind, type) else _of_several(expected, kind, value)


def _of_several(expected: Parameter, kind: Any, value: Any) -> str:
    """The problem with a value of several possible kinds, or of several elements."""
    if isinstance(kind, types.UnionType) or typing.get_origin(kind) is typing.Union:
        options = [option for option in typing.get_args(kind) if option is not types.NoneType]
        if value is None and len(options) < len(typing.get_args(kind)):
            return ""
        problems = [_problem(expected, option, value) for option in options]
        return "" if "" in problems else problems[0]
    if typing.get_origin(kind) is tuple:
        items = typing.get_args(kind)
        if isinstance(value, list):
            return f"{_wrong(expected, value)}: in Python write a tuple, in round brackets"
        if not isinstance(value, tuple):
            return _wrong(expected, value)
        if len(items) == 2 and items[1] is Ellipsis:
            items = (items[0],) * len(value)
        if len(items) != len(value):
            return f"{_wrong(expected, value)}: it has {len(value)} elements, not {len(items)}"
        for place, (item, element) in enumerate(zip(items, value, strict=True)):
            if problem := _problem(expected, item, element):
                # One place, however deep: element 0.1 is number 1 of number 0.
                head, _, inner = problem.rpartition(_ELEMENT)
                return f"{head}{_ELEMENT}{place}.{inner}" if head else f"{problem}{_ELEMENT}{place})"
        return ""
    return _of_one(expected, kind, value)


def _of_one(expected: Parameter, kind: Any, value: Any) -> str:
    if kind is float:
        is_number = isinstance(value, (int, float)) and not isinstance(value, bool)
        # An int too large for a float is as good as infinite.
        if not is_number or abs(value) > sys.float_info.max or not math.isfinite(value):
            return _wrong(expected, value)
    elif kind is int:
        if not isinstance(value, int) or isinstance(value, bool):
            return _wrong(expected, value)
    elif isinstance(kind, type) and not isinstance(value, kind):
        return _wrong(expected, value)
    if expected.choices and isinstance(value, str) and value not in expected.choices:
        return _wrong(expected, value)
    if isinstance(value, (int, float)) and not isinstance(value, bool):
        low = (expected.gt is None or value > expected.gt) and (expected.ge is None or value >= expected.ge)
        high = (expected.lt is None or value < expected.lt) and (expected.le is None or value <= expected.le)
        if not (low and high):
            return _wrong(expected, value)
        largest = LARGEST_WHOLE if kind is int else LARGEST
        if abs(value) > largest and expected.le is None and expected.lt is None:
            return f"expected {expected.expectation}, of {largest:g} at most, got {in_words(value)}"
        if expected.gt == 0 and value < SMALLEST:
            return f"expected {expected.expectation}, of {SMALLEST:g} at least, got {in_words(value)}"
    return ""


def _wrong(expected: Parameter, value: Any) -> str:
    return f"expected {expected.expectation}, got {in_words(value)}"


_WORDS = {float: "a number", int: "a whole number", bool: "true or false", str: "a text"}


def _type_name(kind: Any, in_file: bool = False) -> str:
    if isinstance(kind, types.UnionType) or typing.get_origin(kind) is typing.Union:
        return " or ".join(
            "nothing" if option is types.NoneType else _type_name(option, in_file) for option in typing.get_args(kind)
        )
    if typing.get_origin(kind) is tuple:
        items = typing.get_args(kind)
        if len(items) == 2 and items[1] is Ellipsis:
            return f"a list, each {_type_name(items[0], in_file)}"
        return f"a list of {len(items)}, each {_type_name(items[0], in_file)}"
    if attrs.has(kind):
        angles = {name for name, field in describe(kind).items() if in_file and field.is_angle}
        names = [field.name for field in attrs.fields(kind)]
        return "a table of " + ", ".join(f"{name}_deg" if name in angles else name for name in names)
    return _WORDS.get(kind, getattr(kind, "__name__", str(kind)))
