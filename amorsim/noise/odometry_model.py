"""The odometry motion model of probabilistic robotics, between wheel and ground."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

import attrs
import numpy as np
import numpy.typing as npt

from amorsim.contracts import Context, Draws, Noise, State, parameter
from amorsim.noise.body_motion import motion_squares, per_interval, start_motion, with_motion_error

__all__ = ["OdometryModel"]

Array = npt.NDArray[np.float64]


@attrs.frozen(kw_only=True)
class OdometryModel(Noise):
    """Gives each step, seen as a turn, a way and a second turn, normal errors in all three.

    With the step's turn halved, r1 = r2 [rad], and its way t [m], the errors have the variances a1 r1^2 + a2 t^2,
    a3 t^2 + a4 (r1^2 + r2^2) and a1 r2^2 + a2 t^2: the odometry model of S. Thrun, W. Burgard and D. Fox,
    "Probabilistic Robotics" (2005), whose r1 and r2 are equal on an arc. Both turns are spread over the step, for
    a pair of wheels can do no other; what is lost is a step aside, of second order in the errors.

    For the `ground` of a drive whose wheels turn the body by what they travel: of a differential one, whose left and
    right wheel travel t -+ (r1 + r2) track / 2, with the nominal track, or a mecanum drive, whose way is that in the
    direction in which it goes; any other is refused. As published, an error is drawn per step, so that over a given
    way the noise is the less, the shorter the steps; with `interval` it does not depend on the step.

    Parameters
    ----------
    a1, a2
        Variance of each turn per squared turn, and per squared way [rad^2/m^2].
    a3, a4
        Variance of the way per squared way, and per sum of the squared turns [m^2/rad^2].
    interval
        The step for which the numbers are meant [s]; none for whatever the simulation's is.
    """

    for_ground: ClassVar[bool] = True

    a1: float = parameter(0.0, ge=0, help="variance of each turn per squared turn")
    a2: float = parameter(0.0, unit="rad^2/m^2", ge=0, help="variance of each turn per squared way")
    a3: float = parameter(0.0, ge=0, help="variance of the way per squared way")
    a4: float = parameter(0.0, unit="m^2/rad^2", ge=0, help="variance of the way per sum of the squared turns")
    interval: float | None = parameter(None, unit="s", gt=0, help="step for which the numbers hold; none for any")

    def start(self, context: Context) -> State:
        """How the motion comes of the wheels; `ComponentError` for a drive of which that cannot be told."""
        return start_motion("OdometryModel", context)

    def corrupt(self, values: Array, side: Mapping[str, Array], elapsed: Array, state: State, draws: Draws) -> Array:
        """The travels `(N, r)` [m] over the ground."""
        way, turn = motion_squares(values, state)
        half_turn = 0.25 * turn
        share = per_interval(self.interval, elapsed)
        noise = draws.normal(3)
        turn_std = np.sqrt((self.a1 * half_turn + self.a2 * way) * share)
        turned = noise[:, :1] * turn_std + noise[:, 2:] * turn_std
        forward = noise[:, 1:2] * np.sqrt((self.a3 * way + self.a4 * (2.0 * half_turn)) * share)
        return with_motion_error(values, forward, turned, state)
