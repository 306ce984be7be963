"""Shapes and poses of bodies in documents."""

from __future__ import annotations

import math
from typing import Any

from amorsim.core.numbers import is_number
from amorsim.core.shapes import Shape
from amorsim.scenario.reading.faults import Node, shown
from amorsim.scenario.reading.fields import read_component
from amorsim.scenario.spec import Pose

__all__ = ["SHAPES", "read_pose", "read_shape", "write_shape"]

_FAR = 1e100  # larger numbers are taken for mistakes

_EXPECTED = "expected { circle = RADIUS }, { rectangle = [LENGTH, WIDTH] } or { polygon = [[X, Y], ...] }, in metres"
# What may stand next to each of them: where the centre lies, or by how much corners are rounded outwards.
_BESIDE = {"circle": ("x", "y"), "rectangle": ("x", "y"), "polygon": ("rounding",)}
SHAPES = tuple(_BESIDE)
"""The keys of which a shape has one."""


def read_pose(node: Node) -> Pose | None:
    """The pose in a table ``{ x, y, heading_deg }``; what is left out is zero."""
    return read_component(Pose, node)  # type: ignore[no-any-return]


def read_shape(node: Node) -> Shape | None:
    """The shape in a table, in the body's own frame."""
    if node.value is None:
        node.fault(f"missing; {_EXPECTED}")
        return None
    kinds = [kind for kind in _BESIDE if node.is_table and kind in node]
    if len(kinds) != 1:
        if node.is_table and not kinds:
            node.refuse_unknown((*_BESIDE, "x", "y", "rounding"))
        node.fault(f"{_EXPECTED}; got {shown(node.value)}")
        return None
    kind = kinds[0]
    before = node.book.count
    node.refuse_unknown((kind, *_BESIDE[kind]))
    beside = {key: _number(node.child(key)) for key in _BESIDE[kind] if key in node}
    child = node.child(kind)
    size: Any = _number(child) if kind == "circle" else _numbers(child, kind)
    if node.book.count > before:
        return None
    try:
        if kind == "circle":
            return Shape.circle(size, **beside)
        if kind == "rectangle":
            return Shape.rectangle(*size, **beside)
        return Shape.polygon(size, **beside)
    except ValueError as error:
        child.fault(str(error))
        return None


def _number(node: Node) -> float:
    if is_number(node.value, below=_FAR):
        return float(node.value)
    node.fault(f"expected a finite number [m], got {shown(node.value)}")
    return 0.0


def _numbers(node: Node, kind: str) -> Any:
    value = node.value
    if kind == "rectangle":
        if isinstance(value, list) and len(value) == 2 and all(is_number(side, below=_FAR) for side in value):
            return [float(side) for side in value]
        node.fault(f"expected [LENGTH, WIDTH], two finite numbers [m], got {shown(value)}")
        return []
    points: list[Any] = value if isinstance(value, list) else [None]
    for index, point in enumerate(points):
        if not (isinstance(point, list) and len(point) == 2 and all(is_number(number, below=_FAR) for number in point)):
            at = node if point is None else Node(point, (*node.path, str(index)), node.book)
            what = "a list of points [X, Y] [m]" if point is None else "[X, Y], two finite numbers [m]"
            at.fault(f"expected {what}, got {shown(at.value)}")
            return []
    return [[float(number) for number in point] for point in points]


def _capped(value: float) -> float:
    return max(min(value, 10**101), -(10**101)) if isinstance(value, int) else (value if value == value else math.inf)


def write_shape(shape: Shape) -> dict[str, Any] | None:
    """The table that `read_shape` reads the same shape from, or None if there is no such table."""
    first = shape.vertices[0]
    if len(shape.vertices) == 1 and len(first) == 1:
        (x, y), radius = first[0], shape.radius
        return {"circle": radius} if x == 0.0 and y == 0.0 else {"circle": radius, "x": x, "y": y}
    table: dict[str, Any] = {"polygon": [list(point) for point in (first if shape.radius else shape.border)]}
    if shape.radius:
        table["rounding"] = shape.radius
    try:
        again = Shape.polygon(table["polygon"], rounding=shape.radius)
    except ValueError:
        return None
    return table if again == shape else None
