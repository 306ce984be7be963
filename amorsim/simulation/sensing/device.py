"""A mounted sensor over rows: when it samples, the noise chain of its values, and when they reach the robot."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any, NoReturn, Protocol

import attrs
import numpy as np
import numpy.typing as npt

from amorsim.array_types import AnyArray, Array
from amorsim.contracts import Aim, Context, Draws, Emission, Measurement, Sensor, SensorBinding, Side, State
from amorsim.core.error_text import RAISED, in_words
from amorsim.core.rows import stack
from amorsim.kernels.kinematics import poses
from amorsim.kernels.number_checks import has_nan
from amorsim.kernels.sensing import delivery
from amorsim.scenario.needs import samples_under_way
from amorsim.scenario.spec import MountedSensor
from amorsim.simulation.error_context import ErrorContext, array_problem
from amorsim.simulation.row_clock import RowClock
from amorsim.simulation.sensing.noise_chain import Chain, Streams
from amorsim.simulation.world.sensor_view import GroupView

__all__ = ["Device"]

Ticks = npt.NDArray[np.int64]
Flags = npt.NDArray[np.bool_]

_HELD = ("true", "measured", "stamp", "last", "age", "fresh")
_BOUND = ("_sense", "emit", "look")
_NO_SIDES: Mapping[str, Array] = {}


class Truth(Protocol):
    """The true state of the robots that carry the device: arrays that keep their place."""

    true_pose: Array
    true_twist: Array
    joints: Array
    joint_rates: Array


class Device:
    """One sensor of a group: its true parameters, its chain, its samples in transit and the current reading.

    All arrays keep their place until the parameters are set again. A *plain* device samples in every step, its readings
    arrive at once, and its whole chain runs as a kernel: the group applies the noise of all plain devices in one call.

    Attributes
    ----------
    sampled
        The values `(N, k)` of the latest sample, before its noise: what `sense` writes.
    true, measured
        The current reading `(N, k)`.
    stamp, last
        The tick of the reading, and of the latest sample, arrived or not `(N, 1)`; -1 before the first.
    age, fresh
        Age of the reading [s], and whether it arrived in this step `(N, 1)`.
    """

    def __init__(
        self,
        name: str,
        specified: MountedSensor,
        size: int,
        streams: Streams,
        whose: ErrorContext,
        row_clock: RowClock,
        view: GroupView,
    ) -> None:
        self.name = name
        self.size = size
        self.whose = whose
        self.view = view
        self.chain = Chain(specified.noise, streams, whose, "sensor", name, columns=tuple(specified.sensor.columns()))
        self.draws: Draws = streams.draws("sensor", name)
        self.sensor: Sensor = specified.sensor
        self.state: State = {}
        self._clock = row_clock
        self.shape = len(row_clock.replica), size
        self.mount: Array = np.zeros((self.shape[0], 3))
        self.pose: Array = np.zeros((self.shape[0], 3))
        self._rate: Array | None = None
        self._delay: Ticks = np.zeros((1, 1), dtype=np.int64)  # latency [ticks]
        self._latency: Array = np.zeros((1, 1))
        self._slots = 1  # the most samples in transit at once, plus one
        self._under_way: delivery.UnderWay | None = None
        self._sides: dict[str, Callable[[], Array]] = {}
        self._side: Mapping[str, Array] = _NO_SIDES  # of the latest sample
        self.sampled, self._ahead = np.zeros(self.shape), np.zeros(self.shape)
        self.true, self.measured = np.full(self.shape, np.nan), np.full(self.shape, np.nan)
        rows = self.shape[0]
        self.stamp: Ticks = np.full((rows, 1), -1, dtype=np.int64)
        self.last: Ticks = np.full((rows, 1), -1, dtype=np.int64)
        self.age: Array = np.zeros((rows, 1))
        self.fresh: Flags = np.zeros((rows, 1), dtype=bool)

    def __getstate__(self) -> dict[str, Any]:
        """All but what is bound, which a copy prepares again."""
        return {name: value for name, value in vars(self).items() if name not in _BOUND} | {"_sides": {}}

    def unbind(self) -> None:
        """Let go of what is bound; see `Group.unbind`."""
        self._sides.clear()
        for name in _BOUND:
            vars(self).pop(name, None)

    # ------------------------------------------------------------------------------------------------- parameters

    def set_parameters(self, true: Sequence[MountedSensor], dt: float) -> None:
        """Take the true parameters of every row, and the chains, rates and latencies."""
        self.sensor = stack([unit.sensor for unit in true])
        self.mount[:] = [[unit.mount.x, unit.mount.y, unit.mount.heading] for unit in true]
        self.chain.set_parameters([unit.noise for unit in true])
        rates = [math.inf if unit.rate is None else unit.rate for unit in true]
        self._rate = None if all(rate * dt >= 1 - delivery.TOLERANCE for rate in rates) else np.array([rates]).T
        self._latency = np.array([[unit.latency] for unit in true])
        self._slots = samples_under_way(self._latency + self.chain.longest_delay(), dt) + 1
        self._delay = np.ceil(self._latency / dt - delivery.TOLERANCE).astype(np.int64)

    @property
    def is_prompt(self) -> bool:
        """Whether it samples in every step, and every reading arrives at once."""
        return self._rate is None and self._slots == 1

    @property
    def is_plain(self) -> bool:
        """Whether the group applies its noise, with that of all other plain devices."""
        return self.is_prompt and self.chain.steps is not None

    def lay_out(self, sampled: Array, measured: Array, ahead: Array) -> None:
        """Take arrays `(N, k)` for samples, measured values, and samples of a device that nothing bends.

        The current reading moves into them.
        """
        true = ahead if self.chain.aims or not self.is_prompt else sampled
        true[:], measured[:] = self.true, self.measured
        self.sampled, self.true, self.measured = sampled, true, measured
        if not self.is_prompt:
            self._ahead = np.empty(self.shape) if self.chain.aims else sampled
            if self.stamp is self._clock.tick:
                self.stamp, self.last = self.stamp.copy(), self.last.copy()
                self.age, self.fresh = self.age.copy(), self.fresh.copy()
            return
        self._ahead = true
        self.stamp = self.last = self._clock.tick
        self.age, self.fresh = self._clock.now, self._clock.always

    def start(self, context: Context) -> None:
        """Reset to the start of an episode, before the first sample."""
        try:
            self.state = dict(self.sensor.start(context))
        except RAISED as error:
            self.whose.blame_start(self.what, self.sensor, error)
        self.chain.states = self.chain.start(context)
        self.true[:], self.measured[:] = np.nan, np.nan
        if not self.is_prompt:
            self.stamp[:], self.last[:], self.age[:], self.fresh[:] = -1, -1, 0.0, False
        self._under_way = None
        if self._slots > 1:
            slots = (context.rows, self._slots)
            self._under_way = delivery.UnderWay(
                true=np.zeros((*slots, self.size)),
                measured=np.zeros((*slots, self.size)),
                stamp=np.full(slots, -1, dtype=np.int64),
                arrival=np.zeros(slots if self.chain.delays else (context.rows, 0), dtype=np.int64),
                latest=np.zeros((context.rows, 1), dtype=np.int64),
            )

    # --------------------------------------------------------------------------------------------------- each step

    def bind(self, truth: Truth) -> Callable[[], None]:
        """The function that each step calls; that of the sensor itself if the device is plain and bends no beams."""
        clock, view = self._clock, self.view

        def look() -> GroupView:
            view.tick = clock.tick.copy()
            view.body_pose, view.twist = truth.true_pose.copy(), truth.true_twist.copy()
            view.joints, view.joint_rates = truth.joints.copy(), truth.joint_rates.copy()
            view.use(self.mount, self.name)
            return view

        view.use(self.mount, self.name)
        self.look: Callable[[], GroupView] = look  # the view, with copies of the present truth
        self._sides = {}
        at = SensorBinding(
            rows=self.shape[0],
            dt=clock.dt,
            tick=clock.tick,
            pose=self.pose,
            body_pose=truth.true_pose,
            twist=truth.true_twist,
            joints=truth.joints,
            joint_rates=truth.joint_rates,
            view=view,
            look=look,
            state=self.state,
            draws=self.draws,
            aim=None,
            sides={} if self.chain.aims else self._sides,
            out=self._ahead,
            answer=lambda values, side: self._take(self._ahead, values, side),
        )
        self._sense: Callable[[], None] = self.sensor.bind(at)
        if self.sensor.medium:
            self.emit: Callable[[], Emission | None] = self.sensor.bind_emit(at)
        if self.chain.aims:
            ahead = self._sense
            aimed = attrs.evolve(
                at,
                aim=self._aim,
                sides=self._sides,
                out=self.sampled,
                answer=lambda values, side: self._take(self.sampled, values, side),
            )
            bent = self.sensor.bind(aimed)
            self._sense = lambda: self._sense_twice(ahead, bent)
        return self._sense if self.is_plain else self._sample

    def _sense_twice(self, ahead: Callable[[], None], bent: Callable[[], None]) -> None:
        """Sense as if nothing bent the beams, which is the true reading, and as they are bent."""
        before = _Kept(self.state)
        ahead()
        self.check(self._ahead, "sense()")
        before.put_back(np.zeros_like(self._clock.always))
        self.draws.rewind()
        bent()

    def _take(self, out: Array, values: Any, side: Mapping[str, Array]) -> None:
        """Take what the sensor's `sense` returned."""
        if problem := array_problem(values, "values", self.shape, "sense()"):
            raise self.whose.wrong(self.what, self.sensor, problem)
        out[:] = values
        self._side = side

    def _aim(self) -> Aim:
        """The aim that the chain makes, of one angle and one time for each value."""
        aim: Any = self.chain.aim(self._elapsed())  # an element may return anything
        if not isinstance(aim, Aim):
            problem = f"expected an Aim from the aim() of its noise, got {in_words(aim)}"
            raise self.whose.wrong(self.what, self.sensor, problem)
        for what, array in (("bearings", aim.bearing), ("times", aim.time)):
            if array is not None and (problem := array_problem(array, what, self.shape, "the aim() of its noise")):
                raise self.whose.wrong(self.what, self.sensor, problem)
        return aim

    def due(self) -> tuple[Flags, int]:
        """The rows that sample at this tick, the first at or after each due time `(N, 1)`, and their number."""
        clock = self._clock
        if self._rate is None:
            return clock.always, len(clock.always)
        due = np.empty_like(clock.always)
        return due, delivery.due_rows(clock.tick, self._rate, clock.dt, due)

    def _elapsed(self) -> Array:
        """Time [s] since the previous sample `(N, 1)`; 0 at the first."""
        clock = self._clock
        if self._rate is None:
            return clock.elapsed
        return np.where(self.last < 0, 0.0, (clock.tick - self.last) * clock.dt)

    def _sample(self) -> None:
        """Sample the rows that are due, and deliver the readings that arrive."""
        clock = self._clock
        due, count = self.due()
        if count == 0:
            self._deliver(due, self.true, self.measured)
            return
        kept = [_Kept(state) for state in (self.state, *self.chain.states)] if count < len(due) else []
        elapsed = self._elapsed()
        self._sense()
        side = Side(**self._sides) if self._sides else self._side
        self.check(self.sampled, "sense()")
        # Of a copy: an element may write into what it is given, and the sample is the truth.
        measured = self.chain.corrupt(self.sampled.copy(), side, elapsed)
        self.check_noise(measured)
        late = self.chain.delay(elapsed) if self.chain.delays else None
        for before in kept:
            before.put_back(due)
        if self.is_prompt:
            self.measured[:] = measured
            return
        np.copyto(self.last, clock.tick, where=due)
        self._deliver(due, self._ahead, measured, late)

    def _deliver(self, due: Flags, true: Array, measured: Array, late: Array | None = None) -> None:
        """Update the robots' readings after this tick's samples; rows that are not due have no sample."""
        held = delivery.Reading(self.true, self.measured, self.stamp, self.age, self.fresh)
        tick, dt = self._clock.tick, self._clock.dt
        measured = np.ascontiguousarray(measured, dtype=np.float64)
        if self._under_way is None:
            delivery.take_due(due, tick, dt, true, measured, held, held)
        else:
            takes = self._latency if late is None else self._latency + late
            delivery.deliver(due, tick, dt, true, measured, self._delay, takes, self._under_way, held, held)

    # ------------------------------------------------------------------------------------------------------ checks

    def check_noise(self, measured: Array) -> None:
        """Raise if there is nan among what the chain made of a sample."""
        self.check(measured, f"its chain of noise ({', '.join(self.chain.names)})")

    def check(self, values: Any, by: str) -> None:
        """Raise unless values are numbers `(N, k)`; inf is valid, for beams without a return."""
        if problem := array_problem(values, "values", self.shape, by):
            raise self.whose.wrong(self.what, self.sensor, problem)
        if has_nan(values.ravel()):
            finite = np.where(np.isinf(values), 0.0, values)
            raise self.whose.not_finite(self.what, self.sensor, f"the reading from {by}", finite)

    @property
    def what(self) -> str:
        """Its role in its robots, for messages."""
        return f"sensor {self.name!r}"

    def blame(self, error: BaseException) -> NoReturn:
        """Raise the sensor's exception as `ErrorContext.blame` does."""
        self.whose.blame(self.what, self.sensor, error)

    # --------------------------------------------------------------------------------------------------- for others

    @property
    def reading(self) -> Measurement:
        """The current reading, as the robot receives it, in copies."""
        return Measurement(self.measured.copy(), self.stamp.copy(), self.age.copy(), self.fresh.copy())

    @property
    def live(self) -> Measurement:
        """The arrays of the current reading themselves, for components that are bound."""
        return Measurement(self.measured, self.stamp, self.age, self.fresh)

    def arrays(self) -> dict[str, AnyArray]:
        """The device's own arrays that change, by name, without the states of components.

        Of a prompt one, stamp, age and the like are the clock's arrays, and here copies.
        """
        found = {name: getattr(self, name) for name in _HELD}
        if self.is_prompt:
            found |= {name: found[name].copy() for name in _HELD[2:]}
        under_way = {} if self._under_way is None else self._under_way._asdict()
        return found | {f".{name}": held for name, held in under_way.items()}


def place_mounts(devices: Sequence[Device], true_pose: Array) -> Callable[[], None]:
    """A function that writes the true poses of all mounts in the world into the devices' `pose`."""
    rows = len(true_pose)
    every = np.empty((len(devices) * rows, 3))
    mounts = np.concatenate([device.mount for device in devices])
    bodies = np.empty((len(devices), rows, 3))
    flat = bodies.reshape(-1, 3)
    for i, device in enumerate(devices):
        device.pose = every[i * rows : (i + 1) * rows]

    def place() -> None:
        bodies[...] = true_pose
        poses.compose(flat, mounts, every)

    return place


class _Kept:
    """A component's state as it was before a call."""

    def __init__(self, state: State) -> None:
        self._state, self._places = state, dict(state)
        self._before = {name: array.copy() for name, array in state.items()}

    def put_back(self, which: Flags) -> None:
        """Restore the rows that are not marked in `which` `(N, 1)`, each array at its place in memory."""
        for name, before in self._before.items():
            now = self._state[name]
            marked = which.reshape(len(before), *([1] * (before.ndim - 1)))
            if now is self._places[name]:
                np.copyto(now, before, where=~marked)
            else:  # a component in the simple form may put another array there, even one that it has under two names
                self._state[name] = np.where(marked, now, before)
