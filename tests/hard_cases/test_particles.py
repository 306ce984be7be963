"""Monte Carlo localisation: an estimator whose state is a cloud, with draws of its own."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import attrs
import numpy as np
import numpy.typing as npt

from amorsim.contracts import Context, Draws, Estimate, Estimator, Measurement, RobotModel, State, parameter
from amorsim.core.poses import compose, wrap_angle
from amorsim.simulation.simulation import Simulation
from tests.hard_cases.common import advance, check_bits
from tests.hard_cases.localisation import expected_ranges, lost_robots, needs_map, position_errors

Array = npt.NDArray[np.float64]


@attrs.frozen(kw_only=True)
class Particles(Estimator):
    """Particles `(N, P, 4)`: x, y, heading, weight; spread at the first update, for `start` has no draws."""

    encoder: str = parameter("encoder", help="name of the sensor that counts the joints")
    laser: str = parameter("laser", help="name of the range sensor")
    count: int = parameter(150, ge=2, static=True, help="particles of a cloud")
    beams: int = parameter(9, ge=1, static=True, help="beams that are used of a scan")
    start_std: float = parameter(0.3, unit="m", ge=0, help="standard deviation of the nominal position")
    start_heading_std: float = parameter(0.05, unit="rad", ge=0, help="standard deviation of the nominal heading")
    range_std: float = parameter(0.15, unit="m", gt=0, help="standard deviation of a range, as the cloud is thin")
    way_std: float = parameter(0.2, unit="", ge=0, help="standard deviation of a step's way, per way")
    turn_std: float = parameter(0.3, unit="rad/m", ge=0, help="standard deviation of a step's turn, per way")

    def start(self, context: Context) -> State:
        needs_map(self, context)
        cloud = np.empty((context.rows, self.count, 4))
        cloud[:, :, :3] = context.pose[:, None, :]
        cloud[:, :, 3] = 1.0 / self.count
        return {"cloud": cloud, "joints": np.full((context.rows, len(context.robot.drive.joints)), np.nan)}

    def update(
        self,
        robot: RobotModel,
        readings: Mapping[str, Measurement],
        command: Array,
        elapsed: Array,
        state: State,
        draws: Draws,
    ) -> Estimate:
        rows, count = robot.rows, self.count
        noise = draws.normal(3 * count).reshape(rows, count, 3)
        encoder: Any = robot.sensors[self.encoder].sensor
        after = encoder.angles(readings[self.encoder].measured)
        before = np.where(np.isnan(state["joints"]), after, state["joints"])
        moved = robot.drive.displacement(before, after, np.ones((rows, 1)))
        way = np.sqrt(moved[:, :1] ** 2 + moved[:, 1:2] ** 2)
        first = elapsed <= 0.0
        std = np.where(
            first,
            np.concatenate((self.start_std, self.start_std, self.start_heading_std), axis=1),
            np.concatenate((way * self.way_std, way * 0.0, way * self.turn_std), axis=1),
        )
        steps = moved[:, None, :] + noise * std[:, None, :]
        cloud = state["cloud"].copy()
        poses = compose(cloud[:, :, :3].reshape(-1, 3), steps.reshape(-1, 3)).reshape(rows, count, 3)
        weights = cloud[:, :, 3] * self._likelihood(robot, readings[self.laser], poses)
        weights /= weights.sum(axis=1, keepdims=True)
        kept = self._resampled(weights, draws.uniform(1))
        cloud[:, :, :3] = np.take_along_axis(poses, kept[:, :, None], axis=1)
        cloud[:, :, 3] = 1.0 / count
        state["cloud"], state["joints"] = cloud, after
        return _moments(poses, weights)

    def _likelihood(self, robot: RobotModel, reading: Measurement, poses: Array) -> Array:
        which = np.linspace(0, robot.sensors[self.laser].size - 1, self.beams).astype(np.int64)
        expected = expected_ranges(robot, self.laser, poses, which)
        squares = np.zeros(poses.shape[:2])
        for i, beam in enumerate(which):
            seen = reading.measured[:, beam : beam + 1]
            both = np.isfinite(seen) & np.isfinite(expected[:, :, i])
            with np.errstate(invalid="ignore"):
                off = (seen - expected[:, :, i]) / self.range_std
            squares += np.minimum(np.where(both, off * off, 4.0), 9.0)  # no beam can kill a particle alone
        return np.exp(-0.5 * (squares - squares.min(axis=1, keepdims=True)))

    def _resampled(self, weights: Array, offset: Array) -> npt.NDArray[np.int64]:
        """Systematic resampling: which particle each new one is a copy of, `(N, P)`."""
        marks = (offset + np.arange(self.count)) / self.count
        sums = np.cumsum(weights, axis=1)
        return np.minimum((sums[:, None, :] < marks[:, :, None]).sum(axis=2), self.count - 1)


def _moments(poses: Array, weights: Array) -> Estimate:
    x, y = (weights * poses[:, :, 0]).sum(axis=1), (weights * poses[:, :, 1]).sum(axis=1)
    heading = np.arctan2((weights * np.sin(poses[:, :, 2])).sum(axis=1), (weights * np.cos(poses[:, :, 2])).sum(axis=1))
    mean = np.stack((x, y, heading), axis=1)
    off = poses - mean[:, None, :]
    off[:, :, 2] = wrap_angle(off[:, :, 2])
    covariance = np.empty((len(poses), 3, 3))
    for i in range(3):
        for j in range(i + 1):
            covariance[:, i, j] = covariance[:, j, i] = (weights * off[:, :, i] * off[:, :, j]).sum(axis=1)
    return Estimate(pose=mean, covariance=covariance)


def test_cloud_gathers_about_the_truth_from_a_wrong_start() -> None:
    sim = Simulation(lost_robots({"cloud": Particles()}, offset=0.35))
    frame = sim.frames()[0]
    # It knows the nominal start; before the first motion the cloud is as wide as configured, or narrower.
    first = np.sqrt(frame.estimates["cloud"].covariance[:, 0, 0])
    assert (first < 0.5).all()
    assert (position_errors(frame.true_pose, frame.estimates["odometry"].pose) > 0.45).all()
    advance(sim, 80)
    assert not sim.events
    frame = sim.frames()[0]
    cloud, odometry = frame.estimates["cloud"], frame.estimates["odometry"]
    assert (position_errors(frame.true_pose, cloud.pose) < 0.12).all()
    assert (position_errors(frame.true_pose, odometry.pose) > 0.4).all()
    assert (np.sqrt(cloud.covariance[:, 0, 0]) < first).all()


def test_bits() -> None:
    check_bits(lost_robots({"cloud": Particles(count=60)}, offset=0.2), steps=12)
