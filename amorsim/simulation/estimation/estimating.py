"""The estimates and beliefs of a group: calls its estimators and checks what they return."""

from __future__ import annotations

import functools
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from typing import Any, NoReturn

import attrs
import numpy as np

from amorsim.array_types import Array, Bools
from amorsim.contracts import (
    Beliefs,
    Context,
    Draws,
    Estimate,
    Estimator,
    EstimatorBinding,
    Measurement,
    RobotModel,
    State,
)
from amorsim.core.error_text import RAISED, in_words
from amorsim.core.errors import ComponentError
from amorsim.core.rows import stack
from amorsim.kernels.number_checks import all_finite
from amorsim.scenario.spec import Robot
from amorsim.simulation.error_context import ErrorContext, array_problem, is_finite
from amorsim.simulation.estimation.beliefs import Believer, beliefs_problem, chosen
from amorsim.simulation.estimation.feeding import FeedingError, estimate_readings, feeding_order
from amorsim.simulation.row_clock import RowClock

__all__ = ["Estimators"]

Blame = Callable[[BaseException], NoReturn]


class Estimators:
    """The estimators of a group, by name, with their estimates. The controller receives the first one's.

    Attributes
    ----------
    states
        The state of each.
    estimates
        The estimate of each; without estimators, the start pose that the robots know.
    """

    def __init__(self, draws: Mapping[str, Draws], whose: ErrorContext, row_clock: RowClock) -> None:
        self._draws = draws
        self._whose = whose
        self._row_clock = row_clock
        self._estimators: dict[str, Estimator] = {}
        self._fed_by: dict[str, tuple[str, ...]] = {}  # in the order of updates
        self._believers: list[str] = []
        self._rows = 0
        self._updates = 0
        self._poses, self._covariances = np.zeros((1, 0, 3)), np.zeros((1, 0, 3, 3))  # of all estimates
        self.states: dict[str, State] = {}
        self.estimates: dict[str, Estimate] = {}

    @property
    def first(self) -> Estimate:
        """The estimate that the controller receives."""
        return next(iter(self.estimates.values()))

    def set_parameters(self, nominal: Sequence[Robot]) -> None:
        """Take the parameters of every row.

        Raises
        ------
        ComponentError
            If an estimator is fed by one that its robot does not have, or by itself.
        """
        try:
            self._fed_by = feeding_order(nominal[0].estimators)
        except FeedingError as error:
            estimator = nominal[0].estimators[error.name]
            self._whose.blame_start(f"estimator {error.name!r}", estimator, ComponentError(str(error)))
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
            known = None if context.covariance is None else context.covariance.copy()
            own = attrs.evolve(context, pose=context.pose.copy(), covariance=known)  # to keep, and write into
            try:
                self.states[name] = dict(estimator.start(own))
            except RAISED as error:
                self._whose.blame_start(f"estimator {name!r}", estimator, error)
        start, known = context.pose, np.zeros((context.rows, 3, 3))
        self.estimates = {name: Estimate(start, known) for name in self._estimators or ("none",)}
        self._lay_out()

    def _lay_out(self) -> None:
        """Put all estimates one after another into arrays of their own, so that one call checks them."""
        self._poses = np.stack([estimate.pose for estimate in self.estimates.values()])
        self._covariances = np.stack([estimate.covariance for estimate in self.estimates.values()])
        self.estimates = {
            name: Estimate(pose, covariance)
            for name, pose, covariance in zip(self.estimates, self._poses, self._covariances, strict=True)
        }

    def bind(
        self,
        robot: RobotModel,
        live: Mapping[str, Measurement],
        copies: Mapping[str, Measurement],
        command: Array,
        row_clock: RowClock,
    ) -> list[tuple[str, Callable[[], None], Blame]]:
        """The functions that update the estimators, each after those that feed it: name, function, and who is to blame.

        Parameters
        ----------
        live, copies
            The arrays of the current readings, and the same in copies, each made when it is looked up.
        command
            The array of the command.
        """
        self._lay_out()
        found: list[tuple[str, Callable[[], None], Blame]] = []
        for name, fed_by in self._fed_by.items():
            estimator, out = self._estimators[name], self.estimates[name]
            at = EstimatorBinding(
                robot=robot,
                readings=live,
                copied_readings=functools.partial(self._given, fed_by, copies) if fed_by else lambda: copies,
                command=command,
                elapsed=lambda: row_clock.elapsed,
                state=self.states[name],
                draws=self._draws[name],
                out=out,
                answer=functools.partial(self._take, name, robot.rows),
            )
            blame = functools.partial(self._whose.blame, f"estimator {name!r}", estimator)
            found.append((name, estimator.bind(at), blame))
        return found

    def _given(self, fed_by: Sequence[str], copies: Mapping[str, Measurement]) -> dict[str, Measurement]:
        """The readings, and the estimates that feed an estimator."""
        now = self._row_clock

        def is_current(name: str) -> Bools | None:
            return self._estimators[name].is_current(copies, self.states[name])

        return {**copies, **estimate_readings(fed_by, self.estimates, now.tick, now.always, is_current)}

    def _take(self, name: str, rows: int, estimate: Any) -> None:
        """Take what an estimator's `update` returned."""
        if problem := _problem(estimate, rows):
            raise self._whose.wrong(f"estimator {name!r}", self._estimators[name], problem)
        self.estimates[name].pose[:], self.estimates[name].covariance[:] = estimate

    def conclude(self) -> None:
        """Raise a `ComponentError` if an estimate of this step is not finite."""
        self._updates += 1
        if all_finite(self._poses.ravel()) and all_finite(self._covariances.ravel()):
            return
        for name in self._fed_by:
            estimator, estimate = self._estimators[name], self.estimates[name]
            for what, array in (("the estimated pose", estimate.pose), ("the covariance", estimate.covariance)):
                if not is_finite(array):
                    raise self._whose.not_finite(f"estimator {name!r}", estimator, what, array)

    @property
    def names(self) -> list[str]:
        """The names of the estimators."""
        return list(self._estimators)

    @property
    def can_fail(self) -> bool:
        """Whether one of them may report that it failed."""
        return any(type(estimator).failed is not Estimator.failed for estimator in self._estimators.values())

    def failures(self) -> Iterator[tuple[str, int, bool]]:
        """The failures in the last update: the estimator's name, the row, and whether that ends its controller."""
        for name, estimator in self._estimators.items():
            if type(estimator).failed is Estimator.failed:
                continue
            try:
                failed = estimator.failed(self.states[name])
            except RAISED as error:
                self._whose.blame(f"estimator {name!r}", estimator, error)
            if failed is None:
                continue
            rows = len(self.estimates[name].pose)
            if not isinstance(failed, np.ndarray) or failed.dtype != bool or failed.shape != (rows,):
                problem = f"failed() gave {in_words(failed)}; expected None, or an array of bool of the shape ({rows},)"
                raise self._whose.wrong(f"estimator {name!r}", estimator, problem)
            if failed.any():
                ends = getattr(estimator, "on_failure", "continue") == "end"
                for row in np.flatnonzero(failed).tolist():
                    yield name, row, ends

    def believers(self) -> dict[str, Believer]:
        """Functions that return the beliefs of each estimator that has any, by name."""
        return {name: functools.partial(self.beliefs_of, name) for name in self._believers}

    def beliefs_of(self, name: str, wanted: Iterable[str] | None = None) -> Beliefs:
        """The beliefs of one estimator, as its state is now: those that are wanted, or all.

        Raises
        ------
        ComponentError
            If it raises, or returns something else than beliefs.
        """
        estimator = self._estimators[name]
        try:
            found: Beliefs = chosen(estimator.beliefs(self.states[name]), wanted)
        except RAISED as error:
            self._whose.blame(f"estimator {name!r}", estimator, error)
        if problem := beliefs_problem(found, self._rows):
            raise self._whose.wrong(f"estimator {name!r}", estimator, problem)
        return found

    @property
    def updates(self) -> int:
        """The number of updates so far, which tells to which of them beliefs belong."""
        return self._updates


def _problem(found: Any, rows: int) -> str:
    """The fault of what an estimator returned; empty if it is an estimate of `rows` rows."""
    if not isinstance(found, Estimate):
        return f"expected an Estimate(pose, covariance), got a {type(found).__name__}"
    for what, array, shape in (("pose", found.pose, (rows, 3)), ("covariance", found.covariance, (rows, 3, 3))):
        if problem := array_problem(array, f"a {what}", shape):
            return problem
    return ""
