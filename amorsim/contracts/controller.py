"""The contract of controllers."""

from __future__ import annotations

import abc
from collections.abc import Mapping, Sequence

from amorsim.contracts.robot import Component, RobotModel
from amorsim.contracts.values import Array, Clock, Estimate, Measurement, State
from amorsim.core.draws import Draws

__all__ = ["Controller"]


class Controller(Component, abc.ABC):
    """Computes a command from readings and estimate. A plain function for one robot works as well."""

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
