"""The noise of all plain devices of a group, in one call of a kernel."""

from __future__ import annotations

import itertools
from collections.abc import Sequence

import numpy as np

from amorsim.core.noise_steps import NoiseProgram
from amorsim.kernels.number_checks import has_nan
from amorsim.simulation.sensing.device import Device

__all__ = ["PlainNoise"]


class PlainNoise:
    """Gives the devices of `rows` robots their arrays, and applies the noise of those that are plain.

    Samples of plain devices lie one after another in one array, and so do their measured values.
    """

    def __init__(self, devices: Sequence[Device], rows: int) -> None:
        self.devices = [device for device in devices if device.is_plain]
        order = [*self.devices, *(device for device in devices if not device.is_plain)]
        ends = np.cumsum([0, *(rows * device.size for device in order)]).tolist()
        sampled, measured, ahead = (np.zeros(ends[-1]) for _ in range(3))
        for device, (first, end) in zip(order, itertools.pairwise(ends), strict=True):
            shape = rows, device.size
            device.lay_out(*(whole[first:end].reshape(shape) for whole in (sampled, measured, ahead)))
        plain = ends[len(self.devices)]
        self._sampled, self._measured = sampled[:plain], measured[:plain]
        program = NoiseProgram(
            [device.size for device in self.devices], [device.chain.steps or () for device in self.devices]
        )
        self._run = program.bind(self._sampled, self._measured)
        self.names = ", ".join(device.name for device in self.devices)

    def apply(self) -> None:
        """Write the measured values of this step's samples, which must be free of nan before and after it."""
        if has_nan(self._sampled):
            for device in self.devices:
                device.check(device.sampled, "sense()")
        self._run()
        if has_nan(self._measured):
            for device in self.devices:
                device.check_noise(device.measured)
