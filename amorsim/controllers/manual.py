"""Driving by hand."""

from __future__ import annotations

from collections.abc import Mapping

import attrs
import numpy as np
import numpy.typing as npt

from amorsim.contracts import Clock, Context, Controller, Draws, Estimate, Measurement, RobotModel, State

__all__ = ["Manual"]

Array = npt.NDArray[np.float64]


@attrs.frozen(kw_only=True)
class Manual(Controller):
    """Gives the command that was last set from outside, 0 before the first.

    The engine writes it into the state, ``state["command"]`` `(N, c)`: for users there is
    ``sim.robot(name).command(...)`` and ``.drive(...)``.
    """

    def start(self, context: Context) -> State:
        """A command of zeros."""
        return {"command": np.zeros((context.rows, len(context.robot.channels)))}

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
