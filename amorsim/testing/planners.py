"""How planners are tried."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from amorsim.contracts import Plan, Planner
from amorsim.core.error_text import RAISED, error_in_words, in_words
from amorsim.core.errors import PlanError
from amorsim.core.maps.map import Map
from amorsim.core.numbers import is_number
from amorsim.core.shapes import Shape
from amorsim.testing.failure import Who, array_in_words

__all__ = ["check_planner"]

_STATUSES = ("found", "unreachable", "start_blocked", "goal_blocked", "budget")


def check_planner(who: Who, planner: Planner) -> None:
    """Try a planner in a hall of two rooms with a door, and a cell that cannot be reached."""
    hall = _hall()
    start, goal = (1.05, 1.05, 0.0), (5.05, 3.05, 1.0)
    plan = _plan(who, planner, hall, start, goal)
    _check_path(who, plan, hall, start, goal, "through a door")
    again = _plan(who, planner, _hall(), start, goal)
    same = plan.poses.tobytes() == again.poses.tobytes() and plan.expanded == again.expanded
    who.require(same, "determinism", "the same question, about an equal map", "the same plan", "another one")
    disc = Shape.circle(0.2)
    wide = _plan(who, planner, hall, start, goal, disc)
    _check_path(who, wide, hall, start, goal, "with a footprint")
    _check_clearance(who, wide, hall, 0.2)
    _check_path(who, _plan(who, planner, hall, start, start), hall, start, start, "from a place to itself")
    for status, first, second, footprint, what in (
        ("start_blocked", (3.05, 0.55), goal, None, "from a wall"),
        ("goal_blocked", start, (3.05, 0.55), None, "into a wall"),
        ("start_blocked", (-1.0, 1.0), goal, None, "from outside the map"),
        ("goal_blocked", start, (1.0, 1e9), None, "to outside the map"),
        ("unreachable", start, (5.55, 0.45), None, "into a closed cell"),
        ("unreachable", start, goal, Shape.circle(0.6), "with a footprint wider than the door"),
    ):
        found = _plan(who, planner, hall, first, second, footprint)
        who.require(found.status == status, "status", what, status, f"{found.status} {found.message}")
    for bad in ((math.nan, 1.0), (1.0, math.inf), (1.0,), "here", None):
        for pair in ((bad, goal), (start, bad)):
            try:
                planner.plan(hall, *pair)
            except PlanError:
                continue
            except RAISED as error:
                who.fail("errors", f"plan() with {bad!r}: expected a PlanError, found {error_in_words(error)}")
            who.fail("errors", f"plan() with {bad!r}: expected a PlanError, found a plan")


def _hall() -> Map:
    """Two rooms, 6 m x 4 m, with a door 1 m wide, and in the second a closed cell."""
    cells = np.zeros((40, 60), np.uint8)
    cells[:, 30] = 1
    cells[15:25, 30] = 0
    cells[2:7, 53:58] = 1
    cells[3:6, 54:57] = 0
    return Map.from_array(cells, resolution=0.1, origin=(0.0, 0.0, 0.0))


def _plan(
    who: Who,
    planner: Planner,
    world: Map,
    start: Sequence[float],
    goal: Sequence[float],
    footprint: Shape | None = None,
) -> Plan:
    with who.calling("plan"):
        plan = planner.plan(world, start, goal, footprint=footprint)
    who.require(isinstance(plan, Plan), "plan", "plan()", "a Plan", type(plan).__name__)
    who.require(plan.status in _STATUSES, "plan", "Plan.status", f"one of {', '.join(_STATUSES)}", repr(plan.status))
    is_found = plan.status == "found"
    for name, wide in (("poses", 3), ("searched", 2), ("links", 4), ("trailer", 3)):
        array = getattr(plan, name)
        fits = isinstance(array, np.ndarray) and array.dtype == np.float64 and array.shape[1:] == (wide,)
        who.require(fits, "plan", f"Plan.{name}", f"float64 (M, {wide})", array_in_words(array))
        who.require(np.isfinite(array).all(), "plan", f"Plan.{name}", "finite numbers", "others")
    who.require(
        (len(plan.poses) > 0) == is_found, "plan", f"poses of a plan {plan.status}", "a path if found", plan.poses
    )
    trailers = len(plan.trailer)
    who.require(trailers in (0, len(plan.poses)), "plan", "Plan.trailer", "none, or one for each pose", trailers)
    for name in ("length", "cost"):
        value = getattr(plan, name)
        fits = is_number(value) and (0.0 <= value < math.inf if is_found else value == math.inf)
        who.require(fits, "plan", f"Plan.{name} of a plan {plan.status}", "0 or more; inf without a path", value)
    fits = isinstance(plan.message, str) and bool(plan.message) is not is_found
    who.require(fits, "plan", "Plan.message", "why there is no path", in_words(plan.message))
    return plan


def _check_path(who: Who, plan: Plan, world: Map, start: Sequence[float], goal: Sequence[float], what: str) -> None:
    who.require(plan.status == "found", "status", what, "found", f"{plan.status} {plan.message}")
    ends = plan.points[[0, -1]]
    wanted = np.array([start[:2], goal[:2]])
    who.require(np.abs(ends - wanted).max() < 1e-6, "ends", what, wanted.tolist(), ends.tolist())
    turn = math.remainder(plan.poses[-1, 2] - goal[2], 2.0 * math.pi)
    who.require(abs(turn) < 1e-6, "ends", f"{what}: the heading at the goal", goal[2], plan.poses[-1, 2])
    length = float(np.hypot(*np.diff(plan.points, axis=0).T).sum())
    # Lines between poses on a curve are a little shorter than it.
    close = -1e-6 <= (plan.length - length) / (1.0 + length) <= 1e-3
    who.require(close, "length", f"{what}: Plan.length", f"that of its lines, {length:.9g} m", plan.length)
    inside = world.occupied(_along(plan))
    who.require(not inside.any(), "free", what, "a path that keeps out of walls", _along(plan)[inside][:1].tolist())


def _check_clearance(who: Who, plan: Plan, world: Map, radius: float) -> None:
    """No point of the path is nearer to an occupied cell than the radius of a disc."""
    rows, cols = np.nonzero(world.to_array())
    low = np.column_stack([cols, rows]) * world.resolution
    for point in _along(plan):
        gap = np.hypot(*np.maximum(np.maximum(low - point, point - low - world.resolution), 0.0).T).min()
        edge = min(*point, *(np.array(world.size) - point))
        who.require(
            min(gap, edge) >= radius - 1e-9, "clearance", f"a disc of {radius} m at {point.tolist()}", "no wall", gap
        )


def _along(plan: Plan) -> np.ndarray[tuple[int, ...], np.dtype[np.float64]]:
    """Points at most 1 cm apart along a path."""
    pieces = [plan.points[:1]]
    for a, b in zip(plan.points[:-1], plan.points[1:], strict=True):
        count = max(1, math.ceil(float(np.hypot(*(b - a))) / 0.01))
        pieces.append(a + (b - a) * (np.arange(1, count + 1) / count)[:, None])
    return np.concatenate(pieces)
