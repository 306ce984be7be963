"""The contract of estimators."""

from __future__ import annotations

import abc
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from amorsim.array_types import Array, Bools
from amorsim.contracts.binding import EstimatorBinding, simple_form_first
from amorsim.contracts.robot import Component, RobotModel
from amorsim.contracts.values import Beliefs, Estimate, Measurement, State
from amorsim.core.draws import Draws

__all__ = ["ESTIMATES", "Estimator", "update_bound"]

ESTIMATES = "estimators."
"""Begins the keys of estimates among the readings that an estimator gets."""


class Estimator(Component, abc.ABC):
    """Estimates the robot's pose from its readings, the nominal robot and its knowledge, never from the true world."""

    def __init_subclass__(cls, **kwargs: Any) -> None:
        super().__init_subclass__(**kwargs)
        simple_form_first(cls, {"update": "bind"}, Estimator)

    def bind(self, at: EstimatorBinding) -> Callable[[], None]:
        """The function that each step calls: it writes the estimate into ``at.out``.

        By default it calls `update`; override it, too, for an estimator that runs on the engine's own arrays.
        """

        def update() -> None:
            given = at.robot, at.copied_readings(), at.command.copy(), at.elapsed()
            at.answer(self.update(*given, at.state, at.draws))

        return update

    @abc.abstractmethod
    def update(
        self,
        robot: RobotModel,
        readings: Mapping[str, Measurement],
        command: Array,
        elapsed: Array,
        state: State,
        draws: Draws,
    ) -> Estimate:
        """The estimate after this step's readings; `elapsed` `(N, 1)` [s] since the previous one (0 at the start).

        For each field with ``refers="estimators"`` that names another estimator of the robot, `readings` also has that
        one's estimate of this step: ``readings["estimators.NAME"].measured`` `(N, 12)` is its pose, followed by its
        covariance row by row. It is `fresh` where it is current.
        """

    def is_current(self, readings: Mapping[str, Measurement], state: State) -> Bools | None:
        """Where the last estimate is of its step `(N, 1)`, or None: everywhere.

        It is not where the wheels have turned and their reading was lost: the next one shows how far. By default it is
        ``state["current"]``, where the estimator keeps that. Asked only where another estimator takes the estimate.
        """
        return state.get("current")

    def beliefs(self, state: State) -> Beliefs:
        """Its further beliefs after the last update: innovations, verdicts of gates, biases ...; nothing by default.

        Called only when a recorder, a viewer or the controller asks, so compute here what `update` does not need.
        Names and shapes are the same in every step: (N, ...), of float64, int64 or bool, first axis the row. Values are
        finite, or nan where there is nothing. Return arrays that later steps do not write into. Do not change `state`.
        A recorder of text asks in every step, but for small arrays alone: return `amorsim.contracts.LazyBeliefs` to
        compute large ones only when somebody looks them up.
        """
        return {}

    def failed(self, state: State) -> Bools | None:
        """Rows `(N,)` whose numbers exploded in the last update, which it continues from an earlier state; or None.

        Each is an event ``"estimator_failed"``. A field ``on_failure`` of the value ``"end"`` ends the robot's
        controller.
        """
        return None

    def sources(self) -> Sequence[tuple[str, str, str]]:
        """Its sources of information: what each is, what it shows of the state, and how far it is trusted.

        Called on the estimator as specified, before stacking; ``amorsim check`` prints it as a table.
        """
        return ()


def update_bound(
    bind: Callable[[EstimatorBinding], Callable[[], None]],
    robot: RobotModel,
    readings: Mapping[str, Measurement],
    command: Array,
    elapsed: Array,
    state: State,
    draws: Draws,
) -> Estimate:
    """What an estimator that is written as `Estimator.bind` returns from `Estimator.update`.

    `bind` is that of its own class, as a subclass may have another one.
    """
    out = Estimate(np.empty((robot.rows, 3)), np.empty((robot.rows, 3, 3)))
    at = EstimatorBinding(
        robot=robot,
        readings=readings,
        copied_readings=lambda: readings,
        command=command,
        elapsed=lambda: elapsed,
        state=state,
        draws=draws,
        out=out,
        answer=lambda _: None,  # nothing is returned
    )
    bind(at)()
    return out
