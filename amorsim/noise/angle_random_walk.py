"""White noise of a rate, by its density."""

from __future__ import annotations

from collections.abc import Mapping

import attrs

from amorsim.array_types import Array
from amorsim.contracts import Draws, Noise, State, parameter
from amorsim.kernels.sensing import noise_elements

__all__ = ["AngleRandomWalk"]


@attrs.frozen(kw_only=True)
class AngleRandomWalk(Noise):
    """Adds white noise to a rate, such that its integral is a random walk that does not depend on the rate of samples.

    A sample stands for the time since the previous one. Its noise is normal with the standard deviation
    density / sqrt(elapsed). The first sample stands for no time and has no noise. For a gyro this is the angle
    random walk N of IEEE Std 952: the angle is off by N sqrt(t) after a time t; the Allan deviation is N / sqrt(t).

    Parameters
    ----------
    density
        Standard deviation of the mean over one second, in the sensor's unit: for a gyro N in (rad/s)/sqrt(Hz).
        The *one-sided* density in a data sheet, which belongs to a bandwidth, is sqrt(2) times as large.
    """

    density: float = parameter(unit="sensor", ge=0, help="standard deviation of the mean over 1 s, per root hertz")

    def corrupt(self, values: Array, side: Mapping[str, Array], elapsed: Array, state: State, draws: Draws) -> Array:
        """The values `(N, k)` with noise on them."""
        noise = draws.normal(values.shape[1])
        noise_elements.spread(values, self.density, elapsed, noise)
        return noise
