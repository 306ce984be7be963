"""A mounted sensor over rows: when it reads, through what chain its values go, and when they arrive."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, NamedTuple, NoReturn

import numpy as np
import numpy.typing as npt

from amorsim.contracts import Aim, Context, Draws, Measurement, Sensor, State
from amorsim.core.rows import stack
from amorsim.core.trouble import RAISED
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


class Batch:
    """What units of one group read together last; each takes its own out of it when somebody asks.

    Attributes
    ----------
    turn
        How often it was renewed.
    shape
        Of `values`.
    values
        `(2, V * N)`, true and measured: of each unit the values of row 0 first.
    places
        Where in them each unit's are, by its name.
    is_held
        Whether this is what all of its units hold; not before they have read, nor where they were given other readings.
    """

    __slots__ = ("always", "is_held", "now", "places", "rows", "shape", "tick", "turn", "values")

    def __init__(self, rows: int, values: int) -> None:
        self.rows = rows
        self.shape = 2, rows * values
        self.turn = 0
        self.values = np.empty((2, 0))
        self.places: dict[str, slice] = {}
        self.is_held = False

    def take(self, values: Array, row_clock: RowClock) -> None:
        """Hold what is, or will be, read now."""
        self.turn += 1
        self.is_held = True
        self.values = values
        self.tick, self.now, self.always = row_clock.tick, row_clock.now, row_clock.always


class Held(NamedTuple):
    """What a unit holds: its last reading, true and as delivered, when it was taken, and when one was taken last."""

    true: Array
    measured: Array
    stamp: Ticks
    last: Ticks  # the tick of the latest sample, arrived or not
    reading: Measurement


class SensorUnit:
    """One sensor of a group: its true parameters, its chain, its samples under way and the reading that is held.

    Arrays of a reading are replaced, never changed, so whoever holds one keeps what he saw.
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
        self._rate: Array | None = None
        self._delay: Ticks = np.zeros((1, 1), dtype=np.int64)  # of the latency [ticks]
        self._latency: Array = np.zeros((1, 1))
        self._slots = 1  # samples that can be under way at once, and one
        self._late: Array = self._latency  # [s], of the latest sample beyond the latency
        self._under_way: delivery.UnderWay | None = None
        self._batch: Batch | None = None  # of the plan that reads for it, and which part of it is its own, from `first`
        self.first = self._end = self._turn = 0
        self._hold_nothing(1)

    @property
    def held(self) -> Held:
        """What it holds now."""
        batch = self._batch
        if batch is not None and batch.turn != self._turn:
            self._turn = batch.turn
            shape = (batch.rows, self.size)
            true = batch.values[0, self.first : self._end].reshape(shape)
            measured = batch.values[1, self.first : self._end].reshape(shape)
            tick = batch.tick
            self._held = Held(true, measured, tick, tick, Measurement(measured, tick, batch.now, batch.always))
        return self._held

    def _hold(self, held: Held) -> None:
        self._held = held
        if self._batch is not None:
            self._turn = self._batch.turn
            self._batch.is_held = False

    def _hold_nothing(self, rows: int) -> None:
        none, never = np.full((rows, self.size), np.nan), np.full((rows, 1), -1, dtype=np.int64)
        reading = Measurement(none, never, np.zeros((rows, 1)), np.zeros((rows, 1), dtype=bool))
        self._hold(Held(none, none, never, never, reading))

    @property
    def true(self) -> Array:
        """The true values `(N, k)` of the reading that is held."""
        return self.held.true

    @property
    def reading(self) -> Measurement:
        """The reading that is held."""
        return self.held.reading

    def join(self, batch: Batch, first: int, end: int) -> None:
        """Take, from now on, what is read for it: values first..end-1 of a batch."""
        self.leave()
        self._batch, self.first, self._end, self._turn = batch, first, end, batch.turn
        batch.places[self.name] = slice(first, end)

    def leave(self) -> None:
        """Read by itself from now on."""
        self._held = self.held
        self._batch = None

    def set_parameters(self, true: Sequence[MountedSensor], dt: float) -> None:
        """Take the true parameters of every row, and the chains, rates and latencies."""
        self.sensor = stack([unit.sensor for unit in true])
        self.mount = np.array([[unit.mount.x, unit.mount.y, unit.mount.heading] for unit in true])
        self.chain.set_parameters([unit.noise for unit in true])
        rates = [math.inf if unit.rate is None else unit.rate for unit in true]
        self._rate = None if all(rate * dt >= 1 - delivery.TOLERANCE for rate in rates) else np.array([rates]).T
        self._latency = np.array([[unit.latency] for unit in true])
        self._slots = samples_under_way(self._latency + self.chain.longest_delay(), dt) + 1
        self._delay = np.ceil(self._latency / dt - delivery.TOLERANCE).astype(np.int64)

    def start(self, context: Context) -> None:
        """Forget everything: the state at the start of an episode, before the first sample."""
        try:
            self.state = dict(self.sensor.start(context))
        except RAISED as error:
            self.blame(error)
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

    @property
    def is_prompt(self) -> bool:
        """Whether it reads in every step, and every reading arrives at once."""
        return self._rate is None and self._slots == 1

    def sample(self, view: GroupView, row_clock: RowClock) -> None:
        """Read where a reading is due, take delivery of what arrives, and hold the rest."""
        due, count = self.due(row_clock)
        held = self.held
        if count == 0:
            self._deliver(due, held.true, held.measured, held.last, row_clock)
            return
        if count == len(due):
            true, measured = self._read(view, row_clock)
            self._deliver(due, true, measured, row_clock.tick, row_clock)
            return
        kept = [{k: v.copy() for k, v in state.items()} for state in (self.state, *self.chain.states)]
        true, measured = self._read(view, row_clock)
        for state, old in zip((self.state, *self.chain.states), kept, strict=True):
            for key, before in old.items():
                state[key] = _choose(due, state[key], before)
        self._deliver(due, true, measured, np.where(due, row_clock.tick, held.last), row_clock)

    def due(self, row_clock: RowClock) -> tuple[npt.NDArray[np.bool_], int]:
        """The rows that read at this tick, the first at or after each due time `(N, 1)`, and how many they are."""
        if self._rate is None:
            return row_clock.always, len(row_clock.always)
        due = np.empty_like(row_clock.always)
        return due, delivery.due_rows(row_clock.tick, self._rate, row_clock.dt, due)

    def _read(self, view: GroupView, row_clock: RowClock) -> tuple[Array, Array]:
        if self._rate is None:
            elapsed = row_clock.elapsed
        else:
            last = self.held.last
            elapsed = np.where(last < 0, 0.0, (row_clock.tick - last) * row_clock.dt)
        view.mount, view.sensor = self.mount, self.name
        ideal = Aim()
        try:
            if self.chain.aims:
                before = {key: value.copy() for key, value in self.state.items()}
                true, _ = self.sensor.sense(view, ideal, self.state, self.draws)
                self.state.clear()
                self.state.update(before)
                self.draws.rewind()
                values, side = self.sensor.sense(view, self.chain.aim(elapsed), self.state, self.draws)
                self._check(true, "sense()")
            else:
                values, side = self.sensor.sense(view, ideal, self.state, self.draws)
                true = values
        except RAISED as error:
            self.blame(error)
        self._check(values, "sense()")
        measured = values
        if self.chain.corrupts:
            measured = self.chain.corrupt(values, side, elapsed)
            self._check(measured, f"its chain of noise ({', '.join(self.chain.names)})")
        if self.chain.delays:
            self._late = self.chain.delay(elapsed)
        return true, measured

    def _check(self, values: Any, by: str) -> None:
        """Raise what is wrong with values that were to be `(N, k)` numbers, or inf where nothing returned."""
        if problem := array_problem(values, "values", (len(self.mount), self.size), by):
            raise self.whose.wrong(self._what, self.sensor, problem)
        # The least of numbers is nan where one of them is; where one is inf it need not be.
        if values.size and values.min() != values.min():
            told = np.where(np.isinf(values), 0.0, values)
            raise self.whose.not_finite(self._what, self.sensor, f"the reading from {by}", told)

    @property
    def _what(self) -> str:
        return f"sensor {self.name!r}"

    def blame(self, error: BaseException) -> NoReturn:
        """Raise what the sensor raised, as `Whose.blame` does."""
        self.whose.blame(self._what, self.sensor, error)

    def _deliver(
        self, due: npt.NDArray[np.bool_], true: Array, measured: Array, last: Ticks, row_clock: RowClock
    ) -> None:
        """Hold what robots have after this tick's samples; rows that are not due gave none."""
        tick = row_clock.tick
        if self.is_prompt:
            self._hold(Held(true, measured, tick, last, Measurement(measured, tick, row_clock.now, row_clock.always)))
            return
        held = self.held
        before = delivery.Reading(held.true, held.measured, held.stamp, held.reading.age, held.reading.fresh)
        after = _room_for(*held.true.shape)
        true, measured = _floats(true), _floats(measured)
        if self._under_way is None:
            delivery.take_due(due, tick, row_clock.dt, true, measured, before, after)
        else:
            late = self._latency + self._late
            delivery.deliver(due, tick, row_clock.dt, true, measured, self._delay, late, self._under_way, before, after)
        reading = Measurement(after.measured, after.stamp, after.age, after.fresh)
        self._hold(Held(after.true, after.measured, after.stamp, last, reading))

    # ------------------------------------------------------------------------------------ for snapshots and resets

    def arrays(self) -> dict[str, npt.NDArray[np.generic]]:
        """The unit's own arrays, by name (the states of components are kept apart)."""
        true, measured, stamp, last, reading = self.held
        held = {"true": true, "measured": measured, "stamp": stamp, "last": last}
        under_way = {} if self._under_way is None else self._under_way._asdict()
        waiting = {f".{name}": array.copy() for name, array in under_way.items()}  # these change in place
        return {**held, "fresh": reading.fresh, "age": reading.age, **waiting}

    def set_arrays(self, arrays: dict[str, npt.NDArray[Any]]) -> None:
        """Put the arrays of `arrays` back."""
        measured, stamp = arrays["measured"], arrays["stamp"]
        reading = Measurement(measured, stamp, arrays["age"], arrays["fresh"])
        if self._under_way is not None:
            waiting = {name: arrays[f".{name}"].copy() for name in self._under_way._fields}
            self._under_way = delivery.UnderWay(**waiting)
        self._hold(Held(arrays["true"], measured, stamp, arrays["last"], reading))


def _choose(rows: npt.NDArray[np.bool_], yes: Array, no: Array) -> Array:
    """Row by row `yes` or `no`, whatever follows the first axis; the dtype of `no`."""
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
    """Values as kernels take them."""
    return np.ascontiguousarray(values, dtype=np.float64)
