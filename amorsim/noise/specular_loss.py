"""Specular loss: echoes that do not return."""

from __future__ import annotations

from collections.abc import Mapping

import attrs
import numpy as np

from amorsim.array_types import Array
from amorsim.contracts import Draws, Noise, State, parameter
from amorsim.core.errors import ComponentError

__all__ = ["SpecularLoss"]


@attrs.frozen(kw_only=True)
class SpecularLoss(Noise):
    """Loses the return of a surface that is met at more than a critical angle, as a mirror sends the pulse away.

    For sensors that give the angle of incidence of each value, between the beam and the normal of the surface that it
    hits: lasers and sonars. A sonar gives the angle of its nearest return, which is 0 if the surface's normal lies
    within the cone. Returns by way of a second wall (a corner) are not modelled.

    Parameters
    ----------
    critical
        Largest angle of incidence [rad] at which anything returns.
    """

    critical: float = parameter(unit="rad", ge=0, le=np.pi / 2.0, help="largest angle of incidence that returns")

    def corrupt(self, values: Array, side: Mapping[str, Array], elapsed: Array, state: State, draws: Draws) -> Array:
        """The ranges `(N, k)`, inf where the pulse is lost; `ComponentError` if the sensor gives no incidence."""
        if "incidence" not in side:
            raise ComponentError(
                "SpecularLoss: expected a sensor that reports the angle of incidence of its values (laser, sonar), got "
                "one that does not; take the element out of its chain"
            )
        return np.where(side["incidence"] > self.critical, np.inf, values)
