"""The contract of motions: how an obstacle wants to move."""

from __future__ import annotations

import abc
from collections.abc import Sequence

from amorsim.array_types import Array
from amorsim.contracts.robot import Component
from amorsim.contracts.values import State
from amorsim.contracts.view import View
from amorsim.core.draws import Draws

__all__ = ["Motion"]


class Motion(Component, abc.ABC):
    """How an obstacle wants to move; ``view.free`` is the fraction of it that was free."""

    @abc.abstractmethod
    def propose(self, view: View, dt: float, state: State, draws: Draws) -> Array:
        """The displacement `(N, 3)` that is wanted in this step, in the obstacle's own frame."""

    def default_start(self) -> tuple[float, float, float] | None:
        """Start (x [m], y [m], heading [rad]) of an obstacle that is given no pose; None: the origin.

        Called on the motion as specified, before there are rows.
        """
        return None

    def goal_points(self) -> Sequence[tuple[str, float, float]]:
        """The goals of the motion in the world, as in `Controller.goal_points`."""
        return ()
