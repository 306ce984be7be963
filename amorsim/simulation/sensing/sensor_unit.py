"""A mounted sensor over rows: when it reads, the noise chain of its values, and when they arrive."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple, NoReturn

import numpy as np
import numpy.typing as npt

from amorsim.contracts import Aim, Context, Draws, Measurement, Sensor, State
from amorsim.core.rows import stack
from amorsim.core.trouble import RAISED, in_words
from amorsim.kernels.sensing import delivery
from amorsim.scenario.needs import samples_under_way
from amorsim.scenario.spec import MountedSensor
from amorsim.simulation.blame import Whose, array_problem
from amorsim.simulation.row_clock import RowClock
from amorsim.simulation.sensing.noise_chain import Chain, Streams
from amorsim.simulation.world.sensor_view import GroupView

__all__ = ["SensorUnit"]

Array = npt.NDArray[np.float64]
Ticks = npt.NDArray[np.int64]

_AHEAD = Aim()
_NOTHING_KEPT: list[State] = []
_HELD = ("true", "measured", "stamp", "last", "age", "fresh")


class Sample(NamedTuple):
    """A device's sample at a tick, before its noise."""

    due: npt.NDArray[np.bool_]  # (N, 1) the rows that it is a sample of
    true: Array  # (N, k)
    values: Array  # (N, k): the input of the chain; differs from `true` if an element changes the aim
    side: Mapping[str, Any]
    elapsed: Array  # (N, 1) [s] since the previous sample
    last: Ticks  # (N, 1): the tick of each row's latest sample
    kept: list[State]  # the states before, if not all rows are due


class SensorUnit:
    """One sensor of a group: its true parameters, its chain, its samples in transit and the current reading.

    Arrays of a reading are replaced, never changed, so a reading stays valid for code that holds it.
    """

    def __init__(self, name: str, specified: MountedSensor, size: int, streams: Streams, whose: Whose) -> None:
        self.name = name
        self.size = size
        self.whose = whose
        self.chain = Chain(specified.noise, streams, whose, "sensor", name, columns=tuple(specified.sensor.columns()))
        self.draws: Draws = streams.draws("sensor", name)
        self.sensor: Sensor = specified.sensor
        self.state: State = {}
        self.mount: Array = np.zeros((1, 3))
        self.shape = 1, size
        self._is_prompt = False
        self._rate: Array | None = None
        self._delay: Ticks = np.zeros((1, 1), dtype=np.int64)  # latency [ticks]
        self._latency: Array = np.zeros((1, 1))
        self._slots = 1  # the most samples in transit at once, plus one
        self._late: Array = self._latency  # [s], of the latest sample beyond the latency
        self._under_way: delivery.UnderWay | None = None
        self._hold_nothing(1)

    def _hold_nothing(self, rows: int) -> None:
        none, never = np.full((rows, self.size), np.nan), np.full((rows, 1), -1, dtype=np.int64)
        self._hold(none, none, never, never, np.zeros((rows, 1)), np.zeros((rows, 1), dtype=bool))

    def _hold(
        self, true: Array, measured: Array, stamp: Ticks, last: Ticks, age: Array, fresh: npt.NDArray[np.bool_]
    ) -> None:
        """Hold a reading: true and delivered values, its tick, and the tick of the latest sample, arrived or not."""
        self.true, self.measured, self.stamp, self.last = true, measured, stamp, last
        self.age, self.fresh = age, fresh

    @property
    def reading(self) -> Measurement:
        """The current reading, as the robot receives it: a copy, as its software may write into it."""
        return Measurement(self.measured.copy(), self.stamp, self.age, self.fresh)

    def set_parameters(self, true: Sequence[MountedSensor], dt: float) -> None:
        """Take the true parameters of every row, and the chains, rates and latencies."""
        self.sensor = stack([unit.sensor for unit in true])
        self.mount = np.array([[unit.mount.x, unit.mount.y, unit.mount.heading] for unit in true])
        self.shape = len(true), self.size
        self.chain.set_parameters([unit.noise for unit in true])
        rates = [math.inf if unit.rate is None else unit.rate for unit in true]
        self._rate = None if all(rate * dt >= 1 - delivery.TOLERANCE for rate in rates) else np.array([rates]).T
        self._latency = np.array([[unit.latency] for unit in true])
        self._slots = samples_under_way(self._latency + self.chain.longest_delay(), dt) + 1
        # Whether it reads in every step, and every reading arrives at once.
        self._is_prompt = self._rate is None and self._slots == 1
        self._delay = np.ceil(self._latency / dt - delivery.TOLERANCE).astype(np.int64)

    def start(self, context: Context) -> None:
        """Reset to the start of an episode, before the first sample."""
        try:
            self.state = dict(self.sensor.start(context))
        except RAISED as error:
            self.whose.blame_start(self._what, self.sensor, error)
        self.chain.states = self.chain.start(context)
        rows = context.rows
        self._hold_nothing(rows)
        self._under_way = None
        if self._slots > 1:
            slots = (rows, self._slots)
            self._under_way = delivery.UnderWay(
                true=np.zeros((*slots, self.size)),
                measured=np.zeros((*slots, self.size)),
                stamp=np.full(slots, -1, dtype=np.int64),
                arrival=np.zeros(slots if self.chain.delays else (rows, 0), dtype=np.int64),
                latest=np.zeros((rows, 1), dtype=np.int64),
            )

    def due(self, row_clock: RowClock) -> tuple[npt.NDArray[np.bool_], int]:
        """The rows that read at this tick, the first at or after each due time `(N, 1)`, and their number."""
        if self._rate is None:
            return row_clock.always, len(row_clock.always)
        due = np.empty_like(row_clock.always)
        return due, delivery.due_rows(row_clock.tick, self._rate, row_clock.dt, due)

    def look(self, view: GroupView, row_clock: RowClock) -> Sample | None:
        """Sense, if any row is due."""
        due, kept, last, elapsed = row_clock.always, _NOTHING_KEPT, row_clock.tick, row_clock.elapsed
        if self._rate is not None:
            due, count = self.due(row_clock)
            if count == 0:
                return None
            elapsed = np.where(self.last < 0, 0.0, (row_clock.tick - self.last) * row_clock.dt)
            if count < len(due):
                kept = [{k: v.copy() for k, v in state.items()} for state in (self.state, *self.chain.states)]
                last = np.where(due, row_clock.tick, self.last)
        view.use(self.mount, self.name)
        try:
            if self.chain.aims:
                before = {key: value.copy() for key, value in self.state.items()}
                true, _ = self.sensor.sense(view, _AHEAD, self.state, self.draws)
                self.state.clear()
                self.state.update(before)
                self.draws.rewind()
                aim = self._aimed(elapsed)
                values, side = self.sensor.sense(view, aim, self.state, self.draws)
                self.check(true, "sense()")
            else:
                values, side = self.sensor.sense(view, _AHEAD, self.state, self.draws)
                true = values
        except RAISED as error:
            self.blame(error)
        if problem := array_problem(values, "values", self.shape, "sense()"):
            raise self.whose.wrong(self._what, self.sensor, problem)
        return Sample(due, true, values, side, elapsed, last, kept)

    def _aimed(self, elapsed: Array) -> Aim:
        """The aim that the chain makes, of one angle and one time for each value."""
        aim: Any = self.chain.aim(elapsed)  # an element may return anything
        if not isinstance(aim, Aim):
            problem = f"expected an Aim from the aim() of its noise, got {in_words(aim)}"
            raise self.whose.wrong(self._what, self.sensor, problem)
        for what, array in (("bearings", aim.bearing), ("times", aim.time)):
            if array is not None and (problem := array_problem(array, what, self.shape, "the aim() of its noise")):
                raise self.whose.wrong(self._what, self.sensor, problem)
        return aim

    def corrupted(self, sample: Sample) -> Array:
        """The values of a sample after the chain."""
        self.check(sample.values, "sense()")
        # Of a copy: an element may write into what it is given, and the sample is the truth.
        measured = self.chain.corrupt(sample.values.copy(), sample.side, sample.elapsed)
        self.check_noise(measured)
        return measured

    def check_noise(self, measured: Array) -> None:
        """Raise if there is nan among what the chain made of a sample."""
        self.check(measured, f"its chain of noise ({', '.join(self.chain.names)})")

    def take(self, sample: Sample, measured: Array, row_clock: RowClock) -> None:
        """Send a sample, with its noisy values, on its way to the robot."""
        if self.chain.delays:
            self._late = self.chain.delay(sample.elapsed)
        if sample.kept:
            for state, old in zip((self.state, *self.chain.states), sample.kept, strict=True):
                for key, before in old.items():
                    state[key] = _choose(sample.due, state[key], before)
        if self._is_prompt:
            self._hold(sample.true, measured, sample.last, sample.last, row_clock.now, row_clock.always)
        else:
            self._deliver(sample.due, sample.true, measured, sample.last, row_clock)

    def check(self, values: Any, by: str) -> None:
        """Raise unless values are numbers `(N, k)`; inf is valid, for beams without a return."""
        if problem := array_problem(values, "values", self.shape, by):
            raise self.whose.wrong(self._what, self.sensor, problem)
        if np.isnan(values).any():
            finite = np.where(np.isinf(values), 0.0, values)
            raise self.whose.not_finite(self._what, self.sensor, f"the reading from {by}", finite)

    @property
    def _what(self) -> str:
        return f"sensor {self.name!r}"

    def blame(self, error: BaseException) -> NoReturn:
        """Raise the sensor's exception as `Whose.blame` does."""
        self.whose.blame(self._what, self.sensor, error)

    def _deliver(
        self, due: npt.NDArray[np.bool_], true: Array, measured: Array, last: Ticks, row_clock: RowClock
    ) -> None:
        """Update the robots' readings after this tick's samples; rows that are not due have no sample."""
        tick = row_clock.tick
        before = delivery.Reading(self.true, self.measured, self.stamp, self.age, self.fresh)
        after = _room_for(*self.true.shape)
        true, measured = _floats(true), _floats(measured)
        if self._under_way is None:
            delivery.take_due(due, tick, row_clock.dt, true, measured, before, after)
        else:
            late = self._latency + self._late
            delivery.deliver(due, tick, row_clock.dt, true, measured, self._delay, late, self._under_way, before, after)
        self._hold(after.true, after.measured, after.stamp, last, after.age, after.fresh)

    def wait(self, row_clock: RowClock) -> None:
        """Deliver the readings that arrive at a tick at which no row is due."""
        self._deliver(np.zeros_like(row_clock.always), self.true, self.measured, self.last, row_clock)

    # ------------------------------------------------------------------------------------ for snapshots and resets

    def arrays(self) -> dict[str, npt.NDArray[np.generic]]:
        """The unit's own arrays, by name, without the states of components."""
        under_way = {} if self._under_way is None else self._under_way._asdict()
        waiting = {f".{name}": array.copy() for name, array in under_way.items()}  # these change in place
        return {name: getattr(self, name) for name in _HELD} | waiting

    def set_arrays(self, arrays: dict[str, npt.NDArray[Any]]) -> None:
        """Put the arrays of `arrays` back."""
        if self._under_way is not None:
            waiting = {name: arrays[f".{name}"].copy() for name in self._under_way._fields}
            self._under_way = delivery.UnderWay(**waiting)
        self._hold(**{name: arrays[name] for name in _HELD})


def _choose(rows: npt.NDArray[np.bool_], yes: Array, no: Array) -> Array:
    """Row by row `yes` or `no`, for any further axes; the dtype of `no`."""
    return np.where(rows.reshape(len(no), *([1] * (no.ndim - 1))), yes, no)


def _room_for(rows: int, values: int) -> delivery.Reading:
    return delivery.Reading(
        np.empty((rows, values)),
        np.empty((rows, values)),
        np.empty((rows, 1), dtype=np.int64),
        np.empty((rows, 1)),
        np.empty((rows, 1), dtype=np.bool_),
    )


def _floats(values: npt.NDArray[Any]) -> Array:
    """Values as an array for kernels."""
    return np.ascontiguousarray(values, dtype=np.float64)
