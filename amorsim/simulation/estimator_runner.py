"""An estimator without the simulator: fed with times, commands and readings from anywhere."""

from __future__ import annotations

import functools
import math
from collections.abc import Iterable, Mapping
from typing import Any

import attrs
import numpy as np
import numpy.typing as npt

from amorsim.array_types import AnyArray, Array
from amorsim.contracts import Beliefs, Context, Estimate, Estimator, Frame, LazyBeliefs, Measurement
from amorsim.core.arguments import check_kind, whole
from amorsim.core.error_text import in_words
from amorsim.core.errors import AmorsimError, ComponentError, did_you_mean
from amorsim.scenario.programs.programs import loaded_robot
from amorsim.scenario.spec import Robot
from amorsim.simulation.checked_arguments import checked_seed
from amorsim.simulation.error_context import ErrorContext
from amorsim.simulation.estimation.beliefs import beliefs_of_step
from amorsim.simulation.estimation.estimating import Estimators
from amorsim.simulation.estimation.feeding import FeedingError, feeding_order
from amorsim.simulation.estimation.first_beliefs import BELIEF, first_beliefs
from amorsim.simulation.fleet.drive_check import check_drive
from amorsim.simulation.fleet.grouping import channels_of, poses_of, reading_size, robot_model
from amorsim.simulation.handle import finite_numbers
from amorsim.simulation.row_clock import RowClock
from amorsim.simulation.schedule import Call, walk
from amorsim.simulation.sensing.copied_readings import Copies
from amorsim.simulation.sensing.noise_chain import Streams
from amorsim.worlds.drawn import map_of

__all__ = ["EstimatorRunner"]


_GRID = 1e-6  # of a step: times that are as near to a multiple of it are that multiple


class EstimatorRunner:
    """Runs one estimator of one robot on times, commands and readings from anywhere, such as the log of a real robot.

    ::

        runner = am.EstimatorRunner(robot, "ekf")
        for time, command, readings in log:
            estimate = runner.update(time, readings, command)
        print(estimate.pose, runner.beliefs)

    Fed with what a simulated robot received, it gives the same bits as the simulation. Estimators of the robot whose
    estimates it takes run with it.

    Parameters
    ----------
    robot
        With its pose at the start, as it knows it: its nominal drive, sensors and knowledge are used.
    estimator
        An estimator, or the name of one of the robot's.
    dt
        The step that the robot's software knows [s]. Updates may come at any times.
    seed, replica
        Of the simulation, for an estimator that draws random numbers, and for a Gaussian initial belief, which the
        simulation draws about the robot's pose. Without a seed that pose is what the robot believes. Where replicas
        have different maps, the robot knows that of its replica.

    Attributes
    ----------
    robot
        With the estimators that run: the wanted one, and those whose estimates it takes.

    Raises
    ------
    AmorsimError
        If the robot has no pose, or no estimator of that name, or the map of its replica cannot be made; a
        `ComponentError` if the estimator refuses the robot, or the drive's answers are not of the contract's shapes.
    """

    def __init__(
        self, robot: Robot, estimator: str | Estimator, *, dt: float = 0.1, seed: int | None = None, replica: int = 0
    ) -> None:
        check_kind(robot, Robot, "robot", "a Robot, as am.load('demo').robots[0]")
        seed = None if seed is None else checked_seed(seed)
        replica = whole(replica, "replica", "the number of a replica")
        robot = loaded_robot(robot)
        if robot.pose is None:
            raise AmorsimError(f"robot {robot.name!r}: an estimator starts from a pose; give the robot one (pose=...)")
        if isinstance(estimator, str):
            if estimator not in robot.estimators:
                known = ", ".join(map(repr, robot.estimators)) or "none"
                raise AmorsimError(
                    f"robot {robot.name!r} has no estimator {estimator!r}; it has: {known}."
                    f"{did_you_mean(estimator, robot.estimators)}"
                )
            name, estimator = estimator, robot.estimators[estimator]
        else:
            if not (attrs.has(type(estimator)) and isinstance(estimator, Estimator)):
                raise AmorsimError(
                    f"robot {robot.name!r}: expected an estimator, or the name of one of its own, got "
                    f"{in_words(estimator)}"
                )
            found = [name for name, own in robot.estimators.items() if own is estimator]
            name = found[0] if found else "estimator"
        if finite_numbers((dt,)) is None or not dt > 0.0:
            raise AmorsimError(f"dt: expected a number of seconds > 0, got {in_words(dt)}")
        self._name, self._dt = name, float(dt)
        self._who = f"robot {robot.name!r}, estimator {name!r}"
        world = robot.knowledge.map
        robot = attrs.evolve(
            robot,
            estimators=_with_feeders(name, {**robot.estimators, name: estimator}, robot),
            knowledge=attrs.evolve(robot.knowledge, map=None if world is None else map_of(world, replica)),
        )
        self.robot = robot
        self._sizes = {sensor: reading_size(robot, sensor) for sensor in robot.sensors}
        self._model = robot_model([robot], self._sizes, channels_of(robot), self._dt)
        self._clock = RowClock(np.array([replica]), self._dt)
        self._streams = Streams(seed or 0, [robot.name], self._clock.counter)
        whose = ErrorContext("robot", [robot.name], self._clock)
        check_drive(self._model.drive, 1, whose)
        draws = {one: self._streams.draws("estimator", one) for one in robot.estimators}
        self._estimators = Estimators(draws, whose, self._clock)
        self._estimators.set_parameters([robot])
        pose, covariance = first_beliefs(
            [robot], poses_of([robot]), None if seed is None else self._streams.draws(*BELIEF)
        )
        self._estimators.start(
            Context(rows=1, dt=self._dt, robot=self._model, pose=pose, names=[robot.name], covariance=covariance)
        )
        self._held = {sensor: _no_reading(size) for sensor, size in self._sizes.items()}
        self._command = np.zeros((1, len(self._model.channels)))
        self._calls: list[Call] = []
        self._first: float | None = None  # [s], the time of the first update
        self._tick = -1
        self._time = 0.0  # [s] since the first
        self._taken: dict[str, tuple[Array, int, float]] = {}  # by sensor: values, and when they were measured

    def __getstate__(self) -> dict[str, Any]:
        """All but the calls, which a copy prepares again."""
        return {**vars(self), "_calls": []}

    def update(
        self,
        time: float,
        readings: Mapping[str, npt.ArrayLike],
        command: npt.ArrayLike | None = None,
        ages: Mapping[str, float] | None = None,
    ) -> Estimate:
        """The estimate, `pose` `(3,)` and `covariance` `(3, 3)`, after the readings that arrived at a time [s].

        Parameters
        ----------
        readings
            By sensor, the values of a reading that has just arrived; a sensor without a new one is left out.
        command
            The command of the step that ends now, a number for each of the robot's channels; without it, zeros.
        ages
            By sensor, how long ago [s] its reading was measured, if not now.

        Raises
        ------
        AmorsimError
            If the time is not after the one before, or a sensor, a number of values or an age is wrong; a
            `ComponentError` if the estimator fails.
        """
        ages = {} if ages is None else ages
        arrived = self._arrived(readings, ages)
        channels = self._model.channels
        wanted = self._numbers(np.zeros(len(channels)) if command is None else command, "the command", len(channels))
        # From here on the entry is right: what was refused has left no trace.
        elapsed = self._go_to(time)
        for sensor, values in arrived.items():
            age = ages.get(sensor, 0.0)
            self._taken[sensor] = values, max(self._tick - round(age / self._dt), 0), self._time - age
        for sensor in self._sizes:
            self._hold(sensor, sensor in readings)
        self._command[:], self._clock.elapsed = wanted, np.array([[elapsed]])
        if not self._calls:
            given = self._held, Copies(self._held), self._command, self._clock
            bound = self._estimators.bind(self._model, *given)
            self._calls = [Call("estimate", one, update, blame) for one, update, blame in bound]
        walk(self._calls)
        self._estimators.conclude()
        pose, covariance = self._estimators.estimates[self._name]
        return Estimate(pose[0].copy(), covariance[0].copy())

    @property
    def beliefs(self) -> Beliefs:
        """The estimator's further beliefs: arrays by name, without an axis of rows, to be looked up before an update.

        Raises
        ------
        AmorsimError
            If one is looked up after a later update.
        """
        found, tick = self._estimators.beliefs_of(self._name), self._tick

        def look_up(name: str) -> AnyArray:
            if self._tick != tick:
                raise AmorsimError(
                    f"{self._who}: {name!r} is of an earlier update; take it from beliefs before the next"
                )
            return np.asarray(found[name][0])

        return LazyBeliefs({name: functools.partial(look_up, name) for name in found})

    def frame(self) -> Frame:
        """The moment after the last update, one row as recorders take it, in copies; nan where truth would be.

        Time [s] and tick count from the first update.
        """
        nothing, drive = np.full((1, 3), np.nan), self._model.drive
        estimates = self._estimators.estimates
        return Frame(
            names=[self.robot.name],
            replica=self._clock.replica,
            tick=np.array([max(self._tick, 0)]),
            time=np.array([self._time]),
            true_pose=nothing,
            true_twist=nothing,
            joint_names=[joint.name for joint in drive.joints],
            joint_rates=np.full((1, len(drive.joints)), np.nan),
            estimates={
                name: Estimate(*(part.copy() for part in estimates[name])) for name in self._in_order(estimates)
            },
            readings={
                name: (
                    np.full_like(held.measured, np.nan),
                    Measurement(held.measured.copy(), held.stamp.copy(), held.age.copy(), held.fresh.copy()),
                )
                for name, held in self._held.items()
            },
            channels=self._model.channels,
            command=self._command.copy(),
            robot=self._model,
            beliefs=beliefs_of_step(self._estimators.believers(), lambda: self._estimators.updates),
        )

    def _in_order(self, names: Iterable[str]) -> list[str]:
        """Names of estimators, the own one first."""
        return sorted(names, key=lambda name: name != self._name)

    def _go_to(self, time: float) -> float:
        """Set the clock to a time; returns the seconds since the update before, 0 at the first."""
        if finite_numbers((time,)) is None:
            raise AmorsimError(f"{self._who}: expected a time in seconds, got {in_words(time)}")
        if self._first is None:
            self._first = float(time)
        since = float(time) - self._first
        if self._tick >= 0 and not since > self._time:
            raise AmorsimError(
                f"{self._who}: expected a time after {self._first + self._time:g} s, the one before, got {time:g} s; "
                "sort the log by time"
            )
        tick = max(round(since / self._dt), self._tick + 1)
        before, last = self._time, self._tick
        # Differences of times are rounded; whole steps are not, as in the simulation.
        whole = self._is_step(since, tick) and self._is_step(before, last)
        elapsed = 0.0 if last < 0 else (tick - last) * self._dt if whole else since - before
        self._tick, self._time = tick, since
        self._clock.set_tick(np.array([[tick]]))
        self._streams.rewind()
        return elapsed

    def _is_step(self, time: float, tick: int) -> bool:
        return math.isclose(time, tick * self._dt, rel_tol=1e-12, abs_tol=_GRID * self._dt)

    def _arrived(self, readings: Mapping[str, npt.ArrayLike], ages: Mapping[str, float]) -> dict[str, Array]:
        """The readings that have arrived, as rows, by sensor."""
        mappings: dict[str, Any] = {"readings": readings, "ages": ages}  # of callers that check no types
        for what, given in mappings.items():
            if not isinstance(given, Mapping):
                example = next(iter(self._sizes), "encoder")
                raise AmorsimError(
                    f"{self._who}: expected {what} by sensor, such as {{{example!r}: ...}}, got {in_words(given)}"
                )
            for sensor in given:
                if sensor not in self._sizes:
                    known = ", ".join(map(repr, self._sizes)) or "none"
                    raise AmorsimError(
                        f"{self._who}: the robot has no sensor {sensor!r}; it has: {known}."
                        f"{did_you_mean(sensor, self._sizes)}"
                    )
        for sensor, age in ages.items():
            if sensor not in readings:
                raise AmorsimError(f"{self._who}: an age of {sensor!r}, but no reading of it; leave the age out")
            if finite_numbers((age,)) is None or age < 0.0:
                raise AmorsimError(f"{self._who}: expected an age >= 0 s of {sensor!r}, got {in_words(age)}")
        return {
            sensor: self._numbers(values, f"a reading of {sensor!r}", self._sizes[sensor])
            for sensor, values in readings.items()
        }

    def _numbers(self, values: npt.ArrayLike, what: str, count: int) -> Array:
        """Values as a new row `(1, count)`."""
        try:
            given = np.asarray(values)
        except ValueError:  # rows of different lengths
            given = np.empty(0, dtype=object)
        if given.dtype.kind not in "fiub":
            raise AmorsimError(f"{self._who}: expected {count} numbers as {what}, got {in_words(values)}")
        if given.size != count:
            raise AmorsimError(f"{self._who}: expected {count} numbers as {what}, got {given.size}")
        return np.array(given, dtype=np.float64).reshape(1, count)

    def _hold(self, sensor: str, is_new: bool) -> None:
        """Write a sensor's last reading, as the robot holds it."""
        held = self._held[sensor]
        held.fresh[:] = is_new
        if sensor in self._taken:
            values, stamp, taken = self._taken[sensor]
            whole = (self._tick - stamp) * self._dt
            age = whole if abs(whole - (self._time - taken)) < _GRID * self._dt else self._time - taken
            held.measured[:], held.stamp[:], held.age[:] = values, stamp, age


def _no_reading(size: int) -> Measurement:
    """The reading of a robot's sensor before the first arrives."""
    return Measurement(np.full((1, size), np.nan), np.full((1, 1), -1), np.zeros((1, 1)), np.zeros((1, 1), dtype=bool))


def _with_feeders(name: str, estimators: Mapping[str, Estimator], robot: Robot) -> dict[str, Estimator]:
    """The estimator of that name, and all whose estimates it takes, directly or through others."""
    try:
        order = feeding_order(estimators)
    except FeedingError as error:
        raise ComponentError(f"robot {robot.name!r}, estimator {error.name!r}: {error}") from None
    found, waiting = {name}, [name]
    while waiting:
        more = set(order[waiting.pop()]) - found
        found |= more
        waiting += more
    return {one: estimator for one, estimator in estimators.items() if one in found}
