"""The form of a shape: a circle, a rectangle, or a polygon as TOML."""

from __future__ import annotations

from collections.abc import Iterator

from amorsim.core.numbers import is_number
from amorsim.ui.editor.inspectors.sections import SHAPES, Section, toml_of
from amorsim.ui.editor.inspectors.thing_fields import ThingFields

__all__ = ["shape_sections"]


def shape_sections(fields: ThingFields) -> Iterator[Section]:
    """The section of a thing's shape."""
    table = fields.table.get("shape")
    kinds = [kind for kind in SHAPES if isinstance(table, dict) and kind in table]
    section = fields.section("Shape", ("shape",), [])
    section["use"] = {
        "kind": "shape",
        "value": kinds[0] if len(kinds) == 1 else "",
        "choices": list(SHAPES),
        "is_optional": False,
    }
    value = table[kinds[0]] if isinstance(table, dict) and len(kinds) == 1 else None
    if kinds == ["circle"] and is_number(value):
        section["fields"] = [fields.number(("shape", "circle"), "radius", "m", value)]
    elif kinds == ["rectangle"] and isinstance(value, list) and [*map(is_number, value)] == [True, True]:
        section["fields"] = [
            fields.number(("shape", "rectangle", number), label, "m", value[number])
            for number, label in enumerate(("length", "width"))
        ]
        for field in section["fields"]:
            field["is_given"] = False  # one of the two cannot be left out
    else:
        section["toml"] = toml_of(table) if isinstance(table, dict) else ""
    yield section
