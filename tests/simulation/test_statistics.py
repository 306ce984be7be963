"""What wheel noise does to many replicas, and what the estimator believes of it, against the closed forms.

A straight line of length S, each wheel's travel with an independent variance of k per metre, track b, q = 2 k / b^2:
var(heading) = q S, cov(y, heading) = q S^2 / 2, var(y) = q S^3 / 3, var(x) = k S / 2 + q^2 S^4 / 12, and on average
x = (2 / q) (1 - exp(-q S / 2)).
"""

from __future__ import annotations

import math

import numpy as np
import pytest

import amorsim as am
from amorsim.estimators.dead_reckoning import DeadReckoning
from amorsim.noise.diffusion import Diffusion
from amorsim.noise.gaussian import Gaussian
from tests import building

B = building.TRACK
SPEED = 0.4
DT = 0.1
STEP = SPEED * DT
K = 2e-5  # m^2 per m


def drive_straight(length: float, replicas: int, noise: am.Noise, k_known: float = 0.0, seed: int = 4) -> am.Simulation:
    robot = building.robot(
        pose=am.Pose(),
        ground=building.chain(noise),
        estimators={"dead_reckoning": DeadReckoning(wheel_variance=k_known)},
    )
    sim = am.Simulation(building.scenario(robot, map=building.empty(), dt=DT, seed=seed), replicas=replicas)
    for replica in range(replicas):
        sim.robot("rover", replica).drive(forward=SPEED)
    for _ in range(round(length / STEP)):
        sim.step()
    return sim


def check_spread(sim: am.Simulation, length: float, k: float, replicas: int) -> None:
    x, y, heading = sim.true_pose.T
    q = 2 * k / B**2
    # A sample variance of n draws has a relative standard error of sqrt(2 / (n - 1)); four of them are allowed, and a
    # thousandth for the steps' being finite.
    allowed = 4 * math.sqrt(2 / (replicas - 1)) + 1e-3
    var_heading, var_y = q * length, q * length**3 / 3
    covariance, var_x = q * length**2 / 2, k * length / 2 + q**2 * length**4 / 12
    assert heading.var(ddof=1) == pytest.approx(var_heading, rel=allowed)
    assert y.var(ddof=1) == pytest.approx(var_y, rel=allowed)
    # x is the sum of a normal part and of a squared one, whose kurtosis is higher: its error is larger, by less than 2.
    assert x.var(ddof=1) == pytest.approx(var_x, rel=2 * allowed)
    spread = math.sqrt((var_heading * var_y + covariance**2) / replicas)
    assert np.cov(y, heading)[0, 1] == pytest.approx(covariance, abs=4 * spread)
    expected = 2 / q * (1 - math.exp(-q * length / 2))
    assert x.mean() == pytest.approx(expected, abs=4 * math.sqrt(var_x / replicas) + 1e-4 * length)
    assert abs(y.mean()) < 4 * math.sqrt(var_y / replicas)
    assert abs(heading.mean()) < 4 * math.sqrt(var_heading / replicas)


@pytest.mark.parametrize("seed", [4, 5])
def test_white_wheel_noise_spreads_as_the_closed_forms(seed: int) -> None:
    sim = drive_straight(8.0, 2000, Gaussian(std=math.sqrt(K * STEP)), seed=seed)
    check_spread(sim, 8.0, K, 2000)


def test_noise_by_length_spreads_alike_and_whatever_the_step() -> None:
    check_spread(drive_straight(8.0, 2000, Diffusion(variance_per_length=K)), 8.0, K, 2000)


def test_in_place_turns_spread_as_the_wheels_arcs() -> None:
    """A turn by phi rolls each wheel b phi / 2, so the heading's variance is k phi / b."""
    robot = building.robot(pose=am.Pose(), ground=building.chain(Diffusion(variance_per_length=K)))
    sim = am.Simulation(building.scenario(robot, map=building.empty(), dt=DT), replicas=2000)
    for replica in range(2000):
        sim.robot("rover", replica).drive(turn=1.0)
    for _ in range(30):
        sim.step()
    phi = 3.0
    assert (sim.true_pose[:, 2] - phi).var(ddof=1) == pytest.approx(K * phi / B, rel=4 * math.sqrt(2 / 1999))


@pytest.mark.parametrize("length", [2.0, 8.0])
def test_the_estimators_own_covariance_is_the_first_order_one(length: float) -> None:
    sim = drive_straight(length, 1, Gaussian(std=0.0), k_known=K)
    covariance = sim.covariance[0]
    q = 2 * K / B**2
    assert covariance[2, 2] == pytest.approx(q * length, rel=1e-9)
    assert covariance[1, 2] == pytest.approx(q * length**2 / 2, rel=1e-3)
    assert covariance[1, 1] == pytest.approx(q * length**3 / 3, rel=1e-3)
    assert covariance[0, 0] == pytest.approx(K * length / 2, rel=1e-9)
    assert (covariance == covariance.T).all()


def test_encoders_do_not_see_what_happens_between_wheel_and_ground() -> None:
    sim = drive_straight(4.0, 1, Gaussian(std=0.01))
    assert sim.estimated_pose[0] == pytest.approx([4.0, 0.0, 0.0], abs=1e-9)
    assert abs(sim.true_pose[0, 2]) > 1e-3
