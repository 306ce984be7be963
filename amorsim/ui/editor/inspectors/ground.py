"""The floor, in its inspector: lines, areas and drops, each with a form; and the scenario's own description."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from amorsim.scenario.floor import Drop, Floor, Marking
from amorsim.scenario.spec import Pose
from amorsim.ui.editor.inspectors.sections import Adding, Section
from amorsim.ui.editor.inspectors.shape_form import shape_sections
from amorsim.ui.editor.inspectors.thing_fields import ThingFields

__all__ = ["described", "floor"]

_LOOKS = ("reflectance", "colour")
_LINE = ("points", "closed", "width", *_LOOKS)
_NEW: dict[str, tuple[str, dict[str, Any]]] = {
    "a line": ("markings", {"points": [[0.5, 0.5], [1.5, 0.5]]}),
    "an area": ("markings", {"shape": {"rectangle": [0.6, 0.4]}, "pose": {"x": 1.0, "y": 1.0}}),
    "a drop": ("drops", {"shape": {"circle": 0.3}, "pose": {"x": 1.0, "y": 1.0}}),
}


def described(of: ThingFields) -> Section:
    """The description of the scenario."""
    written = of.document.values.get("description")
    section = of.section("Scenario", (), [])
    section["path"] = "description"
    field = of.text("description", "description", "what it is about, in a line", "text")
    field |= {"path": "description", "value": written, "is_given": written is not None}
    field["widget"] = {"kind": "text", "is_optional": True}
    section["fields"] = [field]
    return section


def floor(of: ThingFields) -> Iterator[Section]:
    """How bright the floor is, and a section for each line, area and drop."""
    section = of.section("Floor", (), of.form(Floor, (), ("reflectance",)))
    section["adding"] = [_adding(of, label, key, value) for label, (key, value) in _NEW.items()]
    yield section
    for key in ("markings", "drops"):
        written = of.table.get(key)
        for number, one in enumerate(written if isinstance(written, list) else []):
            if isinstance(one, dict):
                yield from _thing(ThingFields(of.document, f"floor.{key}.{number}", of.registry), key, number)


def _adding(of: ThingFields, label: str, key: str, value: dict[str, Any]) -> Adding:
    path = of.path_of((key,))
    return {"label": f"add {label}", "path": path, "kind": key, "choices": [], "is_list": True, "value": value}


def _thing(of: ThingFields, key: str, number: int) -> Iterator[Section]:
    """The form of a line, an area or a drop that is selected."""
    is_line = key == "markings" and "shape" not in of.table
    kind = "drop" if key == "drops" else "line" if is_line else "area"
    title = f"{kind} {number + 1}"
    fields = of.form(Drop, (), ("depth",)) if key == "drops" else of.form(Marking, (), _LINE if is_line else _LOOKS)
    section = of.section(title, (), fields)
    section["depth"] = 1
    section["can_go"] = True
    yield section
    if is_line:
        return
    for part in (*shape_sections(of), of.section("Place", ("pose",), of.form(Pose, ("pose",)))):
        part["title"] = f"{part['title']} of {title}"
        part["depth"] = 2
        yield part
