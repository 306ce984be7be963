"""Noise by travelled length spreads poses alike whatever the step, as the closed forms say.

A straight way S, each wheel's travel with an independent variance of k per metre, track b, q = 2 k / b^2:
var(heading) = q S, cov(y, heading) = q S^2 / 2, var(y) = q S^3 / 3, var(x) = k S / 2 + q^2 S^4 / 12.
"""

import math

import numpy as np
import pytest

import amorsim as am
from amorsim.noise import Diffusion
from tests import building

SPEED, WAY, K, REPLICAS = 0.5, 4.0, 2e-5, 5000


@pytest.mark.long
@pytest.mark.parametrize("dt", [0.01, 0.05, 0.1, 0.5])
def test_five_thousand_replicas_spread_as_the_closed_forms_whatever_the_step(dt):
    robot = building.robot(
        pose=am.Pose(), ground=building.chain(Diffusion(variance_per_length=K)), sensors={}, estimators={}
    )
    sim = am.Simulation(building.scenario(robot, map=building.empty(), dt=dt), replicas=REPLICAS)
    for replica in range(REPLICAS):
        sim.robot("rover", replica).drive(forward=SPEED)
    for _ in range(round(WAY / SPEED / dt)):
        sim.step()
    x, y, heading = sim.true_pose.T
    q = 2.0 * K / building.TRACK**2
    var_heading, var_y, covariance = q * WAY, q * WAY**3 / 3.0, q * WAY**2 / 2.0
    # A sample variance of n normal numbers has the relative standard error sqrt(2 / (n - 1)); five of them. The steps'
    # being finite makes var(y) less by 1 / (4 steps^2) of itself, below a thousandth.
    allowed = 5.0 * math.sqrt(2.0 / (REPLICAS - 1)) + 1e-3
    assert heading.var(ddof=1) == pytest.approx(var_heading, rel=allowed)
    assert y.var(ddof=1) == pytest.approx(var_y, rel=allowed)
    spread = math.sqrt((var_heading * var_y + covariance**2) / REPLICAS)
    assert np.cov(y, heading)[0, 1] == pytest.approx(covariance, abs=5.0 * spread)
    # x is a normal part and a squared one, whose kurtosis is below 4 times a normal's: its error is below 2 of them.
    assert x.var(ddof=1) == pytest.approx(K * WAY / 2.0 + q**2 * WAY**4 / 12.0, rel=2.0 * allowed)
