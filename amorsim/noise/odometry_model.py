"""The odometry motion model of probabilistic robotics, between wheel and ground."""

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

__all__ = ["OdometryModel"]


@attrs.frozen(kw_only=True)
class OdometryModel(Noise):
    """Gives each step, seen as a turn, a way and a second turn, normal errors in all three.

    With the step's turn halved, r1 = r2 [rad], and its way t [m], the errors have the variances a1 r1^2 + a2 t^2,
    a3 t^2 + a4 (r1^2 + r2^2) and a1 r2^2 + a2 t^2: the odometry model of S. Thrun, W. Burgard and D. Fox,
    "Probabilistic Robotics" (2005), whose r1 and r2 are equal on an arc. With errors e1 and e2 of the turns, the body
    turns by e1 + e2, evenly over the step, and slides aside by t (e1 - e2) / 2. To first order this is the position of
    the published model.

    For the `ground` of any drive. In a differential or mecanum drive the wheels turn the body by their travel, so the
    errors of way and turn go into the travels; left and right wheel of a differential drive travel
    t -+ (r1 + r2) track / 2, with the nominal track. A car, tricycle or synchro drive turns by its steering, which no
    travel changes: its body slides by all errors. The way is along the body's motion, the turn that of its frame.

    As published, an error is drawn per step: over a given way, shorter steps give less noise. With `interval` the
    noise does not depend on the step.

    Parameters
    ----------
    a1, a2
        Variance of each turn per squared turn, and per squared way [rad^2/m^2].
    a3, a4
        Variance of the way per squared way, and per sum of the squared turns [m^2/rad^2].
    interval
        The step for which the numbers are meant [s]; none for the simulation's step.
    """

    for_ground: ClassVar[bool] = True

    a1: float = parameter(0.0, ge=0, help="variance of each turn per squared turn")
    a2: float = parameter(0.0, unit="rad^2/m^2", ge=0, help="variance of each turn per squared way")
    a3: float = parameter(0.0, ge=0, help="variance of the way per squared way")
    a4: float = parameter(0.0, unit="m^2/rad^2", ge=0, help="variance of the way per sum of the squared turns")
    interval: float | None = parameter(None, unit="s", gt=0, help="step for which the numbers hold; none for any")

    def start(self, context: Context) -> State:
        """How wheel travel moves the body, if it does; `ComponentError` if the values are not travels."""
        return start_motion("OdometryModel", context)

    def corrupt(self, values: Array, side: Mapping[str, Array], elapsed: Array, state: State, draws: Draws) -> Array:
        """The travels `(N, r)` [m] over the ground."""
        if not acts_on_wheels(state):
            return values
        forward, first, second = self._errors(*motion_squares(values, state), elapsed, draws)
        return with_motion_error(values, forward, first + second, state)

    def slide(self, motion: Array, elapsed: Array, state: State, draws: Draws) -> Array:
        """The slide aside `(N, 3)` [m, m, rad]; for a body that turns by steering, all errors."""
        way = motion[:, :1] ** 2 + motion[:, 1:2] ** 2
        # The wheels carry the sum of two equal normal errors. Their difference is independent of it, so draw it here.
        forward, first, second = self._errors(way, motion[:, 2:] ** 2, elapsed, draws)
        aside = 0.5 * np.sqrt(way) * (first - second)
        if acts_on_wheels(state):
            return slide_along(motion, np.zeros_like(way), aside, np.zeros_like(way))
        return slide_along(motion, forward, aside, first + second)

    def _errors(self, way: Array, turn: Array, elapsed: Array, draws: Draws) -> tuple[Array, Array, Array]:
        """Errors of the way [m] and of both turns [rad] `(N, 1)`, by the squares of way and turn."""
        half_turn = 0.25 * turn
        share = per_interval(self.interval, elapsed)
        noise = draws.normal(3)
        turn_std = np.sqrt((self.a1 * half_turn + self.a2 * way) * share)
        forward = noise[:, 1:2] * np.sqrt((self.a3 * way + self.a4 * (2.0 * half_turn)) * share)
        return forward, noise[:, :1] * turn_std, noise[:, 2:] * turn_std
