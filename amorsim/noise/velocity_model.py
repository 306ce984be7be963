"""The velocity motion model of probabilistic robotics, between wheel and ground."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

import attrs
import numpy as np
import numpy.typing as npt

from amorsim.contracts import Context, Draws, Noise, State, parameter
from amorsim.noise.body_motion import motion_squares, per_interval, start_motion, with_motion_error

__all__ = ["VelocityModel"]

Array = npt.NDArray[np.float64]


@attrs.frozen(kw_only=True)
class VelocityModel(Noise):
    """Gives the body's speed and turning rate in each step normal errors that grow with both.

    With v [m/s] and w [rad/s] of the wheels' travel, the body really moves with v + N(a1 v^2 + a2 w^2) and
    w + N(a3 v^2 + a4 w^2) + N(a5 v^2 + a6 w^2), N(s) a normal error of variance s: the velocity model of
    S. Thrun, W. Burgard and D. Fox, "Probabilistic Robotics" (2005). The last term, there a turn on the spot at
    the end of the step, is spread over the step, for a pair of wheels can do no other.

    For the `ground` of a drive whose wheels turn the body by what they travel: of a differential one, whose left and
    right wheel travel v dt -+ w dt track / 2, with the nominal track, or a mecanum drive, whose speed is that in the
    direction in which it goes; any other is refused. As published, an error is drawn per step, so that over a given
    way the noise is the less, the shorter the steps; with `interval` it does not depend on the step.

    Parameters
    ----------
    a1, a2
        Variance of the speed per squared speed, and per squared turning rate [m^2/rad^2].
    a3, a4
        Variance of the turning rate per squared speed [rad^2/m^2], and per squared turning rate.
    a5, a6
        The same of the final turn.
    interval
        The step for which the numbers are meant [s]; none for whatever the simulation's is.
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
        """How the motion comes of the wheels; `ComponentError` for a drive of which that cannot be told."""
        return start_motion("VelocityModel", context)

    def corrupt(self, values: Array, side: Mapping[str, Array], elapsed: Array, state: State, draws: Draws) -> Array:
        """The travels `(N, r)` [m] over the ground."""
        # Squares of the way and of the turn: both sides of the model times dt^2, which so falls out.
        way, turn = motion_squares(values, state)
        share = per_interval(self.interval, elapsed)
        noise = draws.normal(3)
        forward = noise[:, :1] * np.sqrt((self.a1 * way + self.a2 * turn) * share)
        turned = noise[:, 1:2] * np.sqrt((self.a3 * way + self.a4 * turn) * share)
        final = noise[:, 2:] * np.sqrt((self.a5 * way + self.a6 * turn) * share)
        return with_motion_error(values, forward, turned + final, state)
