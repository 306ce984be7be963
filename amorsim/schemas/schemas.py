"""The JSON Schema of a kind of file, as a document of its own."""

from __future__ import annotations

from collections.abc import Callable

from amorsim.core.errors import AmorsimError
from amorsim.core.unknown_names import no_such
from amorsim.plugins.manager import default_registry
from amorsim.plugins.registry import Registry
from amorsim.schemas.fields import Schema
from amorsim.schemas.scenario import scenario_schema
from amorsim.schemas.studies import rubric_schema, study_schema

__all__ = ["KINDS", "make_schema"]

KINDS: dict[str, Callable[[Registry], Schema]] = {
    "scenario": scenario_schema,
    "study": study_schema,
    "rubric": rubric_schema,
}
"""The kinds of file that have a schema."""


def make_schema(kind: str, registry: Registry | None = None) -> Schema:
    """The JSON Schema (draft 2020-12) of a kind of file, with the components of all installed plugins.

    Raises
    ------
    AmorsimError
        If there is no such kind.
    """
    if kind not in KINDS:
        raise AmorsimError(no_such("kind of file", kind, list(KINDS)))
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": f"amorsim {kind}",
        **KINDS[kind](registry or default_registry()),
    }
