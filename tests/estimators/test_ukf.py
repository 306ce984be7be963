"""The unscented Kalman filter: the extended one where all is linear, and better where it is not."""

from __future__ import annotations

import math

import attrs
import numpy as np
import pytest

import amorsim as am
from amorsim.contracts import Mount
from amorsim.estimators import Ekf, Ukf
from amorsim.testing import check_component
from tests.estimators.ekf_rig import DT, RADIUS, Filter, corrected_by_arc, seen
from tests.estimators.test_ekf_consistency import FUSIONS, TIMES, band, check_consistency, consistency, with_noise

WHEELS = 1e-4
MARKS = ((1, 5.0, 0.0), (2, 0.0, 4.0), (7, -3.0, -2.0))
LINEAR = {
    "wheel_variance": WHEELS,
    "gps": "gps",
    "gps_std": 0.3,
    "gps_correlation": 0.4,
    "compass": "compass",
    "compass_std": 0.1,
    "gyro": "gyro",
    "gyro_std": 0.2,
    "gyro_bias_std": 0.3,
    "gyro_bias_walk": 0.05,
    "start_std": 0.2,
    "start_heading_std": 0.1,
    "gate": 1.0,
}


def as_ukf(estimator, **changes):
    """The unscented filter with the same parameters."""
    return Ukf(**attrs.asdict(estimator, recurse=False), **changes)


@pytest.mark.parametrize("points", [{}, {"alpha": 0.5, "beta": 0.0}, {"kappa": 2.0}])
def test_where_all_is_linear_all_three_filters_agree(points):
    """A robot that stands: places, headings and rates of turn are linear in its state."""
    rng = np.random.default_rng(6)
    ekf, ukf = Filter(Ekf(**LINEAR)), Filter(Ukf(**LINEAR, **points))
    mean, covariance = np.zeros(4), np.diag([0.04, 0.04, 0.01, 0.09])
    gps = np.array([[1.0, 0.4], [0.4, 1.0]]) * 0.09
    for k in range(30):
        values = {"gps": rng.normal(0, 0.3, 2), "compass": rng.normal(0, 0.1, 1), "gyro": rng.normal(0, 0.3, 1)}
        found, again = ekf.step(**values), ukf.step(**values)
        updates = [] if k == 0 else [([[0, 0, 0, 1]], values["gyro"], [[0.04]])]
        covariance[3, 3] += 0.0 if k == 0 else 0.05**2 * DT
        updates += [([[0, 0, 1, 0]], values["compass"], [[0.01]])]
        updates += [([[1, 0, 0, 0], [0, 1, 0, 0]], values["gps"], gps)]
        for slopes, reading, noise in updates:
            slopes = np.array(slopes, dtype=float)
            gain = covariance @ slopes.T @ np.linalg.inv(slopes @ covariance @ slopes.T + noise)
            mean = mean + gain @ (reading - slopes @ mean)
            covariance = covariance - gain @ slopes @ covariance
        for estimate in (found, again):
            np.testing.assert_allclose(estimate.pose[0], mean[:3], rtol=0, atol=1e-12)
            np.testing.assert_allclose(estimate.covariance[0], covariance[:3, :3], rtol=0, atol=1e-12)


def test_an_update_is_that_of_its_points():
    """Range and bearing of one landmark, written out with matrices."""
    given = {"wheel_variance": 0.0, "landmarks": "fiducial", "range_std": 0.05, "bearing_std": 0.02, "gate": 1.0}
    estimator = Ukf(**given, start_std=0.4, start_heading_std=0.2)
    mount = (0.3, 0.1, 0.4)
    robot = Filter(estimator, mounts={"fiducial": Mount(x=0.3, y=0.1, heading=0.4)}, marks=MARKS[:1], start=(0, 0, 2.9))
    pose = (0.2, -0.3, 3.1)
    reading = seen(pose, MARKS[:1], mount)
    found = robot.step(fiducial=reading)
    mean, covariance = np.array([0.0, 0.0, 2.9, 0.0]), np.diag([0.16, 0.16, 0.04, 0.0])
    columns = np.diag([0.4, 0.4, 0.2, 0.0]) * 2.0
    points = np.concatenate((np.zeros((1, 4)), columns, -columns))
    arcs = [corrected_by_arc(mean, point, np.zeros((3, 3)))[0] for point in points]
    expected = np.array([seen(at, MARKS[:1], mount)[:2] for at in arcs])
    offsets = expected - expected[0]
    offsets[:, 1] = am.wrap_angle(offsets[:, 1])
    weights, middle = np.full(8, 0.125), 2.0
    offset = weights @ offsets[1:]
    away = offsets[1:] - offset
    spread = away.T @ np.diag(weights) @ away + middle * np.outer(offset, offset) + np.diag([0.05**2, 0.02**2])
    cross = points[1:].T @ np.diag(weights) @ away
    gain = cross @ np.linalg.inv(spread)
    residual = np.array(reading[:2]) - expected[0] - offset
    residual[1] = am.wrap_angle(residual[1])
    wanted, covariance = corrected_by_arc(mean, gain @ residual, covariance - gain @ spread @ gain.T)
    np.testing.assert_allclose(found.pose[0, :2], wanted[:2], atol=1e-12)
    assert abs(am.wrap_angle(found.pose[0, 2] - wanted[2])) < 1e-12
    np.testing.assert_allclose(found.covariance[0], covariance, atol=1e-12)


def test_a_way_with_a_doubtful_heading_is_shorter_and_wider_than_its_slopes_say():
    std, length = 0.5, 2.0
    ukf = Filter(Ukf(wheel_variance=0.0, start_heading_std=std))
    ukf.step()
    found = ukf.step([length / RADIUS] * 2)
    reach = 2.0 * std
    np.testing.assert_allclose(found.pose[0], [length * (0.75 + 0.25 * math.cos(reach)), 0.0, 0.0], atol=1e-12)
    # The exact mean is length * exp(-std**2 / 2), which slopes take for the length.
    assert abs(found.pose[0, 0] - length * math.exp(-0.5 * std**2)) < 0.01
    assert found.covariance[0, 1, 1] == pytest.approx(0.25 * (length * math.sin(reach)) ** 2, rel=1e-12)
    assert found.covariance[0, 0, 0] > 0.0


@pytest.mark.parametrize("turns", [1, -3])
def test_whole_turns_of_all_headings_change_nothing(turns):
    given = {"landmarks": "fiducial", "range_std": 0.05, "bearing_std": 0.02, "start_std": 0.2}
    estimator = Ukf(wheel_variance=WHEELS, **given, start_heading_std=0.2)
    behind = ((1, -3.0, 0.0),)
    robots = [Filter(estimator, marks=behind, start=(0.0, 0.0, 2.0 * math.pi * k)) for k in (0, turns)]
    for robot in robots:
        robot.step()
        for _ in range(5):
            robot.step([0.5, 0.6], fiducial=seen((0.0, 0.0, 0.0), behind))
    first, second = (robot.step() for robot in robots)
    assert np.abs(am.wrap_angle(first.pose[0] - second.pose[0])).max() < 1e-9


@pytest.mark.parametrize("fusion", FUSIONS)
def test_errors_are_as_large_as_it_says(fusion):
    check_consistency(as_ukf(FUSIONS[fusion]), 100, (12.0,))


@pytest.mark.parametrize(
    "replicas", [pytest.param(300, marks=pytest.mark.long), pytest.param(1000, marks=pytest.mark.nightly)]
)
@pytest.mark.parametrize("fusion", FUSIONS)
def test_errors_are_as_large_as_it_says_at_all_times(fusion, replicas):
    check_consistency(as_ukf(FUSIONS[fusion]), replicas, TIMES)


@pytest.mark.long
def test_a_filter_that_trusts_its_sensors_wrongly_leaves_the_band_on_the_right_side():
    low, high = band(3, 1000)
    for factor in (0.5, 2.0):
        for nees, nis in consistency(with_noise(as_ukf(FUSIONS["landmarks"]), factor), 1000, TIMES[:2]):
            assert nees > high if factor < 1.0 else nees < low, factor
            for mean, count, freedom in nis.values():
                low_nis, high_nis = band(freedom, count)
                assert mean > high_nis if factor < 1.0 else mean < low_nis, factor


def test_its_messages_name_it():
    with pytest.raises(am.ComponentError, match="ukf corrects by the sensor 'gps'"):
        Filter(Ukf(wheel_variance=WHEELS, gps="gps"))


@pytest.mark.long
def test_it_keeps_the_contract():
    check_component(
        Ukf(**LINEAR | {"gate": 0.999}, landmarks="marks", range_std=0.05, bearing_std=0.02),
        sensors={"gps": am.sensors.Gps(), "marks": am.sensors.Fiducial(fov=6.0, range_max=20.0, range_max_id=20.0)},
    )
