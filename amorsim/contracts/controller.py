"""The contract of controllers."""

from __future__ import annotations

import abc
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from amorsim.array_types import Array
from amorsim.contracts.binding import ControllerBinding, simple_form_first
from amorsim.contracts.robot import Component, RobotModel
from amorsim.contracts.values import Beliefs, Clock, Estimate, Measurement, State
from amorsim.core.draws import Draws

__all__ = ["Controller", "command_bound"]


class Controller(Component, abc.ABC):
    """Computes a command from readings and estimate. A plain function for one robot works as well."""

    def __init_subclass__(cls, **kwargs: Any) -> None:
        super().__init_subclass__(**kwargs)
        simple_form_first(cls, {"command": "bind"}, Controller)

    def bind(self, at: ControllerBinding) -> Callable[[], None]:
        """The function that each step calls: it writes the command into ``at.out``.

        By default it calls `command`; override it, too, for a controller that runs as a kernel on the engine's own
        arrays.
        """

        def command() -> None:
            # Copies: what is given may be written into, and the engine's arrays are in use.
            estimate = Estimate(at.estimate.pose.copy(), at.estimate.covariance.copy())
            clock = Clock(tick=at.tick.copy(), time=at.time.copy(), dt=at.dt)
            at.answer(self.command(at.robot, at.copied_readings, estimate, clock, at.state, at.draws))

        return command

    @abc.abstractmethod
    def command(
        self,
        robot: RobotModel,
        readings: Mapping[str, Measurement],
        estimate: Estimate,
        clock: Clock,
        state: State,
        draws: Draws,
    ) -> Array:
        """The command `(N, c)`: all of ``robot.channels`` in order, or only the drive's, which leaves devices at 0."""

    def goal_points(self) -> Sequence[tuple[str, float, float]]:
        """The goals of the controller in the world: the field of each ("waypoints.2"), x and y [m].

        Called on the controller as specified, before stacking; ``amorsim check`` reports goals that are out of reach.
        """
        return ()

    def reports(self, state: State) -> Sequence[tuple[int, str, object]]:
        """The reports of the last `command`: the row, a word such as ``"goal_reached"``, and a number or text.

        Each becomes an event of the kind ``"report"``. Called after each `command`; do not change `state`.
        """
        return ()

    def beliefs(self, state: State) -> Beliefs:
        """Its intentions and comparisons in the last `command`: a path, arcs ...; nothing by default.

        The same rules hold as for `Estimator.beliefs`. Frames have them under the name ``"controller"``.
        """
        return {}


def command_bound(
    bind: Callable[[ControllerBinding], Callable[[], None]],
    robot: RobotModel,
    readings: Mapping[str, Measurement],
    estimate: Estimate,
    clock: Clock,
    state: State,
    draws: Draws,
) -> Array:
    """What a controller that is written as `Controller.bind` returns from `Controller.command`.

    `bind` is that of its own class, as a subclass may have another one.
    """
    out = np.zeros((robot.rows, len(robot.drive.channels)))
    at = ControllerBinding(
        robot=robot,
        readings=readings,
        copied_readings=readings,
        estimate=estimate,
        tick=clock.tick,
        time=clock.time,
        dt=clock.dt,
        state=state,
        draws=draws,
        out=out,
        answer=lambda _: None,  # nothing is returned
    )
    bind(at)()
    return out
