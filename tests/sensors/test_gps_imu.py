"""Places and accelerations against closed forms."""

import math

import numpy as np
import pytest

import amorsim as am
from amorsim.core.poses import compose, wrap_angle
from amorsim.noise import BiasInstability, Dropout, Gaussian
from amorsim.scenario.spec import MountedSensor, Pose
from amorsim.sensors import Gps, Imu
from tests.building import empty, robot, room, scenario

MOUNT = am.Mount(x=0.4, y=-0.15, heading=0.7)


def simulate(sensor, *, dt=0.05, world=None, pose=Pose(), **mounted):  # noqa: B008 - frozen
    unit = MountedSensor(sensor=sensor, **mounted)
    made = scenario(robot(pose=pose, sensors={"unit": unit}, estimators={}), map=world or empty(), dt=dt)
    return am.Simulation(made)


def test_a_fix_is_the_place_of_the_antenna():
    sim = simulate(Gps(heading=True), mount=MOUNT, pose=Pose(x=3.0, y=-2.0, heading=3.0))
    sim.robot("rover").drive(forward=0.5, turn=0.8)
    for _ in range(40):
        sim.step()
        expected = compose(sim.true_pose, np.array([[MOUNT.x, MOUNT.y, MOUNT.heading]]))[0]
        found = sim.robot("rover").readings["unit"].true
        np.testing.assert_allclose(found[:2], expected[:2], atol=1e-12)
        assert abs(wrap_angle(np.array([found[2] - expected[2]]))[0]) < 1e-12


def test_fixes_come_with_a_rate_late_and_with_noise_of_both_coordinates():
    noise = (
        BiasInstability(std=1.0, correlation_time=60.0),
        Gaussian(std=0.02),
        Dropout(probability=0.1, report="last"),
    )
    sim = simulate(Gps(), dt=0.1, rate=5.0, latency=0.3, noise=noise)
    sim.robot("rover").drive(forward=1.0)
    stamps = []
    for _ in range(50):
        sim.step()
        reading = sim.robot("rover").readings["unit"]
        if reading.fresh[0]:
            stamps.append(sim.tick - int(reading.stamp[0]))
            assert reading.true[0] == pytest.approx(0.1 * reading.stamp[0], abs=1e-9)
            assert (np.abs(reading.measured - reading.true) < 6.0).all()
    assert set(stamps) == {3}
    assert len(stamps) in (24, 25)


@pytest.mark.parametrize("dt", [0.01, 0.1, 0.5])
@pytest.mark.parametrize(("forward", "turn"), [(0.6, 0.9), (0.0, 1.5), (0.5, 0.0), (-0.4, 0.7)])
def test_on_a_circle_it_feels_the_centripetal_acceleration_at_its_place(forward, turn, dt):
    sim = simulate(Imu(), dt=dt, mount=MOUNT)
    sim.robot("rover").drive(forward=forward, turn=turn)
    for _ in range(5):
        sim.step()
    # The centre of the circle in the body's frame is (0, v / w); acceleration points there, w^2 times the radius.
    ahead, left = -(turn**2) * MOUNT.x, turn * forward - turn**2 * MOUNT.y
    c, s = math.cos(MOUNT.heading), math.sin(MOUNT.heading)
    expected = [c * ahead + s * left, c * left - s * ahead, turn]
    np.testing.assert_allclose(sim.robot("rover").readings["unit"].true, expected, atol=1e-9)
    radius = math.hypot(MOUNT.x, (forward / turn if turn else math.inf) - MOUNT.y)
    if turn:
        assert math.hypot(*sim.robot("rover").readings["unit"].true[:2]) == pytest.approx(turn**2 * radius, rel=1e-9)


def test_it_feels_a_start_and_a_wall():
    sim = simulate(Imu(), dt=0.1, world=room(), pose=Pose(x=5.0, y=2.0))
    read = lambda: sim.robot("rover").readings["unit"].true.copy()  # noqa: E731
    assert read().tolist() == [0.0, 0.0, 0.0]
    sim.robot("rover").drive(forward=0.5)
    sim.step()
    np.testing.assert_allclose(read(), [5.0, 0.0, 0.0], atol=1e-9)
    sim.step()
    np.testing.assert_allclose(read(), 0.0, atol=1e-9)
    felt = []
    while not sim.events:
        sim.step()
        felt.append(read()[0])
    sim.step()
    felt.append(read()[0])
    assert sum(felt) * 0.1 == pytest.approx(-0.5, abs=1e-9)  # all of the velocity, in two steps at most
    assert max(map(abs, felt[:-2])) < 1e-9


def test_with_a_rate_it_feels_the_mean_since_the_sample_before():
    sim = simulate(Imu(), dt=0.1, rate=5.0)
    for forward in (0.1, 0.3):
        sim.robot("rover").drive(forward=forward)
        sim.step()
    np.testing.assert_allclose(sim.robot("rover").readings["unit"].true, [1.5, 0.0, 0.0], atol=1e-9)


def test_noise_is_in_the_unit_of_its_column(tmp_path):
    noise = (
        am.NoiseElement(name="force", noise=Gaussian(std=0.05), column="ahead"),
        am.NoiseElement(name="rate", noise=Gaussian(std=0.01), column="turn"),
    )
    sim = simulate(Imu(), noise=noise)
    sim.step()
    reading = sim.robot("rover").readings["unit"]
    assert (reading.measured != reading.true).tolist() == [True, False, True]
