"""The floor in a scenario's file: read and checked, and written again."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar

from amorsim.core.parameters import Parameter, ParameterError
from amorsim.core.shapes import Shape
from amorsim.scenario.floor import Drop, Floor, Marking
from amorsim.scenario.reading.bodies import read_pose, read_shape
from amorsim.scenario.reading.faults import Node
from amorsim.scenario.reading.fields import file_fields, read_fields, write_fields

__all__ = ["read_floor", "write_floor"]

_LISTS = ("markings", "drops")
_PLACED = ("shape", "pose")
_OF_LINES = ("points", "closed", "width")
_NUMBERS: dict[type, tuple[str, ...]] = {
    Floor: ("reflectance",),
    Marking: (*_OF_LINES, "reflectance", "colour"),
    Drop: ("depth",),
}

Thing = TypeVar("Thing", Marking, Drop)
WriteShape = Callable[[Shape, str], dict[str, Any]]


def read_floor(node: Node) -> Floor | None:
    """The floor in a table; None after faults."""
    if not node.expect_table("a table: reflectance, markings, drops"):
        return None
    before = node.book.count
    fields = file_fields(Floor, names=_NUMBERS[Floor])
    node.refuse_unknown((*_LISTS, *fields))
    values = read_fields(node, fields, skip=_LISTS)
    for key, kind in (("markings", Marking), ("drops", Drop)):
        things = node.child(key)
        if things.value is not None and things.expect_list(f"a list of tables, [[floor.{key}]]"):
            values[key] = [_read_thing(kind, item) for item in things.items()]
    return None if node.book.count > before else Floor(**values)


def _read_thing(kind: type[Thing], node: Node) -> Thing | None:
    """A marking or a drop in a table; None after faults."""
    known: dict[str, Parameter] = file_fields(kind, names=_NUMBERS[kind])
    if not node.expect_table(f"a table: {', '.join((*_PLACED, *known))}"):
        return None
    before = node.book.count
    node.refuse_unknown((*_PLACED, *known))
    values = read_fields(node, known, skip=_PLACED)
    if kind is Drop or "shape" in node:
        values["shape"] = read_shape(node.child("shape"))
    if "pose" in node:
        values["pose"] = read_pose(node.child("pose"))
    if node.book.count > before:
        return None
    try:
        return kind(**values)
    except ParameterError as error:
        (node.child(error.name) if error.name in node else node).fault(error.problem)
        return None


def write_floor(floor: Floor, write_shape: WriteShape) -> dict[str, Any]:
    """A floor as a file has it; `write_shape` writes a shape at a key path."""
    written = write_fields(floor, names=_NUMBERS[Floor])
    things: dict[str, tuple[Any, ...]] = {"markings": floor.markings, "drops": floor.drops}
    for key, those in things.items():
        if those:
            written[key] = [_write_thing(thing, f"floor.{key}.{i}", write_shape) for i, thing in enumerate(those)]
    return written


def _write_thing(thing: Any, path: str, write_shape: WriteShape) -> dict[str, Any]:
    names = _NUMBERS[type(thing)]
    if thing.shape is None:
        return write_fields(thing, names=names)
    placed = {"shape": write_shape(thing.shape, path), "pose": write_fields(thing.pose)}
    return placed | write_fields(thing, names=[name for name in names if name not in _OF_LINES])
