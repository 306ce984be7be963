"""Checks that a component that binds itself computes what its simple form does, and writes nothing else."""

from __future__ import annotations

import abc
import functools
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from amorsim.array_types import AnyArray, Array
from amorsim.contracts import (
    Aim,
    Context,
    Controller,
    ControllerBinding,
    Drive,
    DriveBinding,
    Emission,
    Estimate,
    Estimator,
    EstimatorBinding,
    Measurement,
    Sensor,
    SensorBinding,
    State,
)
from amorsim.core.rows import stack
from amorsim.kernels.kinematics import poses
from amorsim.simulation.estimation.feeding import estimate_readings, feeders
from amorsim.testing.failure import Who
from amorsim.testing.rig import DT, ROWS, STEPS, Rig, Session, bent

__all__ = ["check_bound"]

Arrays = dict[str, AnyArray]


Fire = Callable[[Any, Session, State], object]


def check_bound(who: Who, rig: Rig, components: Sequence[Any], size: int = 0, fire: Fire | None = None) -> None:
    """Compare a component's own `bind` with its simple form, over all rows of the rig and all steps.

    A component that is bound by the base class of its kind passes. `size` is that of a sample, for the context; `fire`
    adds what a sensor emits to the rig's world.
    """
    component = stack(components)
    for base, form in _FORMS:
        if isinstance(component, base) and getattr(type(component), form.binds) is not getattr(base, form.binds):
            _compare(who, form(rig, component, size, fire), form(rig, component, size, fire))


def _compare(who: Who, simple: _Form, bound: _Form) -> None:
    for t in range(STEPS):
        simple.go_to(t)
        bound.go_to(t)
        if t == 0:
            with who.calling(bound.binds):
                run = bound.bind()
        with who.calling(simple.name):
            expected = simple.call()
        before = {name: array.copy() for name, array in bound.given.items()}
        bound.out.fill(np.nan)
        with who.calling(f"what {bound.binds}() returned"):
            run()
        for name, array in bound.given.items():
            if array.tobytes() != before[name].tobytes():
                who.fail("bind", f"{name}: expected an array of the engine to be left alone, found it changed")
        _require_same(who, f"what {bound.binds}() wrote in step {t}", expected, bound.out)
        for name, array in simple.state.items():
            if array.dtype != object:
                _require_same(who, f"state[{name!r}] after step {t}", array, bound.state[name])


def _require_same(who: Who, what: str, expected: AnyArray, found: AnyArray) -> None:
    if expected.tobytes() != found.tobytes():
        rows = np.flatnonzero((np.asarray(expected) != np.asarray(found)).reshape(len(expected), -1).any(axis=1))
        who.fail("bind", f"{what}: expected the bits of the simple form, found others, in {len(rows)} of its rows")


class _Form(abc.ABC):
    """One of the two forms of a component, stepped in the rig: the simple one is called, the other is bound once."""

    name = ""
    binds = "bind"

    def __init__(self, rig: Rig, component: Any, size: int, fire: Fire | None) -> None:
        self.rig, self.component, self.size, self.fire = rig, component, size, fire
        self.session = Session(rig, np.arange(ROWS, dtype=np.int64))
        self.session.go_to(0)
        context: Context = self.session.context(size)
        self.state: State = dict(component.start(context))
        self.given: Arrays = {}
        self.out: AnyArray = np.zeros(0)
        self.prepare()

    @abc.abstractmethod
    def prepare(self) -> None:
        """Make the arrays that keep their place."""

    def go_to(self, t: int) -> None:
        """Write the inputs of step `t` into the arrays that the component was bound to."""
        self.session.go_to(t)
        if self.fire is not None:
            self.fire(self.component, self.session, self.state)
        for name, array in self.now().items():
            self.given.setdefault(name, np.array(array))[...] = array

    @abc.abstractmethod
    def now(self) -> Mapping[str, AnyArray]:
        """The inputs of this step, by name."""

    @abc.abstractmethod
    def call(self) -> AnyArray:
        """The result of the simple form."""

    @abc.abstractmethod
    def bind(self) -> Callable[[], None]:
        """The bound function."""


class _Sensor(_Form):
    """A reading, and what else the chain may need, side by side in the order of their names."""

    name = "sense"

    def prepare(self) -> None:
        self._pose = np.zeros((ROWS, 3))

    def now(self) -> Mapping[str, AnyArray]:
        view = self.session.view
        poses.compose(view.body_pose, view.mount, self._pose)
        names = ("tick", "body_pose", "twist", "joints", "joint_rates")
        return {"pose": self._pose, **{name: getattr(view, name) for name in names}}

    aim: Callable[[], Aim] | None = None

    def call(self) -> AnyArray:
        aim = Aim() if self.aim is None else self.aim()
        values, side = self.component.sense(self.session.view, aim, self.state, self.session.draws)
        return np.concatenate((values, *(side[name] for name in sorted(side))), axis=1)

    def bind(self) -> Callable[[], None]:
        at = self.binding()
        sense = self.component.bind(at)

        def run() -> None:
            at.out.fill(np.nan)  # all of it is to be written
            sense()
            self.out = np.concatenate((at.out, *(at.sides[name]() for name in sorted(at.sides))), axis=1)

        return run

    def binding(self) -> SensorBinding:
        """What the component is bound to."""
        out = np.zeros((ROWS, self.size))
        sides: dict[str, Callable[[], Array]] = {}

        def answer(values: Any, side: Mapping[str, Array]) -> None:
            out[...] = values
            sides.update({name: functools.partial(side.__getitem__, name) for name in side})

        given: Any = self.given
        view = self.session.view
        return SensorBinding(
            rows=ROWS, dt=DT, view=view, look=lambda: view, state=self.state, draws=self.session.draws,
            aim=self.aim, sides=sides, out=out, answer=answer, **given,
        )  # fmt: skip


class _BentSensor(_Sensor):
    """A sensor whose beams are bent, and now and then look at different times; see `bent`."""

    def prepare(self) -> None:
        super().prepare()
        self.aim = lambda: bent(self.session, self.size)


class _Emitter(_Sensor):
    """What a sensor emits: poses, half angles, whether each emitter fires, and when, side by side."""

    name = "emit"
    binds = "bind_emit"

    def call(self) -> AnyArray:
        return _beside(self.component.emit(self.session.view, self.state))

    def bind(self) -> Callable[[], None]:
        emit = self.component.bind_emit(self.binding())

        def run() -> None:
            self.out = _beside(emit())

        return run


def _beside(emission: Emission) -> Array:
    """All arrays of an emission in one `(N, 6 e)`."""
    times = np.zeros(emission.fired.shape) if emission.time is None else emission.time
    poses = emission.poses.reshape(len(times), -1)
    return np.concatenate((poses, emission.half_angle, emission.fired, times), axis=1)


class _Drive(_Form):
    name = "advance"

    def prepare(self) -> None:
        shape = ROWS, len(self.component.joints)
        random = np.random.default_rng(4)
        self._joints = random.uniform(-3.0, 3.0, (STEPS, *shape))
        self._rates = random.uniform(-6.0, 6.0, (STEPS, *shape))
        self._commands = random.uniform(-6.0, 6.0, (STEPS, ROWS, len(self.component.channels)))
        self.out = np.zeros((2, *shape))

    def now(self) -> Mapping[str, AnyArray]:
        t = self.session.t
        return {"joints": self._joints[t], "joint_rates": self._rates[t], "command": self._commands[t]}

    def call(self) -> AnyArray:
        given = [array.copy() for array in self.given.values()]
        return np.array(self.component.advance(*given, DT, self.state, self.session.draws))

    def bind(self) -> Callable[[], None]:
        def answer(joints: Array, rates: Array) -> None:
            self.out[0], self.out[1] = joints, rates

        given: Any = self.given
        to = DriveBinding(
            rows=ROWS, dt=DT, state=self.state, draws=self.session.draws, out=self.out, answer=answer, **given
        )
        bound: Callable[[], None] = self.component.bind(to)
        return bound


class _Software(_Form):
    """A component that sees readings."""

    def now(self) -> Mapping[str, AnyArray]:
        found: Arrays = {}
        for name, reading in self._readings().items():
            found |= {f"readings[{name!r}].{field}": getattr(reading, field) for field in reading._fields}
        return found

    def _readings(self) -> dict[str, Measurement]:
        return self.session.measurements()

    def _live(self) -> dict[str, Measurement]:
        fields = Measurement._fields
        return {
            name: Measurement(*(self.given[f"readings[{name!r}].{f}"] for f in fields)) for name in self._readings()
        }


class _Estimator(_Software):
    name = "update"

    def prepare(self) -> None:
        self._pose, self._covariance = np.zeros((ROWS, 3)), np.zeros((ROWS, 3, 3))

    def now(self) -> Mapping[str, AnyArray]:
        command = self.rig.commands[self.session.t][self.session.index]
        return {**super().now(), "command": command, "elapsed": self.session.elapsed()}

    def _readings(self) -> dict[str, Measurement]:
        names, always = feeders(self.component), np.ones((ROWS, 1), dtype=bool)
        estimates = dict.fromkeys(names, self.session.estimate())
        return super()._readings() | estimate_readings(names, estimates, self.session.clock().tick, always)

    def call(self) -> AnyArray:
        command, elapsed = self.given["command"].copy(), self.given["elapsed"].copy()
        given = self.session.robot, self._readings(), command, elapsed, self.state
        pose, covariance = self.component.update(*given, self.session.draws)
        return np.concatenate((pose, covariance.reshape(ROWS, 9)), axis=1)

    def bind(self) -> Callable[[], None]:
        out = Estimate(self._pose, self._covariance)

        def answer(estimate: Estimate) -> None:
            out.pose[:], out.covariance[:] = estimate

        inner: Callable[[], None] = self.component.bind(
            EstimatorBinding(
                robot=self.session.robot,
                readings=self._live(),
                copied_readings=self._readings,
                command=self.given["command"],
                elapsed=lambda: self.given["elapsed"],
                state=self.state,
                draws=self.session.draws,
                out=out,
                answer=answer,
            )
        )
        self.out = np.zeros((ROWS, 12))

        def run() -> None:
            inner()
            self.out[...] = np.concatenate((out.pose, out.covariance.reshape(ROWS, 9)), axis=1)

        return run


class _Controller(_Software):
    name = "command"

    def prepare(self) -> None:
        self.out = np.zeros((ROWS, len(self.session.robot.channels)))

    def now(self) -> Mapping[str, AnyArray]:
        estimate, clock = self.session.estimate(), self.session.clock()
        own = {"pose": estimate.pose, "covariance": estimate.covariance, "tick": clock.tick, "time": clock.time}
        return {**super().now(), **own}

    def call(self) -> AnyArray:
        given = self.session.robot, self._readings(), self.session.estimate(), self.session.clock(), self.state
        command = self.component.command(*given, self.session.draws)
        return np.asarray(command)

    def bind(self) -> Callable[[], None]:
        def answer(command: Any) -> None:
            self.out[...] = command

        bound: Callable[[], None] = self.component.bind(
            ControllerBinding(
                robot=self.session.robot,
                readings=self._live(),
                copied_readings=self._live(),
                estimate=Estimate(self.given["pose"], self.given["covariance"]),
                tick=self.given["tick"],
                time=self.given["time"],
                dt=DT,
                state=self.state,
                draws=self.session.draws,
                out=self.out,
                answer=answer,
            )
        )
        return bound


_FORMS: Sequence[tuple[type, Any]] = (
    (Sensor, _Sensor),
    (Sensor, _BentSensor),
    (Sensor, _Emitter),
    (Drive, _Drive),
    (Estimator, _Estimator),
    (Controller, _Controller),
)
