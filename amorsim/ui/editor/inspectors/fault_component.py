"""The component that a fault is about, so that its manual can be shown beside the fault."""

from __future__ import annotations

from amorsim.core.errors import AmorsimError
from amorsim.plugins.registry import Registry
from amorsim.scenario.documents.document import Document
from amorsim.ui.editor.inspectors.thing_fields import ThingFields

__all__ = ["component_of"]


def component_of(document: Document, path: str, registry: Registry) -> tuple[str, str] | None:
    """The kind and the registered name of the innermost component that a path is in; None if it is in none."""
    parts = path.split(".")
    length = 2 if parts[1:2] and parts[1].isdigit() else 1
    try:
        thing = ThingFields(document, ".".join(parts[:length]), registry)
    except AmorsimError:
        return None
    inner = tuple(int(part) if part.isdigit() else part for part in parts[length:])
    for end in range(len(inner), -1, -1):
        cls = thing.class_at(inner[:end])
        component = None if cls is None else registry.component_of(cls)
        if component is not None:
            return component
    return None
