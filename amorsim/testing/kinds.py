"""How sensors, noise, estimators, controllers and motions are tried."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from amorsim.array_types import Array
from amorsim.contracts import Aim, Controller, Emission, Estimate, Estimator, Motion, Noise, Sensor, State
from amorsim.core.noise_steps import steps_problem
from amorsim.scenario.reading.columns import columns_problem
from amorsim.simulation.emissions import emission_problem
from amorsim.simulation.estimation.beliefs import beliefs_problem
from amorsim.simulation.estimation.feeding import estimate_readings, feeders
from amorsim.simulation.fleet.controlling import report_problem
from amorsim.simulation.world.world import Emitted
from amorsim.testing.failure import Who, array_in_words
from amorsim.testing.rig import DT, ROWS, STEPS, Rig, Session, bent
from amorsim.testing.trial import Given, Outputs, Trial

__all__ = ["ControllerTrial", "EstimatorTrial", "MotionTrial", "NoiseTrial", "SensorTrial"]


_MOST_ROWS = 512
_VIEW = ("tick", "pose", "body_pose", "twist", "joints", "joint_rates")


def _watch(given: Given, where: str, things: Any, names: Any) -> None:
    for name in names:
        given.add(f"{where}.{name}", getattr(things, name))


class SensorTrial(Trial[Sensor]):
    """Senses in the rig's world, every other time with its beams bent."""

    def __init__(self, who: Who, rig: Rig, component: Sensor, kin: list[Sensor]) -> None:
        super().__init__(who, rig)
        unit = component.unit
        who.require(isinstance(unit, str) and unit, "unit", "unit", "the unit of its values, as in 'm'", repr(unit))
        self._check_channels(component)
        sizes = []
        for one in kin:
            with who.calling("size"):
                sizes.append(one.size(rig.specified))
        first = sizes[0]
        who.require(isinstance(first, int) and first > 0, "size", "size()", "a whole number > 0", repr(first))
        wanted = f"{first}, as only static parameters may change it"
        who.require(set(sizes) == {first}, "size", "size() with other numbers", wanted, sorted(set(sizes)))
        for one in kin:
            if problem := columns_problem(one, first):
                who.fail("columns", problem.replace(", got ", ", found ", 1))
        said = [dict(one.columns()) for one in kin]
        same = all(list(columns.items()) == list(said[0].items()) for columns in said)
        wanted = "the same, as only static parameters may change them"
        who.require(same, "columns", "columns() with other numbers", wanted, "others")
        self.size = first
        self.widths = (first,) if first <= _MOST_ROWS else ()

    def _check_channels(self, component: Sensor) -> None:
        channels: Any = component.channels
        fits = isinstance(channels, tuple) and all(isinstance(name, str) and name for name in channels)
        fits = fits and len(set(channels)) == len(channels)
        self.who.require(fits, "channels", "channels", "a tuple of texts that differ", repr(channels))
        follows = not channels or type(component).actuate is not Sensor.actuate
        self.who.require(follows, "channels", "actuate()", f"it to follow commands of {channels}", "no such method")

    def step(self, component: Sensor, session: Session, state: State, carried: Outputs, given: Given) -> Outputs:
        """One reading."""
        view, rows = session.view, len(session.rows)
        aim = Aim()
        if session.t % 2:
            aim = bent(session, self.size)
            given.add("aim.bearing", aim.bearing)
            given.add("aim.time", aim.time)
        _watch(given, "view", view, _VIEW)
        if component.channels and session.t:
            command = np.sin(session.index[:, None] + np.arange(len(component.channels)) + 0.5 * session.t)
            given.add("command", command)
            with self.who.calling("actuate"):
                component.actuate(command, DT, state, session.draws)
        fired = self.fire(component, session, state) if component.medium else {}
        with self.who.calling("sense"):
            found = component.sense(view, aim, state, session.draws)
        pair = isinstance(found, tuple) and len(found) == 2 and isinstance(found[1], Mapping)
        self.who.require(pair, "shapes", "sense()", "values and a mapping of side arrays", type(found).__name__)
        values, side = found
        width = getattr(values, "shape", (0, 0))[-1]
        self.who.require(width == self.size, "size", "sense()", f"{self.size} values a row, as size() says", f"{width}")
        outputs = {"values": self.array(values, (rows, self.size), "sense()"), **fired}
        self.who.require(not np.isnan(values).any(), "finite", "sense()", "numbers, inf for no return", "nan")
        for name, array in side.items():
            outputs[f"side {name}"] = self.array(array, (rows, self.size), f"side[{name!r}]")
            self.who.require(not np.isnan(array).any(), "finite", f"side[{name!r}]", "numbers", "nan")
        with self.who.calling("bearings"):
            bearings = component.bearings()
        if bearings is not None:
            wanted = (rows if len(bearings) > 1 else 1, self.size)
            outputs["bearings"] = np.broadcast_to(self.array(bearings, wanted, "bearings()"), (rows, self.size))
        return outputs

    def fire(self, component: Sensor, session: Session, state: State) -> Outputs:
        """The sensor's emission, added to the rig's world, in which nothing else emits."""
        rows, require = len(session.rows), self.who.require
        with self.who.calling("emit"):
            found = component.emit(session.view, state)
        require(found is not None, "emit", "emit() with a medium", "an Emission", "nothing")
        with self.who.calling("emit"):
            said = Emission(*found)  # type: ignore[misc]
        if problem := emission_problem(said, rows):
            self.who.fail("emit", problem.replace(", got ", ", found "))
        count = said.half_angle.shape[1]
        time = np.zeros((rows, count)) if said.time is None else said.time
        outputs: Outputs = {"emitters": said.poses, "half angles": said.half_angle, "times": time}
        session.view.sensor = ""
        world = session.view._world
        bodies = np.repeat(world.first[:-1, None], count, axis=1)
        sensor = np.full(count, "")
        world.emissions = {
            component.medium: Emitted(said.poses, said.half_angle, said.fired, time, bodies, sensor),
        }
        return outputs


class NoiseTrial(Trial[Noise]):
    """Corrupts values that grow from step to step, some of them inf, or readings of a sensor of the rig."""

    def __init__(self, who: Who, rig: Rig, side: Mapping[str, float], sensor: str | None, inf: str) -> None:
        super().__init__(who, rig)
        random = np.random.default_rng(2)
        if sensor is None:
            values = random.uniform(0.2, 2.0, (STEPS, ROWS, 5)).cumsum(axis=0)
            values *= np.where(random.uniform(size=(1, ROWS, 5)) < 0.3, -1.0, 1.0)
        else:
            values = rig.readings[sensor][:STEPS].copy()
        if inf != "absent":
            values[random.uniform(size=values.shape) < 0.1] = np.inf
        self.values = values
        self.side = dict(side)
        self.keeps_inf = inf == "kept"
        self.size = values.shape[2]
        self.widths = (self.size,) if self.size <= _MOST_ROWS else ()

    def step(self, component: Noise, session: Session, state: State, carried: Outputs, given: Given) -> Outputs:
        """One sample, aimed and corrupted."""
        rows = len(session.rows)
        elapsed = session.elapsed() * (1.0 + session.index[:, None] % 3)
        given.add("elapsed", elapsed)
        outputs: Outputs = {}
        if type(component).aim is not Noise.aim:
            bend = 0.01 * np.cos(session.index[:, None] + np.arange(self.size))
            when = -0.001 * np.abs(bend)
            aim = Aim(bearing=bend, time=when) if session.t % 2 else Aim()
            given.add("aim.bearing", aim.bearing)
            given.add("aim.time", aim.time)
            with self.who.calling("aim"):
                aimed = component.aim(aim, elapsed, state, session.draws)
            self.who.require(isinstance(aimed, Aim), "shapes", "aim()", "an Aim", type(aimed).__name__)
            if aimed.bearing is not None:
                outputs["bearing"] = self.array(aimed.bearing, (rows, self.size), "aim().bearing")
                finite = np.isfinite(aimed.bearing).all()
                self.who.require(finite, "finite", "aim().bearing", "finite angles", "nan or inf")
            if aimed.time is not None:
                outputs["time"] = self.array(aimed.time, (rows, self.size), "aim().time")
                wrong = aimed.time[~(np.isfinite(aimed.time) & (aimed.time <= 0.0))]
                self.who.require(
                    not wrong.size, "time", "aim().time", "times [s] of at most 0, before the tick", wrong[:3]
                )
            for what, before, after in (("bearing", aim.bearing, aimed.bearing), ("time", aim.time, aimed.time)):
                if before is not None:
                    self.who.require(
                        after is not None, "aim", f"aim().{what}", "what it was given, added to", "nothing"
                    )
        if type(component).delay is not Noise.delay:
            with self.who.calling("delay"):
                late, longest = component.delay(elapsed, state, session.draws), component.longest_delay()
            outputs["delay"] = self.array(late, (rows, 1), "delay()")
            fits = np.shape(longest) in ((rows, 1), (1, 1)) and np.isfinite(longest).all()
            self.who.require(fits, "shapes", "longest_delay()", f"finite numbers ({rows}, 1)", np.shape(longest))
            beyond = late[~(np.isfinite(late) & (late <= longest))]
            self.who.require(not beyond.size, "delay", "delay()", "at most longest_delay()", beyond[:3])
        with self.who.calling("steps"):
            steps = component.steps()
        if problem := steps_problem(steps, rows):
            self.who.fail("steps", problem.replace(", got ", ", found "))
        if type(component).corrupt is not Noise.corrupt or type(component).steps is not Noise.steps:
            values = self.values[session.t][session.index]
            side = {name: np.full(values.shape, value) for name, value in self.side.items()}
            given.add("values", values)
            for name, array in side.items():
                given.add(f"side[{name!r}]", array)
            with self.who.calling("corrupt"):
                corrupted = component.corrupt(values, side, elapsed, state, session.draws)
            outputs["values"] = self.array(corrupted, values.shape, "corrupt()")
            self.who.require(not np.isnan(corrupted).any(), "finite", "corrupt()", "numbers", "nan")
            if self.keeps_inf:
                # inf where nothing returned, -inf where something is nearer than a laser's shortest range.
                changed = np.isinf(values) & (corrupted != values)
                self.who.require(
                    not changed.any(),
                    "inf",
                    "corrupt() where nothing returned",
                    "inf" if (values[changed] > 0.0).all() else "what it was given",
                    corrupted[changed][:3],
                )
        if type(component).slide is not Noise.slide:
            motion = 0.1 * np.sin(session.index[:, None] + np.arange(3.0) + session.t)
            given.add("motion", motion)
            with self.who.calling("slide"):
                slid = component.slide(motion, elapsed, state, session.draws)
            outputs["slide"] = self.array(slid, (rows, 3), "slide()")
            self.who.require(np.isfinite(slid).all(), "finite", "slide()", "finite numbers", "nan or inf")
        return outputs


def _beliefs_of(
    trial: EstimatorTrial | ControllerTrial, component: Estimator | Controller, session: Session, state: State
) -> Outputs:
    """A component's further beliefs, looked up twice: the state stays as it is, and so do names and shapes."""
    who = trial.who
    before = {name: array.copy() for name, array in state.items()}
    with who.calling("beliefs"):
        found = component.beliefs(state)
    problem = beliefs_problem(found, len(session.rows))
    who.require(not problem, "beliefs", "beliefs()", "arrays by name, a row first", problem)
    for name, array in before.items():
        now = state.get(name)
        same = now is not None and now.tobytes() == array.tobytes()
        who.require(same, "beliefs", f"state[{name!r}] after beliefs()", "the same bits as before", "others")
    who.require(len(state) == len(before), "beliefs", "the state after beliefs()", "no new key", list(state))
    layout = [(name, array.shape[1:], array.dtype) for name, array in found.items()]
    trial.layout = trial.layout or layout
    same = layout == trial.layout
    who.require(same, "beliefs", "names and shapes in a later step", trial.layout, layout)
    return {f"belief {name}": np.asarray(array) for name, array in found.items()}


class EstimatorTrial(Trial[Estimator]):
    """Estimates from the readings of the rig's sensors, with the knowledge of the rig's robots."""

    widths = (3,)

    def __init__(self, who: Who, rig: Rig, component: Estimator) -> None:
        super().__init__(who, rig)
        self.layout: list[Any] | None = None  # names, shapes and dtypes of the beliefs
        with who.calling("sources"):
            sources = list(component.sources())
        for source in sources:
            fits = isinstance(source, tuple) and len(source) == 3 and all(isinstance(text, str) for text in source)
            who.require(fits, "sources", "sources()", "triples of texts: source, what it says, trust", repr(source))

    def step(self, component: Estimator, session: Session, state: State, carried: Outputs, given: Given) -> Outputs:
        """One update."""
        rows = len(session.rows)
        readings = session.measurements()
        names, always = feeders(component), np.ones((rows, 1), dtype=bool)
        estimates = dict.fromkeys(names, session.estimate())
        readings |= estimate_readings(names, estimates, session.clock().tick, always)
        for name, reading in readings.items():
            _watch(given, f"readings[{name!r}]", reading, reading._fields)
        command = session.rig.commands[session.t][session.index]
        elapsed = session.elapsed()
        given.add("command", command)
        given.add("elapsed", elapsed)
        given.add("robot.landmarks", session.robot.landmarks)
        with self.who.calling("update"):
            found = component.update(session.robot, readings, command, elapsed, state, session.draws)
        is_estimate = isinstance(found, Estimate)
        self.who.require(is_estimate, "shapes", "update()", "an Estimate", type(found).__name__)
        pose = self.array(found[0], (rows, 3), "the estimated pose")
        covariance = self.array(found[1], (rows, 3, 3), "the covariance")
        self.who.require(np.isfinite(pose).all(), "finite", "the estimated pose", "finite numbers", "nan or inf")
        self._check_covariance(covariance)
        outputs = {"pose": pose, "covariance": covariance}
        with self.who.calling("failed"):
            failed = component.failed(state)
        outputs |= self._verdict("failed", failed, (rows,))
        with self.who.calling("is_current"):
            current = component.is_current(readings, state)
        outputs |= self._verdict("is_current", current, (rows, 1))
        return {**outputs, **_beliefs_of(self, component, session, state)}

    def _verdict(self, name: str, found: Any, shape: tuple[int, ...]) -> Outputs:
        """What a method tells of each row, which it may leave open."""
        if found is None:
            return {}
        fits = isinstance(found, np.ndarray) and found.dtype == bool and found.shape == shape
        self.who.require(fits, name, f"{name}()", f"None or bool {shape}", array_in_words(found))
        return {name: found.copy()}  # it may be an array of the state

    def _check_covariance(self, covariance: Array) -> None:
        require = self.who.require
        require(np.isfinite(covariance).all(), "covariance", "the covariance", "finite numbers", "nan or inf")
        size = np.abs(covariance).max(axis=(1, 2), keepdims=True)
        skew = np.abs(covariance - np.swapaxes(covariance, 1, 2))
        worst = float(skew.max())
        fine = (skew <= 1e-9 * size).all()
        require(fine, "covariance", "the covariance", "a symmetric matrix", f"a skew of {worst:g}")
        least = np.linalg.eigvalsh(0.5 * (covariance + np.swapaxes(covariance, 1, 2)))[:, 0]
        fine = (least >= -1e-9 * size[:, 0, 0]).all()
        require(fine, "covariance", "the covariance", "no negative eigenvalue", f"{float(least.min()):g}")


class ControllerTrial(Trial[Controller]):
    """Commands from what the rig's sensors read and an estimate near the truth."""

    def __init__(self, who: Who, rig: Rig) -> None:
        super().__init__(who, rig)
        self.channels = len(rig.specified.channels)
        self.layout: list[Any] | None = None  # names, shapes and dtypes of the beliefs
        self.widths = (self.channels,)

    def step(self, component: Controller, session: Session, state: State, carried: Outputs, given: Given) -> Outputs:
        """One command."""
        readings, estimate, clock = session.measurements(), session.estimate(), session.clock()
        for name, reading in readings.items():
            _watch(given, f"readings[{name!r}]", reading, reading._fields)
        _watch(given, "estimate", estimate, estimate._fields)
        _watch(given, "clock", clock, ("tick", "time"))
        with self.who.calling("command"):
            found = component.command(session.robot, readings, estimate, clock, state, session.draws)
        command = self.array(found, (len(session.rows), self.channels), "command()")
        self.who.require(np.isfinite(command).all(), "finite", "command()", "finite numbers", "nan or inf")
        with self.who.calling("reports"):
            reports = list(component.reports(state))
        for report in reports:
            problem = report_problem(report, len(session.rows))
            self.who.require(not problem, "reports", "reports()", "triples of row, word and value", problem)
        return {"command": command, **_beliefs_of(self, component, session, state)}


class MotionTrial(Trial[Motion]):
    """Proposes displacements in the rig's world."""

    widths = (3,)
    is_robot = False

    def step(self, component: Motion, session: Session, state: State, carried: Outputs, given: Given) -> Outputs:
        """One proposal."""
        view = session.view
        view.use(np.zeros((len(session.rows), 3)))
        _watch(given, "view", view, _VIEW)
        with self.who.calling("propose"):
            found = component.propose(view, DT, state, session.draws)
        wanted = self.array(found, (len(session.rows), 3), "propose()")
        self.who.require(np.isfinite(wanted).all(), "finite", "propose()", "finite numbers", "nan or inf")
        return {"displacement": wanted}
