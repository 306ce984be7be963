"""Kalman filters of a pose: wheels predict; landmarks, satellites, a compass and a gyro correct.

What the extended and the unscented filter have in common: all but the transform of a Gaussian.
"""

from __future__ import annotations

import abc
import functools
import math
import statistics
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any

import attrs
import numpy as np

from amorsim.array_types import AnyArray, Array, Bools
from amorsim.contracts import (
    Beliefs,
    Context,
    Draws,
    Estimate,
    Estimator,
    EstimatorBinding,
    Measurement,
    RobotModel,
    State,
    parameter,
)
from amorsim.contracts.estimator import update_bound
from amorsim.core.errors import ComponentError
from amorsim.core.execution.workers import in_turn
from amorsim.estimators.ages import bind_fresh
from amorsim.estimators.initial_beliefs import covariance_at_start, refuse_lost
from amorsim.estimators.kalman_sources import SOURCES, check_sources, noise_in_words
from amorsim.estimators.wheels import Counted, bind_readings, bind_step, check_encoder
from amorsim.kernels.filters import compatible, ekf, landmarks, unscented
from amorsim.kernels.filters.updates import MATCH, NIS, RECORD, USED, Gaussians
from amorsim.kernels.kinematics import odometry

__all__ = ["KalmanFilter"]


_FAR = 1e12  # [m, rad, rad/s]: no robot gets so far; larger numbers are exploding
_WAYS = {"identity": landmarks.BY_IDENTITY, "nearest": landmarks.NEAREST_FIRST, "joint": landmarks.JOINTLY}


@functools.cache
def _thresholds(probability: float) -> tuple[float, float]:
    """Quantiles of the chi-squared distributions with one and with two degrees of freedom."""
    if probability >= 1.0:
        return np.inf, np.inf
    one = statistics.NormalDist().inv_cdf(0.5 + 0.5 * probability)
    return one * one, -2.0 * math.log1p(-probability)


@functools.cache
def _joint_thresholds(probability: float, pairs: int) -> tuple[float, ...]:
    """Quantiles of the chi-squared distributions with 0, 2, 4 ... degrees of freedom, for up to that many pairs."""
    return (np.inf, *(_even_quantile(probability, count) for count in range(1, pairs + 1)))


def _even_quantile(probability: float, pairs: int) -> float:
    """The quantile with an even number of degrees of freedom: beyond 2 y are exp(-y) times y**i / i! summed up."""
    if probability >= 1.0:
        return np.inf
    low, high = 0.0, 1.0

    def beyond(y: float) -> float:
        return math.fsum(math.exp(i * math.log(y) - y - math.lgamma(i + 1)) for i in range(pairs))

    while beyond(high) > 1.0 - probability:
        high *= 2.0
    for _ in range(100):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if beyond(middle) > 1.0 - probability else (low, middle)
    return low + high


@attrs.frozen(kw_only=True)
class KalmanFilter(Estimator):
    """Predicts with the nominal drive and corrects with what other sensors measure; subclasses define how.

    Their `transform` gives how expected measurements depend on the state: by slopes or by points.
    """

    prediction: str = parameter(
        "encoder", choices=("encoder", "command"), static=True, help="what moves the pose: encoder or command"
    )
    encoder: str = parameter("encoder", refers="sensors", help="name of the sensor that counts the joints")
    wheel_variance: float = parameter(
        unit="m", ge=0, help="variance of a rolling joint's travel [m^2] per metre of it, as the robot believes"
    )
    landmarks: str = parameter("", refers="sensors", help="name of the sensor of landmarks; empty for none")
    range_std: float | None = parameter(None, unit="m", gt=0, help="standard deviation of a landmark's range")
    bearing_std: float | None = parameter(None, unit="rad", gt=0, help="standard deviation of a landmark's bearing")
    association: str = parameter("identity", choices=tuple(_WAYS), static=True, help="which landmark a sighting is of")
    gps: str = parameter("", refers="sensors", help="name of the sensor of places; empty for none")
    gps_std: float | None = parameter(None, unit="m", gt=0, help="standard deviation of each coordinate")
    gps_correlation: float = parameter(0.0, gt=-1, lt=1, help="correlation of the errors of the two coordinates")
    compass: str = parameter("", refers="sensors", help="name of the sensor of the heading; empty for none")
    compass_std: float | None = parameter(None, unit="rad", gt=0, help="standard deviation of the measured heading")
    gyro: str = parameter("", refers="sensors", help="name of the sensor of the rate of turn; empty for none")
    gyro_std: float | None = parameter(None, unit="rad/s", gt=0, help="standard deviation of the rate of turn")
    gyro_bias_std: float | None = parameter(None, unit="rad/s", ge=0, help="standard deviation of its bias at first")
    gyro_bias_walk: float = parameter(0.0, unit="rad/s", ge=0, help="standard deviation of its bias's change in 1 s")
    start_std: float = parameter(0.0, unit="m", ge=0, help="standard deviation of each coordinate of the start")
    start_heading_std: float = parameter(0.0, unit="rad", ge=0, help="standard deviation of the heading at the start")
    gate: float = parameter(0.999, gt=0, le=1, static=True, help="probability with which a good correction passes")
    age_max: float = parameter(0.0, unit="s", ge=0, help="age at which a reading still counts as taken now")

    on_failure: str = parameter(
        "continue", choices=("continue", "end"), static=True, help="what it does when its numbers explode"
    )

    @property
    def who(self) -> str:
        """Its name in messages."""
        return type(self).__name__.lower()

    @abc.abstractmethod
    def transform(self) -> unscented.Transform:
        """The transform from the state to the expected measurement."""

    def sources(self) -> Sequence[tuple[str, str, str]]:
        """The sources that predict and correct each part of the state, with the noise that is assumed."""
        by = "commands" if self.prediction == "command" else f"sensor {self.encoder!r}"
        found = [(by, "predicts x, y, heading", f"{self.wheel_variance:g} m² of travel per m")]
        for source in SOURCES:
            if name := getattr(self, source.field):
                found.append((f"sensor {name!r}", f"corrects {source.corrects}", noise_in_words(self, source)))
        if len(found) == 1:
            found.append(("no sensor", "corrects", "name one: " + ", ".join(source.field for source in SOURCES)))
        else:
            passes = f"{100.0 * self.gate:g} % of good readings" if self.gate < 1.0 else "everything"
            found.append(("gates", "pass", passes))
        return found

    def start(self, context: Context) -> State:
        """State: mean and covariance of x, y, heading and bias, the joints, and room for what updates compare.

        Raises
        ------
        ComponentError
            If a sensor is missing or of another kind, its noise is not stated, or the robot knows no landmarks, or
            nothing of its start.
        """
        robot, rows = context.robot, context.rows
        if self.prediction == "encoder":
            check_encoder(self.who, robot, self.encoder)
            rate = robot.sensors[self.encoder].rate
            if rate is not None and rate * context.dt < 1.0 - 1e-9:
                raise ComponentError(
                    f"{self.who} predicts with the sensor {self.encoder!r} in every step of {context.dt:g} s, but it "
                    f"reads at {rate:g} Hz; give it no rate, or set prediction = 'command'"
                )
        slots = check_sources(self, robot)
        refuse_lost(self.who, context)
        covariance = np.zeros((rows, 4, 4))
        covariance[:, :3, :3] = covariance_at_start(context)
        spread: Any = self.start_std, self.start_std, self.start_heading_std, self.gyro_bias_std
        for i, std in enumerate(spread):
            covariance[:, i, i] += 0.0 if std is None else np.broadcast_to(std, (rows, 1))[:, 0] ** 2
        joints = len(robot.drive.joints)
        state = {
            "mean": np.concatenate((context.pose, np.zeros((rows, 1))), axis=1),
            "covariance": covariance,
            "joints": np.full((rows, joints), np.nan),
            "failed": np.zeros(rows, dtype=bool),
        }
        state |= {f"{field}_updates": np.full((rows, size, RECORD), np.nan) for field, size in slots.items()}
        if self.prediction == "encoder":
            state["taken"] = np.zeros((rows, 1), dtype=bool)
            state["current"] = np.ones((rows, 1), dtype=bool)
        if self.prediction == "command":
            state["joints"] = np.zeros((rows, joints))
            state["rates"] = np.zeros((rows, joints))
            state |= {f"drive {name}": array for name, array in robot.drive.start(context).items()}
        return state

    def update(
        self,
        robot: RobotModel,
        readings: Mapping[str, Measurement],
        command: Array,
        elapsed: Array,
        state: State,
        draws: Draws,
    ) -> Estimate:
        """The estimate after predicting this step's motion and correcting by all readings that arrived in it."""
        bind = functools.partial(KalmanFilter.bind, self)
        return update_bound(bind, robot, readings, command, elapsed, state, draws)

    def bind(self, at: EstimatorBinding) -> Callable[[], None]:
        """Predict and correct on the engine's own arrays."""
        robot, state = at.robot, at.state
        belief = Gaussians(state["mean"], state["covariance"])
        kept = Gaussians(np.empty_like(belief.mean), np.empty_like(belief.covariance))
        before, after, counted, read, follow = self._bind_joints(at)
        step, move = bind_step(robot.drive, before, after)
        none, noise, pose = np.zeros((robot.rows, 3, 3)), np.empty((robot.rows, 3, 3)), np.empty((robot.rows, 3))
        variance: Any = self.wheel_variance
        carry_on = functools.partial(odometry.reckon, belief.mean, none, *step, variance, pose, noise)
        walk = np.array(np.broadcast_to(self.gyro_bias_walk**2, (robot.rows, 1)))
        growth, transform, room = np.empty((robot.rows, 1)), self.transform(), unscented.work()
        predict = functools.partial(ekf.predict, belief, pose, noise, growth, transform, room)
        by_arcs, stays, failed = bool(self.landmarks), self.on_failure == "end", state["failed"]

        def begin() -> None:
            np.copyto(kept.mean, belief.mean)
            np.copyto(kept.covariance, belief.covariance)
            np.multiply(walk, at.elapsed(), out=growth)

        def end() -> None:
            ekf.keep_valid(belief, kept, _FAR, stays, failed)
            ekf.report(belief, by_arcs, at.out.pose, at.out.covariance)

        corrections = self._bind_corrections(at, belief, step.twist[:, 2:], counted, noise, room)
        return in_turn([read, move, begin, carry_on, *follow, predict, *corrections, end])

    def _bind_joints(
        self, at: EstimatorBinding
    ) -> tuple[Array, Array, Counted, Callable[[], None], list[Callable[[], None]]]:
        """The joints before and after the step, as measured or as the nominal drive would have moved them.

        Also the rows whose wheels count, a function that finds all of these, and those that follow the motion.
        """
        robot, state, joints = at.robot, at.state, at.state["joints"]
        if self.prediction == "encoder":
            counted = Counted(state["taken"], state["current"], np.empty((robot.rows, 1), dtype=bool))
            reading = at.readings[self.encoder]
            check = bind_fresh(self.who, robot, self.encoder, reading, self.age_max)
            before, after, take = bind_readings(robot, self.encoder, reading, joints, counted)
            return before, after, counted, in_turn([check, take]), []
        every = np.ones((robot.rows, 1), dtype=bool)
        before, after = np.empty_like(joints), np.empty_like(joints)
        drive, rates = robot.drive, state["rates"]
        own = {name.removeprefix("drive "): array for name, array in state.items() if name.startswith("drive ")}

        def advance() -> None:
            np.copyto(before, joints)
            np.copyto(after, joints)
            if at.elapsed().any():  # or else it is the start
                wanted = np.ascontiguousarray(at.command[:, : len(drive.channels)])
                after[:], rates[:] = drive.advance(before, rates, wanted, robot.dt, own, at.draws)
                for name, array in own.items():
                    np.copyto(state[f"drive {name}"], array)

        def follow() -> None:
            joints[:] = drive.follow(after, drive.displacement(before, after, np.ones((robot.rows, 1))))

        return before, after, Counted(every, every, every), advance, [follow]

    def failed(self, state: State) -> Bools:
        """Rows whose numbers exploded in the last update: a mean or covariance that is not finite or not positive."""
        return state["failed"]

    def _bind_corrections(
        self, at: EstimatorBinding, belief: Gaussians, turn: Array, counted: Counted, noise: Array, room: unscented.Work
    ) -> Iterator[Callable[[], None]]:
        """Functions that correct by each sensor.

        The gyro is first, because its error is correlated with that of the prediction. It must be of the step in which
        the wheels turned; a place or heading that is measured where the mean is not current is of another pose.
        """
        robot, transform = at.robot, self.transform()
        one, two = _thresholds(self.gate)
        if self.gyro:
            values, fresh, _, records, take = self._bind_reading("gyro", at, counted.follows)
            turned, elapsed, variance = np.empty((robot.rows, 1)), np.empty((robot.rows, 1)), _squared(self.gyro_std)

            def measure() -> None:
                np.copyto(turned, turn)
                np.copyto(elapsed, at.elapsed())

            yield take
            yield measure
            yield functools.partial(
                ekf.fuse_turns, belief, values, fresh, turned, noise, elapsed, variance, one, room, records
            )
        if self.compass:
            values, fresh, mounts, records, take = self._bind_reading("compass", at, counted.current)
            yield take
            yield functools.partial(
                ekf.fuse_headings, belief, values, fresh, mounts, _squared(self.compass_std), one, room, records
            )
        if self.gps:
            values, fresh, mounts, records, take = self._bind_reading("gps", at, counted.current)
            variance, correlation = _squared(self.gps_std), np.asarray(self.gps_correlation)
            yield take
            yield functools.partial(
                ekf.fuse_places, belief, values, fresh, mounts, variance, correlation, two, transform, room, records
            )
        if self.landmarks:
            values, fresh, mounts, records, take = self._bind_reading("landmarks", at, counted.current)
            places, ids = robot.landmarks, robot.landmark_ids
            assert places is not None
            assert ids is not None
            both = np.concatenate((_squared(self.range_std), _squared(self.bearing_std)), axis=1)
            slots = records.shape[1]
            gates = (
                np.array(_joint_thresholds(self.gate, slots)) if self.association == "joint" else np.zeros(slots + 1)
            )
            search = compatible.search(slots, len(places), gates)
            marks, way = landmarks.Marks(places, ids), _WAYS[self.association]
            yield take
            yield functools.partial(
                landmarks.fuse_landmarks,
                *(belief, values, fresh, mounts, marks, both, two, way, transform, room, search, records),
            )

    def _bind_reading(
        self, field: str, at: EstimatorBinding, allowed: Bools
    ) -> tuple[Array, Bools, Array, Array, Callable[[], None]]:
        """A sensor's values, which rows of them are new and `allowed`, its mounts `(N, 3)`, and a record to fill.

        Also the function that looks which rows these are, and empties the record.
        """
        name, rows = getattr(self, field), at.robot.rows
        reading, mount = at.readings[name], at.robot.sensors[name].mount
        check = bind_fresh(self.who, at.robot, name, reading, self.age_max)
        sides: Any = mount.x, mount.y, mount.heading
        mounts = np.concatenate([np.broadcast_to(side, (rows, 1)) for side in sides], axis=1)
        fresh, records = np.empty((rows, 1), dtype=bool), at.state[f"{field}_updates"]

        def take() -> None:
            check()
            np.logical_and(reading.fresh, allowed, out=fresh)
            records.fill(np.nan)

        return reading.measured, fresh, mounts, records, take

    def beliefs(self, state: State) -> Beliefs:
        """For each sensor, by its field: ``innovation``, its covariance, ``nis``, and ``used``, 1 or 0; nan if none.

        Landmarks have them for each slot of the reading, and ``landmarks_match``, the landmark's place among those that
        the robot knows. With a gyro, ``gyro_bias`` [rad/s] and ``gyro_bias_variance``.
        """
        found: dict[str, AnyArray] = {}
        for source in SOURCES:
            if not getattr(self, source.field):
                continue
            records, field = state[f"{source.field}_updates"], source.field
            if source.numbers == 2:
                innovation, covariance = records[..., :2], records[..., [2, 3, 3, 4]]
                covariance = covariance.reshape(*covariance.shape[:-1], 2, 2)
            else:
                innovation, covariance = records[..., :1], records[..., 2:3, None]
            parts = {
                "innovation": innovation,
                "innovation_covariance": covariance,
                "nis": records[..., NIS],
                "used": records[..., USED],
            }
            if field == "landmarks":
                parts["match"] = records[..., MATCH]
            else:
                parts = {name: array[:, 0] for name, array in parts.items()}
            found |= {f"{field}_{name}": array.copy() for name, array in parts.items()}
        if self.gyro:
            found["gyro_bias"] = state["mean"][:, 3].copy()
            found["gyro_bias_variance"] = state["covariance"][:, 3, 3].copy()
        return found


def _squared(std: Any) -> Array:
    """Variances `(N, 1)` of standard deviations that were stated."""
    return np.asarray(std) ** 2
