"""The errors of a robot as forms: how true values differ from nominal ones."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from amorsim.contracts import Mount
from amorsim.core.parameters import Parameter
from amorsim.scenario.reading.fields import file_fields, in_file
from amorsim.ui.forms.description import FieldForm, Widget

__all__ = ["deviations", "fields_of", "targets"]

_PARTS = ("scale", "add", "value", "per")
_DRAWN = ("normal", "uniform")
_HELP = {
    "scale": "the nominal value times this",
    "add": "and this added",
    "value": "in place of the nominal value",
    "per": "who draws, where something is drawn: each replica, or the study once",
}

Path = tuple[str, ...]


def targets(drive: type | None, sensors: Mapping[str, type | None]) -> dict[Path, Parameter]:
    """The numbers of a robot that may have an error, by their paths in the table of errors, as files spell them."""
    found: dict[Path, Parameter] = {("drive", key): one for key, one in _numbers(drive)}
    for name, cls in sensors.items():
        found |= {("sensors", name, key): one for key, one in _numbers(cls)}
        found |= {("sensors", name, "mount", key): one for key, one in _numbers(Mount)}
    return found


def _numbers(cls: type | None) -> Iterator[tuple[str, Parameter]]:
    for key, parameter in {} if cls is None else file_fields(cls).items():
        if parameter.type is float:
            yield key, in_file(key, parameter)


def deviations(table: Any, path: Path = ()) -> Iterator[tuple[Path, Any]]:
    """The errors in a table of them: the path and the table of each."""
    for key, value in table.items() if isinstance(table, dict) else ():
        is_leaf = not isinstance(value, dict) or (bool(value) and set(value) <= {*_PARTS, *_DRAWN})
        if is_leaf:
            yield (*path, key), value
        else:
            yield from deviations(value, (*path, key))


def fields_of(written: Any, path: str, unit: str) -> list[FieldForm]:
    """The form of an error at a path; a number alone, or a draw, stands for the ``value``."""
    if not isinstance(written, dict) or set(written) & set(_DRAWN):
        return [_field(path, "value", written, unit)]
    parts = {"scale": 1.0, "add": 0.0, "value": None, "per": "replica"}
    if "value" in written:  # which takes the place of the others
        del parts["scale"], parts["add"]
    elif set(written) & {"scale", "add"}:
        del parts["value"]
    return [_field(f"{path}.{part}", part, written.get(part, default), unit) for part, default in parts.items()]


def _field(path: str, part: str, value: Any, unit: str) -> FieldForm:
    widget: Widget = {"kind": "distribution", "is_optional": part == "value", "unit": "×" if part == "scale" else unit}
    if part == "per":
        widget = {"kind": "choice", "is_optional": False, "choices": ["replica", "study"]}
    return {
        "path": path,
        "label": part,
        "help": _HELP[part],
        "widget": widget,
        "value": value,
        "default": None,
        "is_given": True,
        "is_required": False,
        "fixed": "",
    }
