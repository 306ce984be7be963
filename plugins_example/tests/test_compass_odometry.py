"""The estimator against the closed forms of its filter, and against the errors that it reckons with."""

from typing import Any

import amorsim_example as example
import numpy as np
import pytest
from example_world import Hold, robot, simulation, tricycle

import amorsim as am

TRACK, RADIUS = 0.4, 0.1
SPEED, DT = 0.5, 0.1  # m/s, s
COMPASS = 0.05  # rad
K = 1e-4  # m^2/m, of each wheel
Q = 2.0 * K / TRACK**2  # rad^2/m, of the heading: two wheels, each a track's length of lever apart


def cart(**changes: Any) -> am.Robot:
    """A cart on two wheels that drives straight ahead, with noise on the ground and in its compass."""
    drive = am.drives.Differential(wheel_radius_left=RADIUS, wheel_radius_right=RADIUS, track=TRACK, rate_max=100.0)
    noise = (am.NoiseElement(name="gaussian", noise=am.noise.Gaussian(std=COMPASS)),)
    given: dict[str, Any] = {
        "drive": drive,
        "controller": Hold(channels=(SPEED / RADIUS, SPEED / RADIUS)),
        "ground": (am.NoiseElement(name="slip", noise=am.noise.Diffusion(variance_per_length=K)),),
        "sensors": {
            "encoder": am.sensors.Encoder(counts_per_revolution=4096.0),
            "compass": am.MountedSensor(sensor=am.sensors.Compass(), noise=noise),
        },
        "estimators": {"fused": example.CompassOdometry(compass_std=COMPASS, heading_variance=Q)},
    }
    return robot(**(given | changes))


def test_variance_of_the_heading_settles_where_the_filter_s_equation_says() -> None:
    sim = simulation(cart())
    sim.run(30.0)
    q, r = Q * SPEED * DT, COMPASS**2
    # P = (P + q) r / (P + q + r), solved for P.
    expected = 0.5 * (np.sqrt(q * q + 4.0 * q * r) - q)
    assert sim.covariance[0, 2, 2] == pytest.approx(expected, rel=1e-6)


def test_covariance_is_that_of_the_errors_over_many_replicas() -> None:
    n = 1000
    believes = example.CompassOdometry(compass_std=COMPASS, way_variance=K / 2.0, heading_variance=Q)
    sim = simulation(cart(estimators={"fused": believes}), replicas=n)
    sim.run(10.0)
    error = sim.estimated_pose - sim.true_pose
    error[:, 2] = am.wrap_angle(error[:, 2])
    found = (error[:, :, None] * error[:, None, :]).mean(axis=0)
    believed = sim.covariance.mean(axis=0)
    # A sample variance of n normal numbers has a relative standard deviation of sqrt(2 / n), a covariance that below.
    for axis in range(3):
        assert found[axis, axis] == pytest.approx(believed[axis, axis], rel=5.0 * np.sqrt(2.0 / n))
    spread = np.sqrt((found[1, 1] * found[2, 2] + found[1, 2] ** 2) / n)
    assert found[1, 2] == pytest.approx(believed[1, 2], abs=5.0 * spread)
    # Errors weighed by their covariance: a sum of three squares of standard normal numbers, of variance 6.
    weighed = np.einsum("ni,nij,nj->n", error, np.linalg.inv(sim.covariance), error)
    assert weighed.mean() == pytest.approx(3.0, abs=5.0 * np.sqrt(6.0 / n))
    # The compass is worth something: without it the variances were Q S and Q S^3 / 3 (S the way).
    way = 10.0 * SPEED
    assert believed[2, 2] < 0.2 * Q * way
    assert believed[1, 1] < 0.5 * Q * way**3 / 3.0


def test_without_a_look_at_the_compass_it_is_dead_reckoning() -> None:
    late = am.MountedSensor(sensor=am.sensors.Compass(), latency=0.5)
    encoder = am.sensors.Encoder(counts_per_revolution=4096.0)
    turning = Hold(channels=(4.0, 6.0))
    fused = simulation(
        cart(sensors={"encoder": encoder, "compass": late}, controller=turning, pose=am.Pose(heading=0.2))
    )
    plain = simulation(
        cart(
            sensors={"encoder": encoder},
            controller=turning,
            pose=am.Pose(heading=0.2),
            estimators={"plain": am.estimators.DeadReckoning()},
        )
    )
    # The compass's first reading is of tick 0, when the robot is sure of its heading; later ones come late.
    fused.run(20.0)
    plain.run(20.0)
    np.testing.assert_array_equal(fused.true_pose, plain.true_pose)
    np.testing.assert_allclose(fused.estimated_pose, plain.estimated_pose, rtol=0, atol=1e-12)


def test_a_wrong_wheelbase_turns_dead_reckoning_away_but_not_this() -> None:
    sensors = {
        "encoder": am.sensors.Encoder(counts_per_revolution=4096.0),
        "compass": am.MountedSensor(sensor=am.sensors.Compass(), mount=am.Mount(heading=0.3)),
    }
    estimators = {
        "fused": example.CompassOdometry(compass_std=0.01, heading_variance=1e-2),
        "dead_reckoning": am.estimators.DeadReckoning(),
    }
    lift = robot(
        sensors=sensors,
        estimators=estimators,
        controller=Hold(channels=(0.5, 5.0)),
        errors={"drive.wheelbase": am.Deviation(scale=1.1)},
        drive=tricycle(),
    )
    sim = simulation(lift)
    sim.run(60.0)
    true = sim.true_pose
    estimates = sim.frames()[0].estimates
    off = {name: abs(am.relative(true, estimate.pose)[0, 2]) for name, estimate in estimates.items()}
    assert off["dead_reckoning"] > 0.5
    assert off["fused"] < 0.03


@pytest.mark.parametrize(
    ("fields", "message"),
    [
        (
            {"compass": "compas"},
            "no sensor 'compas'; it has: encoder, compass; name one of them in the field 'compass'",
        ),
        ({"encoder": "compass"}, "'compass' counts no joints"),
    ],
)
def test_a_missing_sensor_is_named(fields: dict[str, str], message: str) -> None:
    with pytest.raises(am.ComponentError, match=message):
        simulation(cart(estimators={"fused": example.CompassOdometry(compass_std=0.1, **fields)}))
