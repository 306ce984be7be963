"""All sensors of a group: each senses, and one call of a kernel applies all noise that is written as steps."""

from __future__ import annotations

import itertools
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from amorsim.core.noise_steps import NoiseProgram
from amorsim.kernels.numbers import has_nan
from amorsim.simulation.row_clock import RowClock
from amorsim.simulation.sensing.sensor_unit import Sample, SensorUnit
from amorsim.simulation.world.sensor_view import GroupView

__all__ = ["SensorSuite"]

Array = npt.NDArray[np.float64]


class SensorSuite:
    """The sensors of `rows` robots, laid out when their parameters are set."""

    def __init__(self, units: Sequence[SensorUnit], rows: int) -> None:
        ends = np.cumsum([0, *(rows * unit.size for unit in units)]).tolist()
        places = itertools.starmap(slice, itertools.pairwise(ends))
        self._laid_out = list(zip(units, places, strict=True))
        self._values = ends[-1]
        self._noise = NoiseProgram([unit.size for unit in units], [unit.chain.steps or () for unit in units])

    def read(self, view: GroupView, row_clock: RowClock) -> None:
        """Read the sensors that are due, and deliver the readings that arrive."""
        samples: list[tuple[SensorUnit, slice, Sample]] = []
        values = np.zeros(self._values)  # of all devices; zeros for those that are not due
        for unit, place in self._laid_out:
            sample = unit.look(view, row_clock)
            if sample is None:
                unit.wait(row_clock)
            elif unit.chain.steps is None:  # now, because its elements may use the view while it is set to this sensor
                unit.take(sample, unit.corrupted(sample), row_clock)
            else:
                values[place] = sample.values.ravel()
                samples.append((unit, place, sample))
        if has_nan(values):
            for unit, _, sample in samples:
                unit.check(sample.values, "sense()")
        measured = self._noise.apply(values)
        if has_nan(measured):
            for unit, place, _ in samples:
                unit.check_noise(measured[place].reshape(unit.shape))
        for unit, place, sample in samples:
            unit.take(sample, measured[place].reshape(unit.shape), row_clock)
