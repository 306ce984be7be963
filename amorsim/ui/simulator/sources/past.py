"""The past that plots need besides poses: the values of a robot's frames, in few numbers and bounded memory."""

from __future__ import annotations

import base64
import copy
from collections.abc import Iterable, Sequence

import numpy as np

from amorsim.array_types import Array, Ints
from amorsim.simulation.simulation import Simulation
from amorsim.ui.simulator.frames.frames import Before, selected_of, upper_triangle
from amorsim.ui.simulator.frames.packing import Selected
from amorsim.ui.simulator.frames.protocol import Past

__all__ = ["Pasts", "Places", "past_of"]


FEW = 8  # up to this many robots have their past kept, watched or not
MOST = 6000  # moments of a robot; when it is full, every other of the older half goes
FIRST = 8  # values of a sensor that are plotted, if no table gives the length of its lines


class Pasts:
    """The past of robots, each from when it was first looked at, or from the start where there are few."""

    def __init__(self, simulation: Simulation) -> None:
        self._robots: dict[int, _Robot] = {}
        self._few = range(len(simulation.names)) if len(simulation.names) <= FEW else ()

    def of_whom(self, watched: Sequence[int]) -> tuple[int, ...]:
        """The robots whose past is kept, given those that are selected."""
        return tuple(sorted({*self._few, *watched}))

    def keep(self, simulation: Simulation, watched: Sequence[int], before: Before | None) -> None:
        """Keep the present moment, after those that are kept."""
        robots = self.of_whom(watched)
        true, estimated = simulation.true_pose, simulation.estimated_pose
        covariance = upper_triangle(simulation.covariance)
        for robot, selected in selected_of(simulation, robots, before).items():
            if robot not in self._robots:
                self._robots[robot] = _Robot(_places(simulation, robot))
            poses = np.concatenate((true[robot], estimated[robot], covariance[robot]))
            self._robots[robot].keep(simulation.tick, poses, selected)

    def cut(self, tick: int) -> None:
        """Forget what came after `tick`."""
        for one in self._robots.values():
            one.cut(tick)

    def copy(self) -> Pasts:
        """Another with the same moments."""
        return copy.deepcopy(self)

    def of(self, robot: int, most: int) -> Past:
        """The kept moments of a robot, at most `most`, including the last."""
        if robot not in self._robots:
            return {"ticks": [], "values": ""}
        ticks, values = self._robots[robot].moments(most)
        return past_of(ticks.tolist(), values)


def past_of(ticks: list[int], lines: Array) -> Past:
    """Moments as a window reads them; `lines` are those of `Places.line`."""
    return {"ticks": ticks, "values": base64.b64encode(lines.astype("<f8").tobytes()).decode()}


class Places:
    """The indices of a robot's plotted values, for each sensor's number of values and columns."""

    def __init__(self, sensors: Iterable[tuple[int, int]]) -> None:
        first: list[int] = []
        starts: list[int] = []
        begin = 0
        for size, columns in sensors:
            first += range(begin, begin + min(size, columns or FIRST))
            starts += [begin] if size else []
            begin += size
        self._first = np.array(first, dtype=np.int64)
        self._starts = np.array(starts, dtype=np.int64)

    def line(self, poses: Array, selected: Selected) -> Array:
        """The numbers of a moment (see `Past`); `poses` are the true and the estimated pose, and the covariance."""
        return np.concatenate(
            (
                poses,
                selected.true_twist,
                selected.estimated_twist,
                selected.true_rates,
                selected.measured_rates,
                *(values[self._first] for values in (selected.true, selected.measured)),
                *(self._nearest(values) for values in (selected.true, selected.measured)),
            )
        )

    def _nearest(self, values: Array) -> Array:
        return np.fmin.reduceat(values, self._starts) if len(self._starts) else np.empty(0)


class _Robot:
    """The moments of one robot: ticks, and a row of numbers for each (see `Past`)."""

    def __init__(self, places: Places) -> None:
        self._places = places
        self._ticks = np.empty(256, dtype=np.int64)
        self._values = np.empty((256, 0))
        self._count = 0

    def keep(self, tick: int, poses: Array, selected: Selected) -> None:
        self.cut(tick - 1)
        line = self._places.line(poses, selected)
        if self._count == 0:
            self._values = np.empty((len(self._ticks), len(line)))
        elif self._count == MOST:
            self._thin()
        elif self._count == len(self._ticks):
            room = min(MOST, 2 * self._count)
            self._ticks.resize(room, refcheck=False)
            self._values = np.concatenate((self._values, np.empty((room - self._count, len(line)))))
        self._ticks[self._count], self._values[self._count] = tick, line
        self._count += 1

    def _thin(self) -> None:
        stay = np.concatenate((np.arange(0, MOST // 2, 2), np.arange(MOST // 2, MOST)))
        self._count = len(stay)
        self._ticks[: self._count], self._values[: self._count] = self._ticks[stay], self._values[stay]

    def cut(self, tick: int) -> None:
        self._count = int(np.searchsorted(self._ticks[: self._count], tick, side="right"))

    def moments(self, most: int) -> tuple[Ints, Array]:
        every = max(1, -(-self._count // max(most, 2)))
        places = np.arange(self._count - 1, -1, -every)[::-1]
        return self._ticks[places], self._values[places]


def _places(simulation: Simulation, robot: int) -> Places:
    """The indices of a robot's plotted values."""
    name = simulation.names[robot]
    frame = next(frame for frame in simulation.frames() if name in frame.names)
    return Places(
        (true.shape[1], len(frame.robot.sensors[sensor].sensor.columns()))
        for sensor, (true, _) in frame.readings.items()
    )
