"""What the robots of a group estimate: their estimators are asked, and what they return is checked."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from amorsim.contracts import Context, Draws, Estimate, Estimator, Measurement, RobotModel, State
from amorsim.core.rows import stack
from amorsim.core.trouble import RAISED
from amorsim.scenario.spec import Robot
from amorsim.simulation.blame import Whose, array_problem, is_finite

__all__ = ["Estimators"]

Array = npt.NDArray[np.float64]


class Estimators:
    """The estimators of a group, by name, with what they estimate. The first one's is what the controller is told.

    Attributes
    ----------
    states
        Of each.
    estimates
        Of each; where there is none, that the robots are where they were told to start.
    """

    def __init__(self, draws: Mapping[str, Draws], whose: Whose) -> None:
        self._draws = draws
        self._whose = whose
        self._estimators: dict[str, Estimator] = {}
        self.states: dict[str, State] = {}
        self.estimates: dict[str, Estimate] = {}

    @property
    def first(self) -> Estimate:
        """What the controller is told."""
        return next(iter(self.estimates.values()))

    def set_parameters(self, nominal: Sequence[Robot]) -> None:
        """Take what is specified of every row."""
        self._estimators = {name: stack([robot.estimators[name] for robot in nominal]) for name in self._draws}

    def start(self, context: Context) -> None:
        """Put every row at the start of an episode."""
        self.states = {}
        for name, estimator in self._estimators.items():
            try:
                self.states[name] = dict(estimator.start(context))
            except RAISED as error:
                self._whose.blame(f"estimator {name!r}", estimator, error)
        told = context.pose
        self.estimates = {name: Estimate(told, np.zeros((len(told), 3, 3))) for name in self._estimators or ("none",)}

    def update(self, robot: RobotModel, readings: Mapping[str, Measurement], command: Array, elapsed: Array) -> None:
        """Let every estimator make of the readings what it can.

        Raises
        ------
        ComponentError
            If one raises, or returns no estimate or a pose that is not finite.
        """
        for name, estimator in self._estimators.items():
            try:
                estimate = estimator.update(robot, readings, command, elapsed, self.states[name], self._draws[name])
            except RAISED as error:
                self._whose.blame(f"estimator {name!r}", estimator, error)
            if problem := _problem(estimate, robot.rows):
                raise self._whose.wrong(f"estimator {name!r}", estimator, problem)
            if not is_finite(estimate.pose):
                raise self._whose.not_finite(f"estimator {name!r}", estimator, "the estimated pose", estimate.pose)
            self.estimates[name] = estimate


def _problem(found: Any, rows: int) -> str:
    """What is wrong with what an estimator returned; nothing where it is an estimate of so many rows."""
    if not isinstance(found, Estimate):
        return f"expected an Estimate(pose, covariance), got a {type(found).__name__}"
    for what, array, shape in (("pose", found.pose, (rows, 3)), ("covariance", found.covariance, (rows, 3, 3))):
        if problem := array_problem(array, f"a {what}", shape):
            return problem
    return ""
