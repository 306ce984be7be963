"""Errors of robots that change nothing: how to find them in a file's tables, and tables without them."""

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
    """The path of the error at a path or above it in a file's tables; None if there is none."""
    for length in range(errors_in(path) + 1, len(path) + 1) if errors_in(path) else ():
        written = found_at(values, path[:length])
        if written is MISSING:
            return None
        if is_error(written):
            return path[:length]
    return None


def is_error(written: Any) -> bool:
    """Whether a value in a table of errors is an error, and no table of more of them."""
    return not isinstance(written, dict) or set(written) <= ERROR_KEYS


def meaning_of(written: Any) -> tuple[Any, ...]:
    """The meaning of an error: scale, sum, value and who draws; no error and a neutral one have the same."""
    if written is MISSING:
        written = {}
    if not isinstance(written, dict) or set(written) & _DRAWS:
        written = {"value": written}
    parts = written.get("scale", 1.0), written.get("add", 0.0), written.get("value")
    is_drawn = any(isinstance(part, dict) for part in parts)
    kinds = tuple(type(part) is bool for part in parts)  # true equals 1, and is a fault
    return (*parts, *kinds, written.get("per", "replica") if is_drawn else None)


def without_neutral(errors: Any) -> dict[str, Any]:
    """A table of errors without those that change nothing, and without empty tables."""
    found: dict[str, Any] = {}
    for key, written in errors.items() if isinstance(errors, dict) else ():
        if is_error(written):
            if meaning_of(written) != meaning_of(MISSING):
                found[key] = written
        elif inner := without_neutral(written):
            found[key] = inner
    return found
