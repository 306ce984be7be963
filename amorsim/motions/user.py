"""A user's own motion: a plain function of one obstacle, or a class with such a method."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, ClassVar

import attrs
import numpy as np

from amorsim.array_types import Array
from amorsim.contracts import Context, Draws, Motion, State, View
from amorsim.core.error_text import RAISED, in_words
from amorsim.core.errors import ComponentError
from amorsim.core.user_code import UserCode
from amorsim.motions.ways import displacement

__all__ = ["ObstacleState", "UserMotion"]


# A faster body [m/s, rad/s] would be followed in too many short pieces for a step to end.
FASTEST = 1e6


@attrs.frozen
class ObstacleState:
    """The true state of the obstacle of a user's motion, and the poses of the bodies around it."""

    x: float  # [m], in the world
    y: float
    heading: float  # [rad], anticlockwise from the world's x axis
    free: float  # fraction of the last displacement that was free; 1 at first
    time: float  # [s], since the episode began
    dt: float  # [s]
    others: Array  # (B - 1, 3) poses of all other bodies: robots by name, then obstacles by name


@attrs.frozen(kw_only=True)
class UserMotion(UserCode, Motion):
    """Runs a user's function of one obstacle, or objects of a user's class, one for each obstacle.

    A function is called as ``function(obstacle, **options)``. From a class an object is made with the options as
    keyword arguments, and its method is called as ``velocity(obstacle)``. `obstacle` is an `ObstacleState`. The return
    value is the wanted velocity in the world: ``(x, y)`` [m/s] or ``(x, y, turn)`` [m/s, m/s, rad/s], or None to stand.
    """

    kind: ClassVar[str] = "motion"
    signature: ClassVar[str] = "velocity(self, obstacle)"

    def failure(self, message: str, name: str) -> ComponentError:
        """A `ComponentError`."""
        return ComponentError(message)

    def start(self, context: Context) -> State:
        """An object of the class for each row, ``state["objects"]`` `(N,)`; nothing for a function.

        Raises
        ------
        ComponentError
            If it cannot be called, an object cannot be made, or has no method `velocity`.
        """
        return dict(self.make_objects(context.rows, lambda row: _who(context.names, row)))

    def propose(self, view: View, dt: float, state: State, draws: Draws) -> Array:
        """The velocities times the step.

        Raises
        ------
        ComponentError
            If the user's code raises, or does not return a velocity.
        """
        caller = self.asker(state)
        bodies, names = view.bodies(), view.names
        wanted = np.zeros((view.rows, 3))
        for row in range(view.rows):
            others = np.delete(bodies.poses[row], bodies.own[row], axis=0)
            x, y, heading = view.body_pose[row].tolist()
            time = float(view.tick[row, 0]) * dt
            moment = ObstacleState(x, y, heading, float(view.free[row, 0]), time, dt, others)
            try:
                answer = caller(row)(moment)
            except RAISED as error:
                raise self.raised(error, _who(names, row), time, "") from error
            wanted[row] = self._velocity(answer, _who(names, row))
        dx, dy, turn = (wanted[:, i : i + 1] * dt for i in range(3))
        return displacement(view, dx, dy, turn)

    def _velocity(self, answer: Any, who: str) -> tuple[float, float, float]:
        if answer is None:
            return 0.0, 0.0, 0.0
        try:
            parts = [float(part) for part in answer]
        except RAISED:
            parts = []
        if len(parts) not in (2, 3) or not all(abs(part) <= FASTEST for part in parts):
            raise ComponentError(
                f"{self.title} of {who} returned {in_words(answer)}; expected the velocity (x, y) [m/s] in "
                f"the world, (x, y, turn) with rad/s, each at most {FASTEST:g}, or None to stand"
            )
        x, y, turn = (*parts, 0.0)[:3]
        return x, y, turn


def _who(names: Sequence[str], row: int) -> str:
    """The name of a row's obstacle for messages."""
    return f"obstacle {names[row]!r}" if names else f"row {row}"
