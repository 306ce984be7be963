"""Errors of robots that change nothing, as files have them: where they are, and tables without them."""

from __future__ import annotations

from typing import Any

from amorsim.scenario.files.models import ERROR_KEYS
from amorsim.scenario.toml.layout import MISSING, Path_, found_at

__all__ = ["error_over", "errors_in", "is_error", "meaning_of", "without_neutral"]

_DRAWS = {"normal", "uniform"}


def errors_in(path: Path_) -> int:
    """How many parts of a path lead to the table of errors that it leads into, of a scenario or a model; or 0."""
    return next((length for length in (1, 3) if path[length - 1 : length] == ("errors",)), 0)


def error_over(values: Any, path: Path_) -> Path_ | None:
    """The path of the error that is at a path or over it in a file's tables; None where there is none."""
    for length in range(errors_in(path) + 1, len(path) + 1) if errors_in(path) else ():
        said = found_at(values, path[:length])
        if said is MISSING:
            return None
        if is_error(said):
            return path[:length]
    return None


def is_error(said: Any) -> bool:
    """Whether a value in a table of errors is an error, and no table of more of them."""
    return not isinstance(said, dict) or set(said) <= ERROR_KEYS


def meaning_of(said: Any) -> tuple[Any, ...]:
    """The meaning of an error: scale, sum, value and which draws; no error and a neutral one mean the same."""
    if said is MISSING:
        said = {}
    if not isinstance(said, dict) or set(said) & _DRAWS:
        said = {"value": said}
    parts = said.get("scale", 1.0), said.get("add", 0.0), said.get("value")
    is_drawn = any(isinstance(part, dict) for part in parts)
    kinds = tuple(type(part) is bool for part in parts)  # true equals 1, and is a fault
    return (*parts, *kinds, said.get("per", "replica") if is_drawn else None)


def without_neutral(errors: Any) -> dict[str, Any]:
    """A table of errors without those that change nothing, and without tables of none."""
    found: dict[str, Any] = {}
    for key, said in errors.items() if isinstance(errors, dict) else ():
        if is_error(said):
            if meaning_of(said) != meaning_of(MISSING):
                found[key] = said
        elif inner := without_neutral(said):
            found[key] = inner
    return found
