"""What the robots of a group estimate: their estimators are asked, and what they return is checked."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from amorsim.contracts import Context, Estimate, State
from amorsim.core.trouble import RAISED
from amorsim.simulation.blame import array_problem, is_finite

if TYPE_CHECKING:
    from amorsim.simulation.group import Group

__all__ = ["estimates_of", "start_estimators"]


def start_estimators(group: Group, context: Context) -> dict[str, State]:
    """The state of each estimator at the start of an episode, by name."""
    states: dict[str, State] = {}
    for name, estimator in group.estimators.items():
        try:
            states[name] = dict(estimator.start(context))
        except RAISED as error:
            group.whose.blame(f"estimator {name!r}", estimator, error)
    return states


def estimates_of(group: Group) -> dict[str, Estimate]:
    """What each estimator of a group makes of the readings, by name.

    Raises
    ------
    ComponentError
        If an estimator raises, or returns no estimate or a pose that is not finite.
    """
    found: dict[str, Estimate] = {}
    for name, estimator in group.estimators.items():
        try:
            estimate = estimator.update(
                group.robot,
                group.readings,
                group.command,
                group.row_clock.elapsed,
                group.estimator_states[name],
                group.estimator_draws[name],
            )
        except RAISED as error:
            group.whose.blame(f"estimator {name!r}", estimator, error)
        if problem := _problem(estimate, group.rows):
            raise group.whose.wrong(f"estimator {name!r}", estimator, problem)
        if not is_finite(estimate.pose):
            raise group.whose.not_finite(f"estimator {name!r}", estimator, "the estimated pose", estimate.pose)
        found[name] = estimate
    return found


def _problem(found: Any, rows: int) -> str:
    """What is wrong with what an estimator returned; nothing where it is an estimate of so many rows."""
    if not isinstance(found, Estimate):
        return f"expected an Estimate(pose, covariance), got a {type(found).__name__}"
    for what, array, shape in (("pose", found.pose, (rows, 3)), ("covariance", found.covariance, (rows, 3, 3))):
        if problem := array_problem(array, f"a {what}", shape):
            return problem
    return ""
