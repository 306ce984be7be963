"""Thrun's motion models and slip, between wheel and ground."""

import math

import numpy as np
import pytest
from scipy.special import ndtr

import amorsim as am
from amorsim.core.errors import ComponentError
from amorsim.noise import OdometryModel, Slip, VelocityModel
from tests import building
from tests.noise.sampling import Samples, assert_distributed, assert_moments, assert_uncorrelated

ROWS = 100_000
TRACK = building.TRACK
LEFT, RIGHT = 0.03, 0.05
WAY, TURN = 0.04, 0.02 / TRACK
VELOCITY = {"a1": 0.01, "a2": 2e-4, "a3": 0.3, "a4": 0.02, "a5": 0.1, "a6": 0.03}
ODOMETRY = {"a1": 0.02, "a2": 0.4, "a3": 0.01, "a4": 3e-4}


def motion(travel):
    """Errors of the way [m] and of the turn [rad] of a body whose wheels went so, against LEFT and RIGHT."""
    left, right = travel[:, 0], travel[:, 1]
    return 0.5 * (left + right) - WAY, (right - left) / TRACK - TURN


def velocity_std(v, w, scale=1.0):
    forward = VELOCITY["a1"] * v**2 + VELOCITY["a2"] * w**2
    turn = (VELOCITY["a3"] + VELOCITY["a5"]) * v**2 + (VELOCITY["a4"] + VELOCITY["a6"]) * w**2
    return math.sqrt(forward * scale), math.sqrt(turn * scale)


def odometry_std(way, turn, scale=1.0):
    forward = ODOMETRY["a3"] * way**2 + ODOMETRY["a4"] * (2.0 * (turn / 2.0) ** 2)
    turned = 2.0 * (ODOMETRY["a1"] * (turn / 2.0) ** 2 + ODOMETRY["a2"] * way**2)
    return math.sqrt(forward * scale), math.sqrt(turned * scale)


@pytest.mark.parametrize(
    ("noise", "std"),
    [(VelocityModel(**VELOCITY), velocity_std), (OdometryModel(**ODOMETRY), odometry_std)],
    ids=["velocity", "odometry"],
)
@pytest.mark.parametrize(("way", "turn"), [(WAY, TURN), (0.04, 0.0), (0.0, 0.06), (-0.04, 0.02)])
def test_a_step_has_the_models_variances(noise, std, way, turn):
    """The variances of speed and rate times dt^2, which is those of way and turn whatever dt."""
    travel = [way - 0.5 * TRACK * turn, way + 0.5 * TRACK * turn]
    out = Samples(noise, rows=ROWS, k=2).ground(travel, 0.1)
    forward = 0.5 * (out[:, 0] + out[:, 1]) - way
    turned = (out[:, 1] - out[:, 0]) / TRACK - turn
    for error, expected in zip((forward, turned), std(way, turn), strict=True):
        assert_moments(error, expected)
        assert_distributed(error, lambda x, s=expected: ndtr(x / s))
    assert_uncorrelated(forward, turned)


@pytest.mark.parametrize("kind", [VelocityModel, OdometryModel])
def test_each_number_of_a_model_acts_alone(kind):
    names = VELOCITY if kind is VelocityModel else ODOMETRY
    std = velocity_std if kind is VelocityModel else odometry_std
    for name, value in names.items():
        only = dict.fromkeys(names, 0.0) | {name: value}
        out = Samples(kind(**only), rows=ROWS, k=2).ground([LEFT, RIGHT], 0.1)
        saved = dict(names)
        names.update(only)
        try:
            expected = std(WAY, TURN)
        finally:
            names.update(saved)
        for error, one in zip(motion(out), expected, strict=True):
            if one:
                assert_moments(error, one)
            else:
                assert np.abs(error).max() < 1e-15


@pytest.mark.parametrize("kind", [VelocityModel, OdometryModel])
def test_steps_are_independent(kind):
    samples = Samples(kind(**(VELOCITY if kind is VelocityModel else ODOMETRY)), rows=ROWS, k=2)
    first, second = (motion(samples.ground([LEFT, RIGHT], 0.1)) for _ in range(2))
    assert_uncorrelated(*first, *second)


@pytest.mark.parametrize("dt", [0.02, 0.1, 0.5])
@pytest.mark.parametrize("kind", [VelocityModel, OdometryModel])
def test_with_an_interval_the_noise_does_not_depend_on_the_step(kind, dt):
    """One second at 0.4 m/s and 0.5 rad/s, the numbers meant for steps of 0.1 s: ten times a step's variance."""
    names, std = (VELOCITY, velocity_std) if kind is VelocityModel else (ODOMETRY, odometry_std)
    rows = ROWS // 4
    samples = Samples(kind(**names, interval=0.1), rows=rows, k=2)
    travel = np.array([0.4 - 0.25 * TRACK, 0.4 + 0.25 * TRACK]) * dt
    total = np.zeros((rows, 2))
    for _ in range(round(1.0 / dt)):
        total += samples.ground(travel, dt)
    expected = std(0.04, 0.05, scale=10.0)
    assert_moments(0.5 * (total[:, 0] + total[:, 1]) - 0.4, expected[0])
    assert_moments((total[:, 1] - total[:, 0]) / TRACK - 0.5, expected[1])


@pytest.mark.parametrize("dt", [0.1, 0.5])
def test_without_one_longer_steps_have_more(dt):
    """As published: an error per step, of the step's own size, so that its variance grows with the step."""
    samples = Samples(VelocityModel(**VELOCITY), rows=ROWS, k=2)
    total = np.zeros((ROWS, 2))
    for _ in range(round(1.0 / dt)):
        total += samples.ground([0.4 * dt, 0.4 * dt], dt)
    assert_moments(0.5 * (total[:, 0] + total[:, 1]) - 0.4, math.sqrt(VELOCITY["a1"] * 0.4**2 * dt))


@pytest.mark.parametrize("kind", [VelocityModel, OdometryModel])
def test_values_that_are_no_wheels_travels_are_refused(kind):
    with pytest.raises(ComponentError, match=r"a robot or a zone, with 2 joints that roll, got 3 values"):
        Samples(kind(), k=3)


@pytest.mark.parametrize("kind", [VelocityModel, OdometryModel])
def test_a_robot_standing_still_stays_where_it_is_and_one_that_drives_does_not(kind):
    noise = kind(**(VELOCITY if kind is VelocityModel else ODOMETRY))
    robot = building.robot(ground=building.chain(noise))
    sim = am.Simulation(building.scenario(robot))
    start = sim.true_pose.copy()
    sim.run(0.5)
    assert sim.true_pose.tobytes() == start.tobytes()
    sim.robot("rover").drive(forward=0.4)
    sim.run(0.5)
    error = sim.true_pose[0, :2] - start[0, :2] - 0.2 * np.array([math.cos(0.3), math.sin(0.3)])
    assert 1e-4 < math.hypot(*error) < 0.1


@pytest.mark.parametrize("dt", [0.05, 0.1, 0.25, 0.4])
def test_slip_takes_its_part_of_the_way_whatever_the_step(dt):
    """2 s at 0.4 m/s, of which 0.7 s at a quarter of it; begin and end are within steps."""
    slip = Slip(at=0.33, duration=0.7, factor=0.25)
    robot = building.robot(ground=building.chain(slip), pose=am.Pose())
    sim = am.Simulation(building.scenario(robot, map=building.empty(), dt=dt))
    sim.robot("rover").drive(forward=0.4)
    sim.run(2.0)
    assert sim.true_pose[0] == pytest.approx([0.4 * (2.0 - 0.75 * 0.7), 0.0, 0.0], abs=1e-9)
    assert sim.estimated_pose[0] == pytest.approx([0.8, 0.0, 0.0], abs=1e-9)  # encoders see nothing of it


def test_a_wheel_that_slips_alone_turns_the_robot():
    robot = building.robot(
        ground=building.chain(Slip(at=0.5, duration=0.5, factor=0.9, joint="left_wheel")), pose=am.Pose()
    )
    sim = am.Simulation(building.scenario(robot, map=building.empty(), dt=0.1))
    sim.robot("rover").drive(forward=0.4)
    sim.run(2.0)
    assert sim.true_pose[0, 2] == pytest.approx(0.1 * 0.2 / TRACK, abs=1e-9)


def test_events_follow_one_another_in_a_chain():
    events = [am.NoiseElement(name=f"e{i}", noise=Slip(at=float(i), duration=0.5, factor=0.0)) for i in range(3)]
    robot = building.robot(ground=tuple(events), pose=am.Pose())
    sim = am.Simulation(building.scenario(robot, map=building.empty(), dt=0.1))
    sim.robot("rover").drive(forward=0.4)
    sim.run(4.0)
    assert sim.true_pose[0, 0] == pytest.approx(0.4 * (4.0 - 1.5), abs=1e-9)


def test_a_joint_that_is_not_there_is_named():
    with pytest.raises(ComponentError, match=r"left_wheel, right_wheel or nothing, got 'left_weel'. Did you mean"):
        Samples(Slip(at=0.0, duration=1.0, factor=0.5, joint="left_weel"), k=2)
