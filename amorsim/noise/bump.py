"""Bumps of the floor that wheels roll over."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

import attrs
import numpy as np

from amorsim.array_types import Array
from amorsim.contracts import Context, Draws, Noise, State, parameter
from amorsim.core.errors import ComponentError
from amorsim.core.parameters import ParameterError
from amorsim.kernels import elementary
from amorsim.noise.joints import chosen

__all__ = ["Bump"]


_MOST = 64  # bumps under one wheel in one step


@attrs.frozen(kw_only=True)
class Bump(Noise):
    """Lets wheels roll over bumps: each costs some way over the ground, at once, that the encoder counts as gone.

    A wheel of radius R that climbs over an edge of height h turns about it by 2 phi, with cos phi = 1 - h / R. It rolls
    2 R phi but moves only 2 R sin phi ahead. It loses 2 R (phi - sin phi): 3.3 mm for 10 mm under a wheel of 165 mm.
    A bump under one wheel alone turns the robot. For the `ground` of any drive, or of a zone of the floor.

    In a zone, each wheel that enters it meets one bump, and rests on the border until it has rolled what that costs.
    Elsewhere all wheels meet one at the time `at`, or bumps are anywhere, on average `rate` of them per metre, a
    Poisson process along the way.

    Parameters
    ----------
    height
        Height of the bump [m], less than the wheel's radius.
    at
        Time at which wheels meet it [s], from the start of the episode.
    rate
        Bumps per metre of way [1/m].
    joint
        Name of the joint whose wheel meets bumps; without one, all rolling joints.
    """

    for_ground: ClassVar[bool] = True

    height: float = parameter(unit="m", ge=0, help="height of a bump, below the wheel's radius")
    at: float | None = parameter(None, unit="s", ge=0, help="when wheels meet one, from the start of the episode")
    rate: float | None = parameter(None, unit="1/m", ge=0, help="bumps on a metre of way")
    joint: str = parameter(
        "", static=True, refers="joints", help="name of the joint that meets bumps; empty for all that roll"
    )

    def __attrs_post_init__(self) -> None:
        if self.at is not None and self.rate is not None:
            raise ParameterError("at", "expected either at or rate, or none of them in a zone, got both")

    def start(self, context: Context) -> State:
        """Number of steps made `(N, 1)`; of joints `(N, r)`: radii, ways still to lose [m], and which meet bumps."""
        radius = np.asarray(context.robot.drive.rolling_radius())
        if radius.shape != (context.rows, context.size):
            raise ComponentError(
                f"Bump: expected the ground of a robot or a zone, with {radius.shape[-1]} joints that roll, got "
                f"{context.size} values"
            )
        return {
            "steps": np.zeros((context.rows, 1), dtype=np.int64),
            "radius": radius.copy(),
            "owes": np.zeros_like(radius),
            "meets": chosen("Bump", self.joint, context),
        }

    def corrupt(self, values: Array, side: Mapping[str, Array], elapsed: Array, state: State, draws: Draws) -> Array:
        """Travels `(N, r)` [m] over the ground; `ComponentError` for a bump without a place, or too high."""
        climb = self.height / state["radius"]
        if (climb >= 1.0).any():
            raise ComponentError(
                f"Bump: height: expected less than the wheel's radius, {float(state['radius'].min()):g} m, got "
                f"{float(np.max(self.height)):g} m"
            )
        # sin(phi) from cos(phi) = 1 - climb, without the cancellation.
        lacks = 2.0 * state["radius"] * (elementary.arccos(1.0 - climb) - np.sqrt(climb * (2.0 - climb)))
        if self.at is None and self.rate is None:
            # A wheel set back across the border would enter again, so it loses no more than it rolls in a step.
            entered, inside = _entered(side)
            owes = np.where(entered > 0.0, lacks * state["meets"], np.where(inside > 0.0, state["owes"], 0.0))
            lost = np.minimum(owes, np.abs(values))
            state["owes"] = owes - lost
        else:
            lost = self._met(values, elapsed, state, draws) * state["meets"] * lacks
        return np.where(lost > 0.0, values - np.sign(values) * lost, values)

    def _met(self, values: Array, elapsed: Array, state: State, draws: Draws) -> Array:
        """Number of bumps `(N, r)` at a time or on the way that each wheel meets in this step."""
        if self.at is not None:
            # By multiplication, not by summation: the time is still exact a billion steps later.
            # A step ends at the exact instant at which the next begins, so no bump falls between two steps.
            begin = state["steps"] * elapsed
            state["steps"] = state["steps"] + 1
            is_now = (begin <= self.at) & (self.at < state["steps"] * elapsed)
            return np.where(is_now, np.ones_like(values), 0.0)
        assert self.rate is not None
        return _poisson(draws.uniform(values.shape[1]), self.rate * np.abs(values))


def _entered(side: Mapping[str, Array]) -> tuple[Array, Array]:
    """Which wheels `(N, r)` enter the zone in this step, and which were inside before."""
    if "entered" not in side:
        raise ComponentError("Bump: expected at or rate, or to be in the ground of a zone; got none of them")
    return side["entered"], side["inside"]


def _poisson(chance: Array, mean: Array) -> Array:
    """Draws from a Poisson distribution, by its inverse distribution function at `chance` in (0, 1)."""
    term = elementary.exp(-mean)
    below, count = term, np.zeros_like(mean)
    for i in range(1, _MOST + 1):
        more = chance > below
        if not more.any():
            break
        count = count + more
        term = term * mean / i
        below = below + term
    return count
