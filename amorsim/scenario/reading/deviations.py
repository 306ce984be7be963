"""Errors of robots in documents: tables that lead to numbers, and set how true differs from nominal."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import attrs

from amorsim.core.numbers import is_number
from amorsim.core.parameters import Parameter, ParameterError, describe
from amorsim.core.unknown_names import no_such
from amorsim.scenario.parameter_paths import changed, index_in
from amorsim.scenario.reading.faults import Node, shown
from amorsim.scenario.spec import Deviation, Distribution, MountedSensor, Number
from amorsim.scenario.toml.angles import to_degrees, to_radians

__all__ = ["KINDS", "read_deviations", "read_number", "write_deviations", "write_number"]

_FAR = 2.0**1023  # larger numbers are taken for mistakes

_FIELDS = ("scale", "add", "value", "per")
KINDS = ("normal", "uniform")
"""The keys of a distribution's table."""
# What belongs to every sensor's chain or timing: no part of what the robot's software holds as geometry.
_NO_ERROR = ("noise", "rate", "latency")


def read_deviations(
    node: Node, parts: Mapping[str, Any], classes: Mapping[tuple[str, ...], type] | None = None
) -> dict[str, Deviation]:
    """Deviations by path from a table of errors.

    Parameters
    ----------
    parts
        ``drive``, ``sensors`` and ``pose`` of the nominal robot; what could not be read is None, and errors
        of it are passed over.
    classes
        Of drives and sensors that could not be read, by their paths: errors of fields that these have not are faults.
    """
    found: dict[str, Deviation] = {}
    if node.expect_table("a table of errors, as in drive.track = { scale = 1.02 }"):
        _read_table(node, (), dict(parts), found, classes or {})
    return found


def _read_table(
    node: Node,
    path: tuple[str, ...],
    parts: dict[str, Any],
    found: dict[str, Deviation],
    classes: Mapping[tuple[str, ...], type],
) -> None:
    for key, child in node.children():
        is_angle_key = key.endswith("_deg")
        at = (*path, key.removesuffix("_deg"))
        if _is_unread(parts, at):
            _check_names(child, at, classes)
            continue
        if at[0] == "sensors" and at[2:] and at[2] in _NO_ERROR:
            child.fault(f"{at[2]!r} has no error; change the noise chain of the sensor itself")
            continue
        try:
            changed(parts, list(at), lambda nominal: nominal)
        except (LookupError, ParameterError) as error:
            if isinstance(child.value, dict) and not _is_deviation(child.value) and not is_angle_key:
                _read_table(child, at, parts, found, classes)
            else:
                problem = error.problem if isinstance(error, ParameterError) else str(error.args[0])
                # It may quote all that stands there.
                child.fault(problem if len(problem) < 400 else f"{problem[:160]}...")
            continue
        is_angle = _parameter(parts, at).is_angle
        if is_angle != is_angle_key:
            rename = f"this is an angle: write {key}_deg, in degrees"
            child.fault(rename if is_angle else f"this is not an angle: write {at[-1]}")
            continue
        deviation = _read_deviation(child, is_angle)
        if deviation is not None and _check_true(child, parts, at, deviation):
            found[".".join(at)] = deviation


def _is_unread(parts: dict[str, Any], path: tuple[str, ...]) -> bool:
    if path[0] in parts and parts[path[0]] is None:
        return True
    return path[0] == "sensors" and len(path) > 1 and path[1] in parts["sensors"] and not parts["sensors"][path[1]]


def _check_names(node: Node, path: tuple[str, ...], classes: Mapping[tuple[str, ...], type]) -> None:
    """A fault for each error of a drive or sensor that could not be read, if its class has no such field."""
    cls = classes.get(path)
    known: tuple[str, ...] = ()
    if cls is not None:
        known = (*describe(cls), *(("mount", *_NO_ERROR) if path[0] == "sensors" else ()))
    for key, child in node.children() if known and node.is_table else ():
        if (name := key.removesuffix("_deg")) not in known:
            child.fault(no_such("parameter", name, known))


def _is_deviation(table: dict[str, Any]) -> bool:
    return bool(table) and all(key in (*_FIELDS, *KINDS) for key in table)


def _described(thing: Any, name: str) -> Parameter:
    cls: type = type(thing)
    return describe(cls)[name]


def _parameter(thing: Any, path: Sequence[str]) -> Parameter:
    """The parameter at which a path ends, or in which it goes on; the path leads to a number."""
    name, rest = path[0], path[1:]
    if isinstance(thing, dict):
        return _parameter(thing[name], rest)
    if isinstance(thing, MountedSensor) and name not in attrs.fields_dict(MountedSensor):
        return _parameter(thing.sensor, path)
    value = getattr(thing, name)
    if not rest:
        return _described(thing, name)
    if isinstance(value, tuple):
        item = value[index_in(value, rest[0])]
        return _parameter(item, rest[1:]) if rest[1:] else _described(thing, name)
    return _parameter(value, rest)


def _read_deviation(node: Node, is_angle: bool) -> Deviation | None:
    value = node.value
    if not isinstance(value, dict) or (set(value) & set(KINDS) and not set(value) & set(_FIELDS)):
        number = read_number(node, is_angle)
        return None if number is None else _make(node, {"value": number})
    before = node.book.count
    node.refuse_unknown(_FIELDS)
    values: dict[str, Any] = {}
    for key, child in node.children():
        if key == "per":
            values[key] = child.value
        elif key in _FIELDS:
            values[key] = read_number(child, is_angle and key != "scale")
    if "value" in values and {"scale", "add"} & set(values):
        node.fault("expected either value, or scale and add: value takes the place of the nominal one")
    return _make(node, values) if node.book.count == before else None


def _make(node: Node, values: dict[str, Any]) -> Deviation | None:
    try:
        return Deviation(**values)
    except ParameterError as error:
        (node.child(error.name) if node.is_table and error.name in node else node).fault(error.problem)
        return None


def read_number(node: Node, is_angle: bool) -> Number | None:
    """A number or a distribution, in SI units; None after a fault."""
    value = node.value
    convert = to_radians if is_angle else float
    if is_number(value, below=_FAR):
        return convert(value)
    if not isinstance(value, dict):
        node.fault(
            "expected a finite number, or { normal = [MEAN, STD] } or { uniform = [LOW, HIGH] }, got "
            f"{shown(value)}"
        )
        return None
    node.refuse_unknown(KINDS)
    kinds = [kind for kind in KINDS if kind in value]
    if len(kinds) != 1:
        node.fault(f"expected one of normal and uniform, got {shown(value)}")
        return None
    child = node.child(kinds[0])
    pair = child.value
    if not isinstance(pair, list) or len(pair) != 2 or not all(is_number(item, below=_FAR) for item in pair):
        words = "[MEAN, STANDARD DEVIATION]" if kinds[0] == "normal" else "[LOW, HIGH]"
        child.fault(f"expected {words}, two finite numbers, got {shown(pair)}")
        return None
    try:
        return Distribution(kind=kinds[0], values=(convert(pair[0]), convert(pair[1])))
    except ParameterError as error:
        child.fault(error.problem)
        return None


def _check_true(node: Node, parts: dict[str, Any], path: tuple[str, ...], deviation: Deviation) -> bool:
    """Whether the parameter accepts the true value, if that is fixed; drawn ones are checked when drawn."""

    def true(nominal: float) -> float:
        scale, add, value = deviation.scale, deviation.add, deviation.value
        if value is not None:
            return nominal if isinstance(value, Distribution) else value
        if isinstance(scale, Distribution) or isinstance(add, Distribution):
            return nominal
        return nominal * scale + add

    try:
        changed(parts, list(path), true)
    except ParameterError as error:
        node.fault(f"the true value is wrong: {error.problem}")
        return False
    return True


def write_deviations(errors: Mapping[str, Deviation], parts: Mapping[str, Any]) -> dict[str, Any]:
    """The table of errors that `read_deviations` reads the same deviations from."""
    table: dict[str, Any] = {}
    for path, deviation in errors.items():
        at = tuple(path.split("."))
        is_angle = _parameter(dict(parts), at).is_angle
        place = table
        for part in at[:-1]:
            place = place.setdefault(part, {})
        written: dict[str, Any] = {}
        if deviation.value is not None:
            written["value"] = write_number(deviation.value, is_angle)
        else:
            written["scale"] = write_number(deviation.scale, False)
            written["add"] = write_number(deviation.add, is_angle)
        place[f"{at[-1]}_deg" if is_angle else at[-1]] = {**written, "per": deviation.per}
    return table


def write_number(number: Number, is_angle: bool) -> Any:
    """The value from which `read_number` reads the same number or distribution."""
    convert = to_degrees if is_angle else float
    if isinstance(number, Distribution):
        return {number.kind: [convert(part) for part in number.values]}
    return convert(number)
