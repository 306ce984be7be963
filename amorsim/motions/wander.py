"""Random motion: straight on with a slow drift of the course, and away from obstacles."""

from __future__ import annotations

import attrs
import numpy as np

from amorsim.array_types import Array
from amorsim.contracts import Context, Draws, Motion, State, View, parameter
from amorsim.motions.ways import blocked_for, displacement, facing

__all__ = ["Wander"]


@attrs.frozen(kw_only=True)
class Wander(Motion):
    """Goes on at one speed on a course that drifts at random, and takes another one when something is in the way.

    The course is a random walk: after t seconds it has turned by an angle of standard deviation `course_std` sqrt(t).
    The first course is random too.
    """

    speed: float = parameter(0.5, unit="m/s", ge=0, help="at which it goes")
    course_std: float = parameter(0.5, unit="rad/sqrt(s)", ge=0, help="standard deviation of the course after a second")
    blocked: str = parameter(
        "skip",
        choices=("wait", "skip"),
        help="what it does when something is in the way: keep its course until it is free, or take another at random",
    )
    patience: float = parameter(0.0, unit="s", ge=0, help="how long it is blocked before it takes another course")
    faces: str = parameter("ahead", choices=("ahead", "fixed"), help="whether it turns to where it goes")
    turn_rate: float = parameter(3.0, unit="rad/s", ge=0, help="how fast it turns, while it goes on")

    def start(self, context: Context) -> State:
        """No course yet; it is drawn in the first step."""
        return {"course": np.zeros((context.rows, 1)), "blocked": np.zeros((context.rows, 1))}

    def propose(self, view: View, dt: float, state: State, draws: Draws) -> Array:
        """Straight along the course."""
        waited = blocked_for(view, dt, state)
        fresh = (2.0 * draws.uniform(1) - 1.0) * np.pi
        course = state["course"] + self.course_std * np.sqrt(dt) * draws.normal(1)
        turning = view.tick == 0
        if self.blocked == "skip":
            turning = turning | ((view.free < 1.0) & (waited >= self.patience - 1e-9))
        else:
            course = np.where(view.free < 1.0, state["course"], course)
        state["course"] = np.where(turning, fresh, course)
        dx, dy = self.speed * dt * np.cos(state["course"]), self.speed * dt * np.sin(state["course"])
        turn = (
            facing(view, dx, dy, np.asarray(self.turn_rate * dt)) if self.faces == "ahead" else np.zeros((view.rows, 1))
        )
        return displacement(view, dx, dy, turn)
