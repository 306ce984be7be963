"""A robot that drives about at random, by `command_for`, whatever its drive."""

from __future__ import annotations

from typing import Any

import attrs
import numpy as np

from amorsim.contracts import Clock, Context, Controller, Draws, Estimate, RobotModel, State, parameter
from amorsim.contracts.joints import joints_of
from amorsim.controllers.abilities import command_along, twist_limits

__all__ = ["Anywhere"]


@attrs.frozen(kw_only=True)
class Anywhere(Controller):
    """A new velocity every second, up to what the drive can do; mostly ahead, and aside for those that can."""

    share: float = parameter(1.0, gt=0, help="of the fastest speed, and twice that of the fastest turn that it takes")

    def start(self, context: Context) -> State:
        limits = twist_limits(context.robot)
        return {"fastest": limits[:, :2].copy(), "twist": np.zeros((context.rows, 3))}

    def command(
        self,
        robot: RobotModel,
        readings: Any,
        estimate: Estimate,
        clock: Clock,
        state: State,
        draws: Draws,
    ) -> Any:
        fresh = draws.uniform(3)
        speed = state["fastest"][:, :1] * self.share
        turn = np.minimum(state["fastest"][:, 1:], 1.5)
        wanted = np.concatenate(
            ((1.4 * fresh[:, :1] - 0.4) * speed, 0.4 * (fresh[:, 1:2] - 0.5) * speed, (fresh[:, 2:] - 0.5) * turn),
            axis=1,
        )
        again = clock.tick % round(1.0 / clock.dt) == 0
        state["twist"] = np.where(again, wanted, state["twist"])
        return command_along(robot, state["twist"], joints_of(robot, readings))
