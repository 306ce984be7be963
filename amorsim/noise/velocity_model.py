"""The velocity motion model of probabilistic robotics, between wheel and ground."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

import attrs
import numpy as np

from amorsim.array_types import Array
from amorsim.contracts import Context, Draws, Noise, State, parameter
from amorsim.noise.body_motion import (
    acts_on_wheels,
    motion_squares,
    per_interval,
    slide_along,
    start_motion,
    with_motion_error,
)

__all__ = ["VelocityModel"]


@attrs.frozen(kw_only=True)
class VelocityModel(Noise):
    """Gives the body's speed and turning rate in each step normal errors that grow with both.

    With v [m/s] and w [rad/s] of the wheels' travel, the body really moves with v + N(a1 v^2 + a2 w^2) and
    w + N(a3 v^2 + a4 w^2) + N(a5 v^2 + a6 w^2), N(s) a normal error of variance s: the velocity model of
    S. Thrun, W. Burgard and D. Fox, "Probabilistic Robotics" (2005). The last term, there a turn on the spot at
    the end of the step, is spread over the step.

    For the `ground` of any drive. In a differential or mecanum drive the wheels turn the body by their travel, so the
    errors go into the travels; left and right wheel of a differential drive travel v dt -+ w dt track / 2, with the
    nominal track. A car, tricycle or synchro drive turns by its steering, which no travel changes: its body slides by
    the errors. v is the speed along the body's motion, w the turning rate of its frame.

    As published, an error is drawn per step: over a given way, shorter steps give less noise. With `interval` the
    noise does not depend on the step.

    Parameters
    ----------
    a1, a2
        Variance of the speed per squared speed, and per squared turning rate [m^2/rad^2].
    a3, a4
        Variance of the turning rate per squared speed [rad^2/m^2], and per squared turning rate.
    a5, a6
        The same of the final turn.
    interval
        The step for which the numbers are meant [s]; none for the simulation's step.
    """

    for_ground: ClassVar[bool] = True

    a1: float = parameter(0.0, ge=0, help="variance of the speed per squared speed")
    a2: float = parameter(0.0, unit="m^2/rad^2", ge=0, help="variance of the speed per squared turning rate")
    a3: float = parameter(0.0, unit="rad^2/m^2", ge=0, help="variance of the turning rate per squared speed")
    a4: float = parameter(0.0, ge=0, help="variance of the turning rate per squared turning rate")
    a5: float = parameter(0.0, unit="rad^2/m^2", ge=0, help="variance of the final turn's rate per squared speed")
    a6: float = parameter(0.0, ge=0, help="variance of the final turn's rate per squared turning rate")
    interval: float | None = parameter(None, unit="s", gt=0, help="step for which the numbers hold; none for any")

    def start(self, context: Context) -> State:
        """How wheel travel moves the body, if it does; `ComponentError` if the values are not travels."""
        return start_motion("VelocityModel", context)

    def corrupt(self, values: Array, side: Mapping[str, Array], elapsed: Array, state: State, draws: Draws) -> Array:
        """The travels `(N, r)` [m] over the ground."""
        if not acts_on_wheels(state):
            return values
        return with_motion_error(values, *self._errors(*motion_squares(values, state), elapsed, draws), state)

    def slide(self, motion: Array, elapsed: Array, state: State, draws: Draws) -> Array:
        """The errors `(N, 3)` [m, m, rad] of a body that turns by its steering."""
        if acts_on_wheels(state):
            return np.zeros_like(motion)
        way, turn = self._errors(motion[:, :1] ** 2 + motion[:, 1:2] ** 2, motion[:, 2:] ** 2, elapsed, draws)
        return slide_along(motion, way, np.zeros_like(way), turn)

    def _errors(self, way: Array, turn: Array, elapsed: Array, draws: Draws) -> tuple[Array, Array]:
        """Errors of the way [m] and the turn [rad] `(N, 1)`, by the squares of both."""
        # Both sides of the model are multiplied by dt^2, which cancels.
        share = per_interval(self.interval, elapsed)
        noise = draws.normal(3)
        forward = noise[:, :1] * np.sqrt((self.a1 * way + self.a2 * turn) * share)
        turned = noise[:, 1:2] * np.sqrt((self.a3 * way + self.a4 * turn) * share)
        final = noise[:, 2:] * np.sqrt((self.a5 * way + self.a6 * turn) * share)
        return forward, turned + final
