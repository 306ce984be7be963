"""Things in sight that a device does not find."""

from __future__ import annotations

from collections.abc import Mapping

import attrs
import numpy as np

from amorsim.array_types import Array
from amorsim.contracts import Draws, Noise, State, parameter
from amorsim.core.errors import ComponentError

__all__ = ["Missed"]


@attrs.frozen(kw_only=True)
class Missed(Noise):
    """Empties a slot now and then: a mark or a blob in sight is not found, and all its values are lost.

    For sensors whose readings are tables with a slot for each thing seen: finders of marks and cameras. Each slot is
    emptied independently of the others and of earlier samples, with the probability ``probability + per_metre *
    range``. The other things keep their slots. The element takes no column, because it acts on whole slots.

    Parameters
    ----------
    probability
        Probability that a thing at range 0 is missed.
    per_metre
        Increase of the probability per metre of range [1/m].
    """

    probability: float = parameter(0.0, ge=0, le=1, help="that a thing close to the sensor is missed")
    per_metre: float = parameter(0.0, unit="1/m", ge=0, help="what each metre of its range adds to that")

    def corrupt(self, values: Array, side: Mapping[str, Array], elapsed: Array, state: State, draws: Draws) -> Array:
        """The values `(N, k)`, some slots emptied; `ComponentError` if the sensor has no slots."""
        if "slot" not in side:
            raise ComponentError(
                "Missed: expected a sensor that finds things and has a slot for each (fiducial, camera), got one that "
                "does not; take the element out of its chain"
            )
        slot = side["slot"][0].astype(np.int64)  # the same in all rows
        _, begins = np.unique(slot, return_index=True)
        away = side["range"][:, begins]
        chance = self.probability + self.per_metre * np.where(np.isfinite(away), away, 0.0)
        lost = draws.uniform(len(begins)) < chance
        return np.where(lost[:, slot], side["empty"], values)
