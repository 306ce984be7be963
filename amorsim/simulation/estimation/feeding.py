"""Estimators that take estimates of their robot's other estimators: the order of updates, and what they are given."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import Any

import numpy as np

from amorsim.array_types import Bools, Ints
from amorsim.contracts import Estimate, Estimator, Measurement
from amorsim.contracts.estimator import ESTIMATES
from amorsim.core.errors import ComponentError, did_you_mean
from amorsim.core.parameters import describe

__all__ = ["FeedingError", "estimate_readings", "feeders", "feeding_order"]


class FeedingError(ComponentError):
    """The error for an estimator that names a missing one, or that feeds itself; `name` is the estimator's."""

    def __init__(self, name: str, problem: str) -> None:
        self.name = name
        super().__init__(problem)


def feeders(estimator: Estimator) -> tuple[str, ...]:
    """The names of the estimators that an estimator's fields refer to."""
    kind: Any = type(estimator)
    found = (getattr(estimator, name) for name, one in describe(kind).items() if one.refers == "estimators")
    return tuple(dict.fromkeys(name for name in found if isinstance(name, str) and name))


def feeding_order(estimators: Mapping[str, Estimator]) -> dict[str, tuple[str, ...]]:
    """The estimators that feed each one; feeders come first, otherwise the order is the given one.

    Raises
    ------
    FeedingError
        If one is fed by an estimator that is not there, or by itself, also through others.
    """
    order: dict[str, tuple[str, ...]] = {}
    for name in estimators:
        _visit(name, estimators, (), order)
    return order


def _visit(
    name: str, estimators: Mapping[str, Estimator], way: tuple[str, ...], order: dict[str, tuple[str, ...]]
) -> None:
    """Put an estimator into the order, after those that feed it; `way` holds those that wait for it."""
    if name in order:
        return
    if name in way:
        circle = " waits for ".join(map(repr, (*way[way.index(name) :], name)))
        raise FeedingError(name, f"estimators feed each other in a circle: {circle}; name another estimator in one")
    fed_by = feeders(estimators[name])
    for other in fed_by:
        if other not in estimators:
            others = [one for one in estimators if one != name]
            known = ", ".join(map(repr, others)) or "no other"
            raise FeedingError(
                name,
                f"it takes the estimate of {other!r}, an estimator which the robot does not have; it has: {known}."
                f"{did_you_mean(other, others)}",
            )
        _visit(other, estimators, (*way, name), order)
    order[name] = fed_by


def estimate_readings(
    names: Iterable[str],
    estimates: Mapping[str, Estimate],
    tick: Ints,
    fresh: Bools,
    is_current: Callable[[str], Bools | None] = lambda _: None,
) -> dict[str, Measurement]:
    """Estimates of this `tick` `(N, 1)` as readings ``"estimators.NAME"``: pose and covariance, `(N, 12)`.

    They are `fresh` where they are current.
    """
    found = {}
    for name in names:
        pose, covariance = estimates[name]
        measured = np.concatenate((pose, covariance.reshape(-1, 9)), axis=1)
        current = is_current(name)
        new = fresh.copy() if current is None else fresh & current
        found[ESTIMATES + name] = Measurement(measured, tick.copy(), np.zeros(tick.shape), new)
    return found
