"""Calls of a planner whose answer is checked, since a plugin's may be anything."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from amorsim.contracts import Plan, Planner
from amorsim.core.error_text import RAISED, error_in_words, in_words
from amorsim.core.errors import AmorsimError, ComponentError
from amorsim.core.maps.map import Map
from amorsim.core.parameters import LARGEST
from amorsim.core.shapes import Shape

__all__ = ["find_plan"]

_STATUSES = ("found", "unreachable", "start_blocked", "goal_blocked", "budget")
_WIDTHS = {"poses": 3, "searched": 2, "links": 4, "trailer": 3}


def find_plan(
    planner: Planner, world: Map, start: Sequence[float], goal: Sequence[float], footprint: Shape | None
) -> Plan:
    """The planner's plan.

    Raises
    ------
    ComponentError
        If it raises another error than amorsim's, or returns no plan; the message names the planner.
    """
    what = f"planner ({type(planner).__name__})"
    try:
        plan: Any = planner.plan(world, start, goal, footprint=footprint)
    except AmorsimError:  # such as a PlanError
        raise
    except RAISED as error:
        raise ComponentError(f"{what}: plan() raised {error_in_words(error)}") from error
    if problem := _problem(plan):
        raise ComponentError(f"{what}: {problem} from plan()")
    return plan  # type: ignore[no-any-return]


def _problem(plan: Any) -> str:
    """The fault of a planner's answer; empty if there is none."""
    if not isinstance(plan, Plan):
        return f"expected a Plan, got {in_words(plan)}"
    if plan.status not in _STATUSES:
        return f"expected a Plan of a status among {', '.join(_STATUSES)}, got {in_words(plan.status)}"
    for name, width in _WIDTHS.items():
        array: Any = getattr(plan, name)
        is_numbers = isinstance(array, np.ndarray) and array.dtype.kind in "fiu"
        if not is_numbers or array.ndim != 2 or array.shape[1] != width:
            got = f"the shape {array.shape}, {array.dtype}" if isinstance(array, np.ndarray) else in_words(array)
            return f"expected a Plan with `{name}` of numbers (M, {width}), got {got}"
        if not np.isfinite(array).all():
            return f"expected a Plan with finite numbers in `{name}`, got nan or inf"
    expanded: Any = plan.expanded
    if not isinstance(expanded, (int, np.integer)):
        return f"expected a Plan whose `expanded` is a whole number, got {in_words(expanded)}"
    if plan.status != "found":
        return ""
    if not len(plan.poses):
        return "expected a Plan with `poses`, as its status is 'found', got none"
    if len(plan.trailer) not in (0, len(plan.poses)):
        return f"expected a Plan with a pose in `trailer` for each of `poses`, got {len(plan.trailer)}"
    for name, most in (("length", LARGEST), ("cost", math.inf)):  # a planner need not state what it minimised
        value: Any = getattr(plan, name)
        if not isinstance(value, (float, int, np.floating, np.integer)) or not 0.0 <= value <= most:
            return f"expected a Plan found whose `{name}` is a number >= 0, got {in_words(value)}"
    return ""
