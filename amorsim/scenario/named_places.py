"""The places that motions and controllers name: where an obstacle starts, and where a body goes."""

from __future__ import annotations

import math
from typing import Any

from amorsim.contracts import Controller, Motion
from amorsim.core.error_text import RAISED, error_in_words, in_words
from amorsim.core.errors import ComponentError
from amorsim.core.numbers import is_number

__all__ = ["first_place", "goals_of"]


def first_place(motion: Motion) -> tuple[float, float, float] | None:
    """A motion's `default_start`, checked.

    Raises
    ------
    ComponentError
        If the motion raises, or returns something else than places.
    """
    try:
        place: Any = motion.default_start()
    except RAISED as error:
        raise ComponentError(f"default_start() raised {error_in_words(error)}") from error
    if place is None:
        return None
    if not isinstance(place, tuple) or len(place) != 3 or not _are_numbers(place):
        expected = "None or a tuple of numbers (x [m], y [m], heading [rad])"
        raise ComponentError(f"default_start(): expected {expected}, got {in_words(place)}")
    return place


def goals_of(component: Controller | Motion) -> list[tuple[str, float, float]]:
    """A component's `goal_points`, checked.

    Raises
    ------
    ComponentError
        If the component raises, or returns something else than places.
    """
    try:
        goals: list[Any] = list(component.goal_points())
    except RAISED as error:
        raise ComponentError(f"goal_points() raised {error_in_words(error)}") from error
    for goal in goals:
        is_triple = isinstance(goal, tuple) and len(goal) == 3
        if not is_triple or not isinstance(goal[0], str) or not _are_numbers(goal[1:]):
            expected = "tuples of a field and numbers (name, x [m], y [m])"
            raise ComponentError(f"goal_points(): expected {expected}, got {in_words(goal)}")
    return goals


def _are_numbers(values: tuple[Any, ...]) -> bool:
    return all(is_number(value) and math.isfinite(value) for value in values)
