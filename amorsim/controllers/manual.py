"""Driving by hand."""

from __future__ import annotations

import functools
from collections.abc import Callable, Mapping

import attrs
import numpy as np

from amorsim.array_types import Array
from amorsim.contracts import (
    Clock,
    Context,
    Controller,
    ControllerBinding,
    Draws,
    Estimate,
    Measurement,
    RobotModel,
    State,
    parameter,
)

__all__ = ["Manual", "limited"]


@attrs.frozen(kw_only=True)
class Manual(Controller):
    """Gives the command that was last set from outside, 0 before the first.

    The engine writes it into the state, ``state["command"]`` `(N, c)`: for users there is
    ``sim.robot(name).command(...)``, channel by channel as the drive has them, and ``.drive(forward, turn, left)`` for
    any drive.

    Parameters
    ----------
    speed, turn_rate
        Limits of ``drive`` [m/s, rad/s]: a faster velocity is scaled down as a whole, which keeps the curve. None for
        no limit; the drive's own limits always hold.
    """

    speed: float | None = parameter(None, unit="m/s", gt=0, help="most that drive() asks for; none for no limit")
    turn_rate: float | None = parameter(None, unit="rad/s", gt=0, help="fastest turn that drive() asks for, or none")

    def start(self, context: Context) -> State:
        """A command of zeros."""
        return {"command": np.zeros((context.rows, len(context.robot.channels)))}

    def bind(self, at: ControllerBinding) -> Callable[[], None]:
        """Copy the command from the state."""
        return functools.partial(np.copyto, at.out, at.state["command"])

    def command(
        self,
        robot: RobotModel,
        readings: Mapping[str, Measurement],
        estimate: Estimate,
        clock: Clock,
        state: State,
        draws: Draws,
    ) -> Array:
        """The command `(N, c)` as it was last set."""
        return state["command"].copy()


def limited(controller: Controller | None, twists: Array) -> Array:
    """Velocities `(N, 3)` within the limits of a `Manual` controller, each scaled down as a whole."""
    if not isinstance(controller, Manual) or (controller.speed is None and controller.turn_rate is None):
        return twists
    over = np.ones((len(twists), 1))
    way = np.sqrt(twists[:, 0:1] * twists[:, 0:1] + twists[:, 1:2] * twists[:, 1:2])
    for limit, size in ((controller.speed, way), (controller.turn_rate, np.abs(twists[:, 2:3]))):
        if limit is not None:
            over = np.maximum(over, size / limit)
    return twists / over
