"""Checks of a scenario's fields that are not numbers, when a part is made and not when it is first used."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterable, Mapping
from typing import Any, TypeVar

from amorsim.core.arguments import is_list
from amorsim.core.error_text import in_words
from amorsim.core.parameters import ParameterError
from amorsim.plugins.checks import check_name

__all__ = ["by_name", "check_colour", "is_a", "many"]

Thing = TypeVar("Thing")
Validator = Callable[[Any, Any, Any], None]


def is_a(kind: type, example: str, *, optional: bool = False) -> Validator:
    """A validator that the value is of a kind, or None where that is `optional`; `example` shows one."""

    def check(_: Any, attribute: Any, value: Any) -> None:
        if not isinstance(value, kind) and not (optional and value is None):
            raise ParameterError(attribute.name, _wrong(kind, example, value))

    return check


def by_name(kind: type, example: str) -> Validator:
    """A validator that the value has things of a kind by names."""

    def check(_: Any, attribute: Any, value: Any) -> None:
        if not isinstance(value, Mapping):
            raise ParameterError(
                attribute.name, f"expected a dict by names, as {{'name': {example}}}, got {in_words(value)}"
            )
        for name, thing in value.items():
            if problem := check_name(name):
                raise ParameterError(attribute.name, problem)
            if not isinstance(thing, kind):
                raise ParameterError(attribute.name, f"{name}: {_wrong(kind, example, thing)}")

    return check


def many(name: str, kind: type[Thing], given: Iterable[Thing]) -> tuple[Thing, ...]:
    """The things of a kind that a field called `name` was given, of any iterable."""
    if isinstance(given, kind):
        raise ParameterError(name, f"expected a list of {kind.__name__}, got one alone; put it in brackets: [...]")
    if not is_list(given):
        raise ParameterError(name, f"expected a list of {kind.__name__}, got {in_words(given)}")
    things = tuple(given)
    for thing in things:
        if not isinstance(thing, kind):
            raise ParameterError(name, f"expected a list of {kind.__name__}, got one with {in_words(thing)}")
    return things


def check_colour(colour: str | None) -> None:
    """Raise `ParameterError` unless it is a colour, or none."""
    if colour is None:
        return
    from PIL import ImageColor

    try:
        ImageColor.getrgb(colour)
    except ValueError:
        raise ParameterError("colour", f"expected a colour's name in CSS, or '#rrggbb', got {colour!r}") from None


def _wrong(kind: type, example: str, value: Any) -> str:
    if inspect.isclass(value) and issubclass(value, kind):
        return f"expected one of these, and not the class: {value.__name__}(...)"
    return f"expected a {kind.__name__}, as {example}, got {in_words(value)}"
