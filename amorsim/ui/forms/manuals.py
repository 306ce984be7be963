"""Manuals of components, for a window: what a component is, and its fields."""

from __future__ import annotations

from typing import TypedDict

from amorsim.analysis.reference import FILES, manual_parts
from amorsim.core.errors import AmorsimError
from amorsim.plugins.registry import Registry
from amorsim.scenario.spec import Robot
from amorsim.ui.forms.running_robot import places_of

__all__ = ["Manual", "components_of", "manual_of"]


def components_of(robot: Robot, registry: Registry) -> dict[str, tuple[str, str]]:
    """The kind and the registered name of each part of a robot that has one, by its path in the robot."""
    found: dict[str, tuple[str, str]] = {}
    for path, thing in places_of(robot):
        component = registry.component_of(type(thing))
        if component is not None:
            found[path] = component
    return found


class Manual(TypedDict):
    """What a component is, in paragraphs; of each field its name in files, value, default and meaning."""

    text: str
    fields: list[tuple[str, str, str, str]]


def manual_of(kind: str, name: str, registry: Registry) -> Manual:
    """The manual of a component that is registered.

    Raises
    ------
    AmorsimError
        If there is none of that name.
    """
    entries = [entry for entry in registry.entries(kind) if entry.name == name and kind not in FILES]
    if not entries:
        raise AmorsimError(f"there is no {kind.replace('_', ' ')} {name!r} with a manual")
    text, fields = manual_parts(registry, entries[0])
    return {"text": text, "fields": fields}
