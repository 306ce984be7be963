"""The estimates and beliefs of a group: calls its estimators and checks what they return."""

from __future__ import annotations

import re
import types
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from amorsim.contracts import Beliefs, Context, Draws, Estimate, Estimator, Measurement, RobotModel, State
from amorsim.core.errors import AmorsimError
from amorsim.core.rows import stack
from amorsim.core.trouble import RAISED
from amorsim.scenario.spec import Robot
from amorsim.simulation.blame import Whose, array_problem, is_finite

__all__ = ["Estimators", "beliefs_problem"]

Array = npt.NDArray[np.float64]

_BELIEF = re.compile(r"[A-Za-z][A-Za-z0-9]*(_[A-Za-z][A-Za-z0-9]*)*")  # numbers at the end are indices in files
_NOTHING: Mapping[str, Beliefs] = types.MappingProxyType({})


class Estimators:
    """The estimators of a group, by name, with their estimates. The controller receives the first one's.

    Attributes
    ----------
    states
        The state of each.
    estimates
        The estimate of each; without estimators, the start pose that the robots know.
    """

    def __init__(self, draws: Mapping[str, Draws], whose: Whose) -> None:
        self._draws = draws
        self._whose = whose
        self._estimators: dict[str, Estimator] = {}
        self._believers: list[str] = []
        self._rows = 0
        self._updates = 0
        self.states: dict[str, State] = {}
        self.estimates: dict[str, Estimate] = {}

    @property
    def first(self) -> Estimate:
        """The estimate that the controller receives."""
        return next(iter(self.estimates.values()))

    def set_parameters(self, nominal: Sequence[Robot]) -> None:
        """Take the parameters of every row."""
        self._estimators = {name: stack([robot.estimators[name] for robot in nominal]) for name in self._draws}
        self._believers = [
            name for name, estimator in self._estimators.items() if type(estimator).beliefs is not Estimator.beliefs
        ]
        self._rows = len(nominal)

    def start(self, context: Context) -> None:
        """Start an episode in every row."""
        self._updates += 1
        self.states = {}
        for name, estimator in self._estimators.items():
            try:
                self.states[name] = dict(estimator.start(context))
            except RAISED as error:
                self._whose.blame_start(f"estimator {name!r}", estimator, error)
        told = context.pose
        self.estimates = {name: Estimate(told, np.zeros((len(told), 3, 3))) for name in self._estimators or ("none",)}

    def update(self, robot: RobotModel, readings: Mapping[str, Measurement], command: Array, elapsed: Array) -> None:
        """Update every estimator with the readings.

        Raises
        ------
        ComponentError
            If an estimator raises, or returns no `Estimate` or a pose that is not finite.
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
        self._updates += 1

    def failures(self) -> Iterator[tuple[str, int, bool]]:
        """What failed in the last update: the estimator's name, the row, and whether that ends its controller."""
        for name, estimator in self._estimators.items():
            if type(estimator).failed is Estimator.failed:
                continue
            failed = estimator.failed(self.states[name])
            if failed is not None and failed.any():
                ends = getattr(estimator, "on_failure", "continue") == "end"
                for row in np.flatnonzero(failed).tolist():
                    yield name, row, ends

    def beliefs(self) -> Mapping[str, Beliefs]:
        """The beliefs of the estimators that have any, by name; each is asked when it is first looked up."""
        return _StepBeliefs(self, self._believers) if self._believers else _NOTHING

    def beliefs_of(self, name: str) -> Beliefs:
        """The beliefs of one estimator, as its state is now.

        Raises
        ------
        ComponentError
            If it raises, or returns what are no beliefs.
        """
        estimator = self._estimators[name]
        try:
            found = estimator.beliefs(self.states[name])
        except RAISED as error:
            self._whose.blame(f"estimator {name!r}", estimator, error)
        if problem := beliefs_problem(found, self._rows):
            raise self._whose.wrong(f"estimator {name!r}", estimator, problem)
        return found

    @property
    def updates(self) -> int:
        """How many updates there were; beliefs are of one of them."""
        return self._updates


class _StepBeliefs(Mapping[str, Beliefs]):
    """The beliefs of a step, by estimator: computed when looked up, and kept."""

    def __init__(self, estimators: Estimators, names: Sequence[str]) -> None:
        self._estimators = estimators
        self._names = names
        self._update = estimators.updates
        self._kept: dict[str, Beliefs] = {}

    def __getitem__(self, name: str) -> Beliefs:
        if name not in self._names:
            raise KeyError(name)
        if name not in self._kept:
            if self._estimators.updates != self._update:
                raise AmorsimError(
                    f"the beliefs of estimator {name!r} were looked up after their step; look them up in the step, "
                    "or take a new frame"
                )
            self._kept[name] = self._estimators.beliefs_of(name)
        return self._kept[name]

    def __contains__(self, name: object) -> bool:
        return name in self._names  # asks nobody

    def __iter__(self) -> Iterator[str]:
        return iter(self._names)

    def __len__(self) -> int:
        return len(self._names)


def beliefs_problem(found: Any, rows: int) -> str:
    """The fault of what `Estimator.beliefs` returned; empty if they are beliefs of `rows` rows."""
    if not isinstance(found, Mapping):
        return f"expected beliefs() to return arrays by name, got a {type(found).__name__}"
    for name, array in found.items():
        if not isinstance(name, str) or not _BELIEF.fullmatch(name):
            return f"expected names of beliefs such as 'gyro_bias', words of letters joined by _, got {name!r}"
        if not isinstance(array, np.ndarray) or array.dtype not in (np.float64, np.int64, np.bool_):
            kind = getattr(array, "dtype", type(array).__name__)
            return f"expected the belief {name!r} to be an array of float64, int64 or bool, got {kind}"
        if array.shape[:1] != (rows,):
            return f"expected the belief {name!r} to have {rows} rows as its first axis, got the shape {array.shape}"
        if np.isinf(array).any():
            return f"expected finite numbers in the belief {name!r}, or nan where there is nothing, got inf"
    return ""


def _problem(found: Any, rows: int) -> str:
    """The fault of what an estimator returned; empty if it is an estimate of `rows` rows."""
    if not isinstance(found, Estimate):
        return f"expected an Estimate(pose, covariance), got a {type(found).__name__}"
    for what, array, shape in (("pose", found.pose, (rows, 3)), ("covariance", found.covariance, (rows, 3, 3))):
        if problem := array_problem(array, f"a {what}", shape):
            return problem
    return ""
