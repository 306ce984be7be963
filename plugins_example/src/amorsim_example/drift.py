"""A noise that keeps state: an error that wanders slowly."""

from __future__ import annotations

from collections.abc import Mapping

import attrs
import numpy as np
import numpy.typing as npt

import amorsim as am

__all__ = ["Drift"]

Array = npt.NDArray[np.float64]


@attrs.frozen(kw_only=True)
class Drift(am.Noise):
    """Adds an error that wanders about 0, as the zero of a device does while it warms up and cools down.

    A Gauss-Markov process of first order, for each value by itself. It starts at 0, as if the device had just been
    calibrated. After a time t its variance is ``std**2 * (1 - exp(-2 * t / time_constant))``, however often the
    device was read up to then.

    Parameters
    ----------
    std
        Standard deviation of the error in the long run, in the sensor's unit.
    time_constant
        Time after which the error has forgotten all but 1/e of what it was [s].
    """

    std: float = am.parameter(unit="sensor", ge=0, help="standard deviation of the error in the long run")
    time_constant: float = am.parameter(60.0, unit="s", gt=0, help="time after which all but 1/e of an error is gone")

    def start(self, context: am.Context) -> am.State:
        """The error of each value `(N, k)`: none yet."""
        return {"error": np.zeros((context.rows, context.size))}

    def corrupt(
        self, values: Array, side: Mapping[str, Array], elapsed: Array, state: am.State, draws: am.Draws
    ) -> Array:
        """The values `(N, k)` with the error on them."""
        # The exact step of the process for any elapsed time: no Euler step that a rate or dt could make wrong.
        kept = np.exp(-elapsed / self.time_constant)
        fresh = self.std * np.sqrt(-np.expm1(-2.0 * elapsed / self.time_constant))
        state["error"] = kept * state["error"] + fresh * draws.normal(values.shape[1])
        return values + state["error"]
