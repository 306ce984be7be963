"""A tractor on two driven wheels, with a trailer behind it."""

from __future__ import annotations

from typing import ClassVar

import attrs
import numpy as np
import numpy.typing as npt

from amorsim.contracts import Draws, Joint, State, parameter
from amorsim.core.poses import compose, logarithm
from amorsim.drives.differential import Differential
from amorsim.drives.motors import own_first
from amorsim.kernels import trailer

__all__ = ["Tractor"]

Array = npt.NDArray[np.float64]


@attrs.frozen(kw_only=True, field_transformer=own_first)
class Tractor(Differential):
    """A differential drive that draws a trailer on one axle.

    The third joint is the hitch: the tractor's heading less the trailer's, 0 at the start. Nobody drives it. It follows
    what the body really did, after contact, in closed form: with v forward, w the turn, l the trailer's length and c
    the offset of the hitch, b' = w - (v / l) sin b + (c w / l) cos b. Drawn along a circle of radius R, a trailer
    hitched on the axle comes to sin b = l / R; pushed, it folds under.

    The trailer is no body: it meets no walls, and nobody sees it.

    Parameters
    ----------
    trailer_length
        From the hitch to the trailer's axle [m].
    hitch_offset
        How far behind the tractor's axle the hitch is [m].
    wheel_radius_left, wheel_radius_right, track, rate_max, lag, acceleration_max
        Of the tractor; see `Differential`.
    """

    joints: ClassVar[tuple[Joint, ...]] = (*Differential.joints, Joint(name="hitch", rolls=False))

    trailer_length: float = parameter(unit="m", gt=0, help="from the hitch to the trailer's axle")
    hitch_offset: float = parameter(0.0, unit="m", help="how far behind the tractor's axle the hitch is")

    def advance(
        self, joints: Array, rates: Array, command: Array, dt: float, state: State, draws: Draws
    ) -> tuple[Array, Array]:
        """Wheels and hitch `(N, 3)` [rad] and their rates a step later; the command is wheel rates [rad/s]."""
        wheels, wheel_rates = Differential.advance(self, _wheels(joints), _wheels(rates), command, dt, state, draws)
        after, new_rates = joints.copy(), np.zeros_like(rates)
        after[:, :2], new_rates[:, :2] = wheels, wheel_rates
        return after, new_rates

    def twist(self, before: Array, after: Array) -> Array:
        """Motion of the tractor (forward [m], 0, turn [rad]) `(N, 3)`."""
        return Differential.twist(self, _wheels(before), _wheels(after))

    def follow(self, joints: Array, displacement: Array) -> Array:
        """The joints `(N, 3)` once the hitch has followed what the tractor did."""
        out = np.empty((len(joints), 1))
        trailer.follow_hitch(
            np.ascontiguousarray(joints[:, 2:]), logarithm(displacement), self.trailer_length, self.hitch_offset, out
        )
        return np.concatenate((joints[:, :2], out), axis=1)

    def trailer_poses(self, poses: Array, joints: Array) -> Array:
        """Where the middles of the trailers' axles are, and how they head `(N, 3)`, with tractors at `poses`."""
        back = np.zeros_like(poses)
        back[:, 0:1] = -np.asarray(self.hitch_offset)
        back[:, 2] = -joints[:, 2]
        length = np.zeros_like(poses)
        length[:, 0:1] = -np.asarray(self.trailer_length)
        return compose(compose(poses, back), length)


def _wheels(joints: Array) -> Array:
    return joints[:, :2].copy()
