"""The differences between the scenarios of two studies."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from amorsim.core.errors import AmorsimError
from amorsim.scenario.files.resolved import resolved
from amorsim.scenario.reading.read import load
from amorsim.sweeps.table import Study

__all__ = ["differing_parts"]

_MOST = 5


def differing_parts(one: Study, other: Study) -> str:
    """A clause about what differs between two studies whose values are identical; empty if a scenario is missing."""
    try:
        first, second = (resolved(load(str(study.about["scenario"]))) for study in (one, other))
    except (AmorsimError, KeyError):
        return ""
    paths = list(_paths(first, second))
    if not paths:
        return "their scenarios do not differ"
    shown = ", ".join(paths[:_MOST]) + (f" and {len(paths) - _MOST} more" if len(paths) > _MOST else "")
    return f"their scenarios differ in {shown}, which {'does' if len(paths) == 1 else 'do'} not reach this metric"


def _paths(one: Any, other: Any, path: str = "") -> Iterator[str]:
    """The paths, as of ``--set``, of values that differ."""
    if isinstance(one, list) and isinstance(other, list) and all(isinstance(each, Mapping) for each in (*one, *other)):
        one, other = ({str(each.get("name", place)): each for place, each in enumerate(many)} for many in (one, other))
    if isinstance(one, Mapping) and isinstance(other, Mapping):
        for key in {**one, **other}:
            yield from _paths(one.get(key), other.get(key), f"{path}.{key}" if path else str(key))
    elif one != other:
        yield path
