"""A tractor on two driven wheels, with a trailer behind it."""

from __future__ import annotations

import functools
import math
from typing import ClassVar

import attrs
import numpy as np

from amorsim.array_types import Array
from amorsim.contracts import Draws, Joint, Part, State, parameter
from amorsim.core.parameters import ParameterError, own_first
from amorsim.core.poses import compose, logarithm
from amorsim.core.shapes import Shape
from amorsim.drives.differential import Differential
from amorsim.kernels.kinematics import trailer

__all__ = ["Tractor"]


@attrs.frozen(kw_only=True, field_transformer=own_first)
class Tractor(Differential):
    """A differential drive that draws a trailer on one axle.

    The third joint is the hitch angle b: the tractor's heading less the trailer's, 0 at the start. It has no motor. It
    follows the body's true motion, after contact, in closed form: with v forward, w the turn, l the trailer's length
    and c the offset of the hitch, b' = w - (v / l) sin b + (c w / l) cos b. Drawn along a circle of radius R, a trailer
    hitched on the axle settles at sin b = l / R. Pushed, it jackknifes as far as `hitch_max`. There it moves as one
    body with the tractor, until the tractor pulls it straight again.

    The trailer is a body, a rectangle. Walls and other bodies stop it and with it the tractor, and others see it. It
    does not collide with its own tractor: give a `hitch_max` at which their outlines do not cross. The drawbar is too
    thin to touch or to be seen.

    Parameters
    ----------
    trailer_length
        Distance from the hitch to the trailer's axle [m].
    hitch_offset
        Distance of the hitch behind the tractor's axle [m].
    hitch_max
        Largest hitch angle to either side [rad].
    trailer_width
        Width of the trailer's outline [m].
    trailer_front, trailer_rear
        Length of the outline ahead of the trailer's axle, and behind it [m].
    wheel_radius_left, wheel_radius_right, track, rate_max, lag, acceleration_max
        Of the tractor; see `Differential`.
    """

    joints: ClassVar[tuple[Joint, ...]] = (*Differential.joints, Joint(name="hitch", rolls=False))

    trailer_length: float = parameter(unit="m", ge=1e-3, le=100, help="from the hitch to the trailer's axle")
    hitch_offset: float = parameter(
        0.0, unit="m", ge=-100, le=100, help="how far behind the tractor's axle the hitch is"
    )
    hitch_max: float = parameter(math.pi, unit="rad", gt=0, le=math.pi, help="how far the hitch turns to either side")
    trailer_width: float = parameter(unit="m", ge=1e-3, le=100, static=True, help="how wide the trailer's outline is")
    trailer_front: float = parameter(
        unit="m", le=100, static=True, help="how far its outline goes ahead of the trailer's axle"
    )
    trailer_rear: float = parameter(
        unit="m", le=100, static=True, help="how far its outline goes behind the trailer's axle"
    )

    def __attrs_post_init__(self) -> None:
        if self.trailer_front + self.trailer_rear < 1e-3:
            problem = f"expected 1 mm more than {-self.trailer_front!r}, behind its front, got {self.trailer_rear!r}"
            raise ParameterError("trailer_rear", problem)

    @property
    def parts(self) -> tuple[Part, ...]:  # type: ignore[override]
        """The trailer, in the frame of its axle."""
        return (Part("trailer", _outline(self.trailer_width, self.trailer_front, self.trailer_rear)),)

    def advance(
        self, joints: Array, rates: Array, command: Array, dt: float, state: State, draws: Draws
    ) -> tuple[Array, Array]:
        """Wheels and hitch `(N, 3)` [rad] and their rates a step later; the command is wheel rates [rad/s]."""
        wheels, wheel_rates = Differential.advance(self, _wheels(joints), _wheels(rates), command, dt, state, draws)
        after, new_rates = joints.copy(), np.zeros_like(rates)
        after[:, :2], new_rates[:, :2] = wheels, wheel_rates
        return after, new_rates

    def follow(self, joints: Array, displacement: Array) -> Array:
        """The joints `(N, 3)` after the hitch has followed the tractor's motion."""
        out = np.empty((len(joints), 1))
        trailer.follow_hitch(
            np.ascontiguousarray(joints[:, 2:]),
            logarithm(displacement),
            self.trailer_length,
            self.hitch_offset,
            self.hitch_max,
            out,
        )
        return np.concatenate((joints[:, :2], out), axis=1)

    def part_poses(self, joints: Array) -> Array:
        """Pose of the middle of the trailer's axle `(N, 1, 3)`, in the tractor's frame."""
        back = np.zeros((len(joints), 3))
        back[:, 0:1] = -np.asarray(self.hitch_offset)
        back[:, 2] = -joints[:, 2]
        length = np.zeros_like(back)
        length[:, 0:1] = -np.asarray(self.trailer_length)
        return compose(back, length)[:, None, :]

    def part_travel(self, before: Array, after: Array) -> Array:
        """Upper bounds `(N, 1, 2)` on the path of the trailer's axle [m] and on its turn [rad].

        If the hitch moves by h, the axle moves no farther, because it does not slip sideways, and turns by at most
        h / l. Where the hitch may reach its limit, the trailer may also turn with the tractor about the hitch.
        """
        twist = self.twist(before, after)
        turn = np.abs(twist[:, 2:])
        length, aside = np.asarray(self.trailer_length), np.asarray(self.hitch_offset) * turn
        hitch = np.sqrt(twist[:, :1] ** 2 + aside**2)
        reaches = np.abs(before[:, 2:]) + turn + hitch / length >= np.asarray(self.hitch_max)
        way = hitch + np.where(reaches, length * turn, 0.0)
        return np.stack((way, np.maximum(hitch / length, np.where(reaches, turn, 0.0))), axis=2)


@functools.lru_cache(maxsize=64)
def _outline(width: float, front: float, rear: float) -> Shape:
    return Shape.rectangle(front + rear, width, x=0.5 * (front - rear))


def _wheels(joints: Array) -> Array:
    return joints[:, :2].copy()
