"""An extended Kalman filter that compares laser ranges with the map that the robot knows."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import attrs
import numpy as np
import numpy.typing as npt
import pytest

from amorsim.contracts import Context, Draws, Estimate, Estimator, Measurement, RobotModel, State, parameter
from amorsim.core.errors import ComponentError
from amorsim.core.poses import compose, relative, wrap_angle
from amorsim.scenario.knowledge import Knowledge
from amorsim.simulation.simulation import Simulation
from tests.hard_cases.common import advance, check_bits
from tests.hard_cases.localisation import expected_ranges, lost_robots, needs_map, position_errors

Array = npt.NDArray[np.float64]

_NUDGE = np.array([0.01, 0.01, 0.005])  # [m, m, rad] half the width of the differences that stand for slopes


@attrs.frozen(kw_only=True)
class MapEkf(Estimator):
    """Odometry predicts, and each of a few beams corrects in turn: scalars only, so no matrix is inverted."""

    encoder: str = parameter("encoder", help="name of the sensor that counts the joints")
    laser: str = parameter("laser", help="name of the range sensor")
    beams: int = parameter(13, ge=1, static=True, help="beams that are used of a scan")
    start_std: float = parameter(0.2, unit="m", ge=0, help="standard deviation of the nominal position")
    start_heading_std: float = parameter(0.05, unit="rad", ge=0, help="standard deviation of the nominal heading")
    range_std: float = parameter(0.03, unit="m", gt=0, help="standard deviation of a range, and of the map")
    forward_variance: float = parameter(0.002, unit="m", ge=0, help="of the way, per metre of it")
    turn_variance: float = parameter(0.02, unit="rad^2/m", ge=0, help="of the heading, per metre of way")
    gate: float = parameter(5.0, gt=0, help="innovations of more standard deviations are left out")

    def start(self, context: Context) -> State:
        needs_map(self, context)
        covariance = np.zeros((context.rows, 3, 3))
        covariance[:, 0, 0] = covariance[:, 1, 1] = np.broadcast_to(self.start_std, (context.rows, 1))[:, 0] ** 2
        covariance[:, 2, 2] = np.broadcast_to(self.start_heading_std, (context.rows, 1))[:, 0] ** 2
        return {
            "pose": np.array(context.pose),
            "covariance": covariance,
            "joints": np.full((context.rows, len(context.robot.drive.joints)), np.nan),
        }

    def update(
        self,
        robot: RobotModel,
        readings: Mapping[str, Measurement],
        command: Array,
        elapsed: Array,
        state: State,
        draws: Draws,
    ) -> Estimate:
        self._predict(robot, readings, state)
        self._correct(robot, readings, state)
        return Estimate(pose=state["pose"], covariance=state["covariance"])

    def _predict(self, robot: RobotModel, readings: Mapping[str, Measurement], state: State) -> None:
        encoder: Any = robot.sensors[self.encoder].sensor
        after = encoder.angles(readings[self.encoder].measured)
        before = np.where(np.isnan(state["joints"]), after, state["joints"])
        moved = robot.drive.displacement(before, after, np.ones((robot.rows, 1)))
        pose, old = state["pose"], state["covariance"]
        new = compose(pose, moved)
        dx, dy = (new - pose)[:, 0], (new - pose)[:, 1]
        # F P F' with F = I but for the heading's part in the way.
        half = old.copy()
        half[:, 0] -= dy[:, None] * old[:, 2]
        half[:, 1] += dx[:, None] * old[:, 2]
        grown = half.copy()
        grown[:, :, 0] -= dy[:, None] * half[:, :, 2]
        grown[:, :, 1] += dx[:, None] * half[:, :, 2]
        way = np.sqrt(dx * dx + dy * dy)
        c, s = np.cos(pose[:, 2]), np.sin(pose[:, 2])
        along = way * self.forward_variance[:, 0]
        grown[:, 0, 0] += along * c * c
        grown[:, 1, 1] += along * s * s
        grown[:, 0, 1] += along * c * s
        grown[:, 1, 0] += along * c * s
        grown[:, 2, 2] += way * self.turn_variance[:, 0]
        state["pose"], state["covariance"], state["joints"] = new, grown, after

    def _correct(self, robot: RobotModel, readings: Mapping[str, Measurement], state: State) -> None:
        reading, model = readings[self.laser], robot.sensors[self.laser]
        which = np.linspace(0, model.size - 1, self.beams).astype(np.int64)
        pose, covariance = state["pose"], state["covariance"].copy()
        poses = np.repeat(pose[:, None, :], 7, axis=1)
        for axis in range(3):
            poses[:, 1 + 2 * axis, axis] -= _NUDGE[axis]
            poses[:, 2 + 2 * axis, axis] += _NUDGE[axis]
        ranges = expected_ranges(robot, self.laser, poses, which)
        with np.errstate(invalid="ignore"):
            slopes = (ranges[:, 2::2] - ranges[:, 1::2]) / (2.0 * _NUDGE)[:, None]  # (N, 3, beams)
            innovations = reading.measured[:, which] - ranges[:, 0]
            # Where a nudge meets another wall, the difference is not a slope; those of one wall, seen not too flatly,
            # are below three metres a metre, and below three times the range a radian.
            plain = np.full_like(ranges[:, 0], 3.0)
            limit = np.stack((plain, plain, 3.0 * ranges[:, 0]), axis=1)
            smooth = (np.abs(slopes) < limit).all(axis=1)
        usable = reading.fresh & np.isfinite(innovations) & smooth
        correction = np.zeros_like(pose)
        for i in range(self.beams):
            slope = np.where(usable[:, i : i + 1], slopes[:, :, i], 0.0)
            spread = (
                covariance[:, :, 0] * slope[:, :1]
                + covariance[:, :, 1] * slope[:, 1:2]
                + covariance[:, :, 2] * slope[:, 2:]
            )
            variance = _dot(slope, spread) + self.range_std * self.range_std
            innovation = np.where(usable[:, i : i + 1], innovations[:, i : i + 1], 0.0) - _dot(slope, correction)
            taken = usable[:, i : i + 1] & (innovation * innovation < self.gate * self.gate * variance)
            correction += np.where(taken, spread * innovation / variance, 0.0)
            shrink = spread[:, :, None] * spread[:, None, :] / variance[:, :, None]
            covariance -= np.where(taken[:, :, None], shrink, 0.0)
        new = pose + correction
        new[:, 2] = wrap_angle(new[:, 2])
        state["pose"], state["covariance"] = new, covariance


def _dot(a: Array, b: Array) -> Array:
    return a[:, :1] * b[:, :1] + a[:, 1:2] * b[:, 1:2] + a[:, 2:] * b[:, 2:]


def test_finds_its_place_while_odometry_drifts_away() -> None:
    # Two rows of one group: other tracks, other fields of view of the laser.
    sim = Simulation(lost_robots({"ekf": MapEkf()}, offset=0.15))
    advance(sim, 150)
    assert not sim.events
    frame = sim.frames()[0]
    ekf, odometry = frame.estimates["ekf"], frame.estimates["odometry"]
    assert (position_errors(frame.true_pose, odometry.pose) > 0.3).all()
    assert (position_errors(frame.true_pose, ekf.pose) < 0.05).all()
    error = relative(ekf.pose, frame.true_pose)
    assert (np.abs(error[:, 2]) < 0.02).all()
    deviations = np.sqrt(np.linalg.eigvalsh(ekf.covariance))
    assert (deviations < 0.05).all()
    # What it says of itself holds: the errors are within four of its standard deviations.
    assert (np.abs(ekf.pose - frame.true_pose) < 4.0 * np.sqrt(np.diagonal(ekf.covariance, axis1=1, axis2=2))).all()


def test_says_so_where_the_robot_knows_no_map() -> None:
    scenario = lost_robots({"ekf": MapEkf()}, offset=0.0)
    robots = [attrs.evolve(robot, knowledge=Knowledge()) for robot in scenario.robots]
    with pytest.raises(ComponentError, match=r"knowledge\.map"):
        Simulation(attrs.evolve(scenario, robots=robots))


def test_bits() -> None:
    check_bits(lost_robots({"ekf": MapEkf()}, offset=0.1))
