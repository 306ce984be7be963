"""All sensors of a group: each senses, and the noise of all that is steps of a kernel is done in one call."""

from __future__ import annotations

import itertools
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from amorsim.core.noise_steps import NoiseProgram
from amorsim.kernels.sensing.noise_steps import has_nan
from amorsim.simulation.row_clock import RowClock
from amorsim.simulation.sensing.sensor_unit import Sample, SensorUnit
from amorsim.simulation.world.sensor_view import GroupView

__all__ = ["SensorSuite"]

Array = npt.NDArray[np.float64]


class SensorSuite:
    """The sensors of `rows` robots, laid out once when their parameters are set."""

    def __init__(self, units: Sequence[SensorUnit], rows: int) -> None:
        self._units = units
        ends = np.cumsum([0, *(rows * unit.size for unit in units)]).tolist()
        self._places = [slice(begin, end) for begin, end in itertools.pairwise(ends)]
        self._values = ends[-1]
        self._noise = NoiseProgram([unit.size for unit in units], [unit.chain.steps or () for unit in units])

    def read(self, view: GroupView, row_clock: RowClock) -> None:
        """Read where a reading is due, take delivery of what arrives, and hold the rest."""
        samples: list[Sample | None] = []
        values = np.zeros(self._values)  # of all devices; those that are not due leave zeros
        for unit, place in zip(self._units, self._places, strict=True):
            due, count = unit.due(row_clock)
            if count == 0:
                samples.append(None)
                continue
            sample = unit.look(view, row_clock, due, count)
            values[place] = sample.values.ravel()
            samples.append(sample)
        if has_nan(values):
            for unit, suspect in zip(self._units, samples, strict=True):
                if suspect is not None:
                    unit.check(suspect.values)
        measured = self._noise.apply(values)
        for unit, place, taken in zip(self._units, self._places, samples, strict=True):
            if taken is None:
                unit.wait(row_clock)
            elif unit.chain.steps is None:
                unit.take(taken, None, row_clock)
            else:
                unit.take(taken, measured[place].reshape(taken.values.shape), row_clock)
