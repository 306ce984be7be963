"""Forms as plain values: what a window needs to show and change the fields of a component.

`form_of` makes a description of any class whose fields are made with `amorsim.parameter`, a plugin's too, and
`web/shared/forms.js` shows it. Neither knows what the form is for.
"""

from __future__ import annotations

import types
import typing
from collections.abc import Mapping, Sequence
from typing import Any, Literal, NotRequired, TypedDict

import attrs

from amorsim.core.errors import PluginError
from amorsim.core.parameters import Parameter, describe
from amorsim.plugins.manager import default_registry
from amorsim.plugins.registry import Registry
from amorsim.scenario.reading.fields import NONE, default_in_file, file_fields, in_file, write_fields
from amorsim.scenario.spec import Deviation, Distribution
from amorsim.ui.forms.json_values import field_plain, plain

__all__ = [
    "Choice",
    "FieldForm",
    "Widget",
    "choices_of",
    "deviation_form",
    "form_of",
    "number_widget",
    "why_fixed",
    "why_part_fixed",
]

Spelling = Literal["python", "file"]
Names = Mapping[str, Sequence[str]]


class Widget(TypedDict):
    """How a value is shown and changed.

    `kind` is one of

    - ``number``: a number in `unit`, within `low` and `high`; `is_whole` if it has no fraction;
    - ``flag``: true or false;
    - ``choice``: one of `choices`;
    - ``text``;
    - ``file``: the path of a file;
    - ``name``: the name of one of the robot's `refers`; those that are known are `choices`;
    - ``list``: a list, each of its items an `item`; `columns` are their names where each has one;
    - ``table``: a list of rows of numbers, each an `item`, with a name for each of the `columns`;
    - ``form``: a table with `fields`;
    - ``forms``: a list of tables with `fields` each;
    - ``distribution``: a number, ``{"normal": [mean, standard deviation]}`` or ``{"uniform": [low, high]}``;
    - ``component``: a component of the kind `component`, one of `choices`, with the `fields` of the one that it is; its
      value is a table with ``use``, or none where it `is_optional`;
    - ``either``: what one of the `options` shows.

    An `is_optional` value may be none. A list with a `length` has that number of items; others may grow. `frame` is
    where points are, ``"world"`` or ``"body"``, for windows that show them on a map.
    """

    kind: str
    is_optional: bool
    unit: NotRequired[str]
    low: NotRequired[float | None]
    high: NotRequired[float | None]
    is_open: NotRequired[list[bool]]  # whether low and high themselves are left out
    is_whole: NotRequired[bool]
    choices: NotRequired[list[str]]
    refers: NotRequired[str]
    component: NotRequired[str]
    frame: NotRequired[str]
    item: NotRequired[Widget]
    columns: NotRequired[list[str]]
    length: NotRequired[int | None]
    fields: NotRequired[list[FieldForm]]
    options: NotRequired[list[Widget]]


class FieldForm(TypedDict):
    """A field of a form. `fixed` is the reason why its value cannot change now, and empty where it can."""

    path: str
    label: str
    help: str
    widget: Widget
    value: Any  # none where there is none, and none was given
    default: Any
    is_given: bool  # whether the value is given, and not only the default
    is_required: bool
    fixed: str


class Choice(TypedDict):
    """A component that can be chosen, with the form of its fields."""

    name: str
    help: str
    fields: list[FieldForm]


def form_of(
    cls: type,
    values: Any = None,
    *,
    spelling: Spelling = "python",
    sensor_unit: str = "",
    names: Names | None = None,
    path: str = "",
    is_running: bool = False,
    registry: Registry | None = None,
) -> list[FieldForm]:
    """The fields of a component class as a form, in their order.

    Parameters
    ----------
    values
        A component, or a table of its values; nothing for the defaults alone.
    spelling
        ``"python"``: names and values as in Python, angles in radians. ``"file"``: as in scenario files, angles in
        degrees under names that end in ``_deg``.
    sensor_unit
        The unit of fields whose unit is their sensor's.
    names
        What fields can refer to: ``{"sensors": ["laser"], "estimators": [...], "joints": [...]}``.
    path
        Where the table is; it begins the path of each field.
    is_running
        Whether the component is part of a running simulation, in which not everything can change.
    registry
        Of the components that fields can be.
    """
    made = _Maker(spelling, sensor_unit, names or {}, is_running, registry or default_registry())
    return made.fields(cls, values, path)


def deviation_form(
    target: Parameter, deviation: Deviation | None, *, path: str, sensor_unit: str = ""
) -> list[FieldForm]:
    """The form of the error of a parameter: a factor, a sum or another value, fixed or drawn, and who draws."""
    unit = sensor_unit if target.unit == "sensor" else target.unit
    fields = form_of(Deviation, deviation or Deviation(), path=path)
    words = {"scale": "the nominal value times this", "add": "and this added", "value": "in place of the nominal value"}
    for field in fields:
        name = field["path"].rpartition(".")[2]
        field["is_given"] = deviation is not None and field["value"] != field["default"]
        field["help"] = words.get(name, field["help"])
        if field["widget"]["kind"] == "distribution":
            field["widget"]["unit"] = "×" if name == "scale" else unit
    return fields


def choices_of(
    kind: str, registry: Registry, *, written: Mapping[str, Any] | None = None, **options: Any
) -> list[Choice]:
    """The components of a kind that are registered, each with an empty form, but for the one that a table names.

    Parameters
    ----------
    written
        The table, with the component's name under ``use``; it fills the form of that component.
    options
        As of `form_of`.
    """
    found: list[Choice] = []
    for name in registry.names(kind):
        try:
            cls = registry.get(kind, name)
        except PluginError:  # it cannot be imported; see the registry's problems
            continue
        help_ = (cls.__doc__ or "").strip().splitlines()
        values = written if written is not None and written.get("use") == name else None
        found.append({"name": name, "help": help_[0] if help_ else "", "fields": form_of(cls, values, **options)})
    return found


def why_fixed(parameter: Parameter) -> str:
    """Why a parameter cannot change while a simulation runs; empty if it can."""
    if parameter.component and parameter.is_optional:
        return f"Whether there is a {parameter.component}, and which, is set when the simulation is made."
    if parameter.component:
        return f"Which {parameter.component} it is, is set when the simulation is made."
    if parameter.file:
        return "The file is read when the scenario is loaded."
    if parameter.static:
        return "It fixes the size or form of what is simulated, and is set when the simulation is made."
    if parameter.refers:
        return "The name is looked up when the simulation is made."
    if not parameter.live:
        return "It is set when the simulation is made."
    if parameter.type is str and not parameter.choices:
        return "A text is set when the simulation is made."
    return ""


def why_part_fixed(parameter: Parameter) -> str:
    """Why no field of a parameter that is a table can change while a simulation runs; empty if one can."""
    if parameter.component and parameter.static:
        return f"The {parameter.component} is set when the simulation is made."
    return "" if parameter.component else why_fixed(parameter)


def number_widget(parameter: Parameter, *, is_whole: bool = False) -> Widget:
    """The widget of a number that a parameter is, or that is in it."""
    widget: Widget = {
        "kind": "number",
        "is_optional": False,
        "unit": parameter.unit,
        "low": parameter.gt if parameter.ge is None else parameter.ge,
        "high": parameter.lt if parameter.le is None else parameter.le,
        "is_open": [parameter.ge is None, parameter.le is None],
        "is_whole": is_whole,
    }
    if parameter.frame:
        widget["frame"] = parameter.frame
    return widget


class _Maker:
    """Makes descriptions in one spelling."""

    def __init__(
        self, spelling: Spelling, sensor_unit: str, names: Names, is_running: bool, registry: Registry
    ) -> None:
        self._in_files = spelling == "file"
        self._unit = sensor_unit
        self._names = names
        self._is_running = is_running
        self._registry = registry

    def fields(self, cls: type, values: Any, path: str, *, is_written: bool = True, fixed: str = "") -> list[FieldForm]:
        """The fields of a class; `fixed` is why none of them can change, if so."""
        written = self._in_table(values)
        found = []
        for key, parameter in self._parameters(cls).items():
            default = self._default(key, parameter)
            value = written.get(key, default)
            field: FieldForm = {
                "path": f"{path}.{key}" if path else key,
                "label": parameter.name.replace("_", " "),
                "help": parameter.help,
                "widget": self._widget(in_file(key, parameter) if self._in_files else parameter, parameter.type),
                "value": None if self._in_files and value == NONE else value,
                "default": default,
                "is_given": is_written and key in written,
                "is_required": parameter.is_required,
                "fixed": (fixed or why_fixed(parameter)) if self._is_running else "",
            }
            if inner := self._class_of(parameter, field):
                part = fixed or (why_part_fixed(parameter) if self._is_running else "")
                field["widget"]["fields"] = self.fields(
                    inner, field["value"], field["path"], is_written=field["is_given"], fixed=part
                )
            found.append(field)
        return found

    def _class_of(self, parameter: Parameter, field: FieldForm) -> type | None:
        """The class of the fields in a field: of a table, or of the component that it is."""
        if field["widget"]["kind"] == "form":
            return _class_in(parameter.type)
        if not parameter.component or not isinstance(field["value"], Mapping):
            return None
        return _fitting(parameter, self._registry).get(str(field["value"].get("use")))

    def _parameters(self, cls: type) -> Mapping[str, Parameter]:
        if self._in_files:
            return file_fields(cls, self._unit)
        return {
            name: attrs.evolve(parameter, unit=self._unit) if parameter.unit == "sensor" else parameter
            for name, parameter in describe(cls).items()
        }

    def _in_table(self, values: Any) -> Mapping[str, Any]:
        if values is None:
            return {}
        if attrs.has(type(values)):
            return plain(write_fields(values, self._unit) if self._in_files else values)  # type: ignore[no-any-return]
        return plain(values) if isinstance(values, Mapping) else {}

    def _default(self, key: str, parameter: Parameter) -> Any:
        if parameter.is_required:
            return None
        if not self._in_files:
            return field_plain(parameter, parameter.default)
        default = default_in_file(parameter)
        return None if default == NONE and key else plain(default)

    def _widget(self, parameter: Parameter, kind: Any) -> Widget:
        if parameter.component:
            choices = list(_fitting(parameter, self._registry))
            return {
                "kind": "component",
                "is_optional": parameter.is_optional,
                "component": parameter.component,
                "choices": choices,
                "fields": [],
            }
        if isinstance(kind, types.UnionType) or typing.get_origin(kind) is typing.Union:
            return self._union(parameter, typing.get_args(kind))
        if typing.get_origin(kind) is tuple:
            return self._list(parameter, typing.get_args(kind))
        widget: Widget = {"kind": "text", "is_optional": False}
        if kind in (float, int):
            widget |= number_widget(parameter, is_whole=kind is int)
        elif kind is bool:
            widget["kind"] = "flag"
        elif isinstance(kind, type) and attrs.has(kind):
            widget |= {"kind": "form", "fields": self.fields(kind, None, "")}
        elif parameter.file:
            widget["kind"] = "file"
        elif parameter.refers:
            names = list(self._names.get(parameter.refers, ()))
            widget |= {"kind": "name", "refers": parameter.refers, "choices": names}
        elif parameter.choices:
            widget |= {"kind": "choice", "choices": list(parameter.choices)}
        return widget

    def _union(self, parameter: Parameter, options: Sequence[Any]) -> Widget:
        real = [option for option in options if option is not types.NoneType]
        if Distribution in real:
            widget: Widget = {"kind": "distribution", "is_optional": False, "unit": parameter.unit}
        elif len(real) == 1:
            widget = self._widget(parameter, real[0])
        else:
            widget = {"kind": "either", "is_optional": False, "options": [self._widget(parameter, o) for o in real]}
        widget["is_optional"] = len(real) < len(options)
        return widget

    def _list(self, parameter: Parameter, items: Sequence[Any]) -> Widget:
        is_open = len(items) == 2 and items[1] is Ellipsis
        item = items[0] if items else float
        widget: Widget = {"kind": "list", "is_optional": False, "length": None if is_open else len(items)}
        if parameter.frame:
            widget["frame"] = parameter.frame
        if isinstance(item, type) and attrs.has(item):
            widget |= {"kind": "forms", "fields": self.fields(item, None, "")}
            return widget
        width = typing.get_args(item) if typing.get_origin(item) is tuple else ()
        if width and Ellipsis not in width:
            columns = _columns(parameter, len(width))
            widget |= {"kind": "table", "columns": columns, "item": self._widget(parameter, width[0])}
            return widget
        if not is_open and parameter.frame:
            widget["columns"] = _columns(parameter, len(items))
        widget["item"] = self._widget(parameter, item)
        return widget


def _fitting(parameter: Parameter, registry: Registry) -> dict[str, type]:
    """The registered components that a field can be, by their names."""
    found = {}
    for name in registry.names(parameter.component):
        try:
            cls = registry.get(parameter.component, name)
        except PluginError:  # it cannot be imported; see the registry's problems
            continue
        if issubclass(cls, parameter.contract):
            found[name] = cls
    return found


def _columns(parameter: Parameter, count: int) -> list[str]:
    """The names of the numbers in a row."""
    if parameter.frame and count <= 3:
        return ["x", "y", "heading"][:count]
    return [str(number) for number in range(1, count + 1)]


def _class_in(kind: Any) -> type:
    """The class of fields in ``Mount`` or ``Mount | None``."""
    return next(one for one in (kind, *typing.get_args(kind)) if isinstance(one, type) and attrs.has(one))
