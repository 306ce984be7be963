"""Sections of an inspector, as a window gets them: a table of a thing as a form, or as TOML."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NotRequired, TypedDict

from amorsim.scenario.toml.literals import as_toml
from amorsim.ui.forms.description import FieldForm

__all__ = ["SHAPES", "Adding", "Section", "Use", "toml_of"]

SHAPES = {"circle": 0.3, "rectangle": [0.6, 0.4], "polygon": [[-0.3, -0.3], [0.3, -0.3], [0.0, 0.4]]}


class Use(TypedDict):
    """The component or shape of a table: one of `choices`."""

    kind: str
    value: str
    choices: list[str]
    is_optional: bool
    op: NotRequired[str]  # the change that makes the choice, where that is one of its own


class Adding(TypedDict):
    """A component of a kind that can be added to the list or the table at a path."""

    label: str
    path: str
    kind: str
    choices: list[str]
    is_list: bool
    value: NotRequired[dict[str, Any]]  # what is added, where nothing is to be chosen


class Section(TypedDict):
    """A table of a thing: a form, or its text in TOML."""

    title: str
    path: str
    depth: int
    use: Use | None
    fields: list[FieldForm]
    toml: str | None  # none where the form has it all
    can_go: bool
    origin: str  # where it comes from, where that is not the file
    adding: list[Adding]


def toml_of(table: Mapping[str, Any]) -> str:
    """A table as TOML, a line for each key."""
    return "".join(
        f"{key if key.replace('_', '').isalnum() else repr(key)} = {as_toml(value)}\n" for key, value in table.items()
    )
