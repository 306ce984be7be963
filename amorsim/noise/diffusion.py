"""Noise between wheel and ground, that grows with the way."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

import attrs

from amorsim.array_types import Array
from amorsim.contracts import Draws, Noise, State, parameter
from amorsim.kernels.sensing import noise_elements

__all__ = ["Diffusion"]


@attrs.frozen(kw_only=True)
class Diffusion(Noise):
    """Adds to each travel normal noise with a variance in proportion to its length; none at rest.

    For the `ground` chain, whose values are the travels [m] of all rolling joints in a step. The variances of
    independent steps add up, so the noise on a way does not depend on its number of steps (K. S. Chong and
    L. Kleeman, "Accurate odometry and error modelling for a mobile robot", ICRA 1997).

    Parameters
    ----------
    variance_per_length
        Variance of the travel, per metre of it [m^2/m].
    """

    for_ground: ClassVar[bool] = True

    variance_per_length: float = parameter(unit="m", ge=0, help="variance of the travel [m^2] per metre of it")

    def corrupt(self, values: Array, side: Mapping[str, Array], elapsed: Array, state: State, draws: Draws) -> Array:
        """The travels `(N, r)` [m] over the ground."""
        noise = draws.normal(values.shape[1])
        noise_elements.diffuse(values, self.variance_per_length, noise)
        return noise
