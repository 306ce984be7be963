"""The extended Kalman filter, given readings by hand."""

import math

import numpy as np
import pytest

import amorsim as am
from amorsim.contracts import Mount
from amorsim.drives import Differential
from amorsim.estimators import DeadReckoning, Ekf
from amorsim.testing import check_component
from tests.estimators.ekf_rig import ASIDE, DT, RADIUS, TRACK, Filter, corrected_by_arc, seen
from tests.some_cases import one_in

WHEELS = 1e-4
MARKS = ((1, 5.0, 0.0), (2, 0.0, 4.0), (7, -3.0, -2.0))


def by_landmarks(**changes):
    return Ekf(
        **({"wheel_variance": WHEELS, "landmarks": "fiducial", "range_std": 0.05, "bearing_std": 0.02} | changes)
    )


def exact_update(mean, covariance, slopes, residual, noise):
    """The update of a Kalman filter in one piece, with matrices."""
    spread = slopes @ covariance @ slopes.T + noise
    gain = covariance @ slopes.T @ np.linalg.inv(spread)
    return mean + gain @ residual, covariance - gain @ slopes @ covariance, spread


def test_without_corrections_it_is_dead_reckoning():
    ekf, reckoning = Filter(Ekf(wheel_variance=WHEELS)), Filter(DeadReckoning(wheel_variance=WHEELS))
    rng = np.random.default_rng(3)
    for turned in rng.normal(1.0, 0.5, (60, 2)):
        found, wanted = ekf.step(turned), reckoning.step(turned)
    np.testing.assert_array_equal(found.pose, wanted.pose)
    np.testing.assert_allclose(found.covariance, wanted.covariance, rtol=1e-12, atol=1e-18)


def test_predicted_by_commands_it_follows_the_nominal_drive():
    drive = Differential(
        wheel_radius_left=RADIUS, wheel_radius_right=RADIUS, track=TRACK, rate_max=10.0, acceleration_max=5.0
    )
    by_command = Filter(Ekf(wheel_variance=WHEELS, prediction="command"), drive=drive)
    by_encoder = Filter(Ekf(wheel_variance=WHEELS), drive=drive)
    one = am.stack([drive])
    joints, rates = np.zeros((1, 2)), np.zeros((1, 2))
    by_command.step()
    by_encoder.step()
    for k in range(40):
        command = np.array([[3.0, 3.0 + math.sin(0.3 * k)]])
        before = joints
        joints, rates = one.advance(joints, rates, command, DT, {}, by_command.draws)
        found = by_command.step(command=command)
        wanted = by_encoder.step(joints - before)
    np.testing.assert_allclose(found.pose, wanted.pose, atol=1e-12)
    np.testing.assert_allclose(found.covariance, wanted.covariance, rtol=1e-9, atol=1e-18)


@pytest.mark.long
def test_gyro_and_compass_reach_the_steady_state_of_the_scalar_filter():
    # Wheels and gyro each say how far the robot turned, with variances of 2e-5 that combine to Q = 1e-5.
    length = 0.1
    variance = 2e-5 * TRACK**2 / (2.0 * length)
    estimator = Ekf(
        wheel_variance=variance,
        compass="compass",
        compass_std=0.05,
        gyro="gyro",
        gyro_std=math.sqrt(2e-5) / DT,
        gyro_bias_std=0.0,
        start_heading_std=0.1,
    )
    robot = Filter(estimator)
    robot.step()
    for _ in range(400):
        found = robot.step([length / RADIUS] * 2, gyro=[0.0], compass=[0.0])
    assert found.covariance[0, 2, 2] == pytest.approx(1.531929e-4, abs=5e-11)
    prior = found.covariance[0, 2, 2] + 1e-5
    q, r = 1e-5, 2.5e-3
    exact = 0.5 * (q + math.sqrt(q * q + 4.0 * q * r))
    assert prior == pytest.approx(exact, abs=1e-12)
    assert found.covariance[0, 2, 2] == pytest.approx(exact * r / (exact + r), abs=1e-12)
    step = robot.step([length / RADIUS] * 2, gyro=[0.0], compass=[0.01])
    assert step.pose[0, 2] - found.pose[0, 2] == pytest.approx(0.06128 * 0.01, abs=1e-7)


@pytest.mark.long
def test_a_linear_case_is_the_exact_filter():
    # The heading is known and stays, so that wheels and places are linear in the state; their errors are correlated.
    rng = np.random.default_rng(5)
    std, correlation, length = 0.3, 0.6, 0.2
    estimator = Ekf(wheel_variance=0.0, gps="gps", gps_std=std, gps_correlation=correlation, start_std=0.5, gate=1.0)
    robot = Filter(estimator, start=(1.0, -2.0, 0.4))
    mean, covariance = np.array([1.0, -2.0]), np.eye(2) * 0.25
    noise = std**2 * np.array([[1.0, correlation], [correlation, 1.0]])
    for k in range(50):
        place = rng.normal(0.0, 1.0, 2)
        found = robot.step([length / RADIUS] * 2, gps=place)
        if k:
            mean = mean + length * np.array([math.cos(0.4), math.sin(0.4)])
        residual = place - mean
        mean, covariance, spread = exact_update(mean, covariance, np.eye(2), residual, noise)
        np.testing.assert_allclose(found.pose[0, :2], mean, rtol=0, atol=1e-12)
        np.testing.assert_allclose(found.covariance[0, :2, :2], covariance, rtol=0, atol=1e-12)
        beliefs = robot.beliefs()
        np.testing.assert_allclose(beliefs["gps_innovation_covariance"][0], spread, atol=1e-12)
        assert beliefs["gps_nis"][0] == pytest.approx(residual @ np.linalg.solve(spread, residual), rel=1e-10)


def test_the_gyros_bias_is_learnt_as_by_the_exact_filter():
    # Heading and bias alone, written with matrices: the turn of the wheels is a noisy reading of the turn, and so is
    # the gyro's.
    length, gyro_std, compass_std, walk = 0.1, 0.02, 0.05, 1e-3
    estimator = Ekf(
        wheel_variance=WHEELS,
        compass="compass",
        compass_std=compass_std,
        gyro="gyro",
        gyro_std=gyro_std,
        gyro_bias_std=0.1,
        gyro_bias_walk=walk,
        gate=1.0,
    )
    robot = Filter(estimator)
    robot.step()
    rng = np.random.default_rng(6)
    turn_variance = 2.0 * WHEELS * length / TRACK**2
    mean, covariance = np.zeros(2), np.diag([0.0, 0.01])
    for _ in range(100):
        gyro, compass = rng.normal(0.05, gyro_std), rng.normal(0.0, compass_std)
        found = robot.step([length / RADIUS] * 2, gyro=[gyro], compass=[compass])
        # State: heading, bias, and the turn of this step.
        wide = np.zeros((3, 3))
        wide[:2, :2] = covariance
        wide[1, 1] += walk**2 * DT
        wide[0, 0] += turn_variance
        wide[0, 2] = wide[2, 0] = wide[2, 2] = turn_variance
        three, wide, _ = exact_update(
            np.array([*mean, 0.0]), wide, np.array([[0.0, 1.0, 1.0 / DT]]), np.array([gyro - mean[1]]), gyro_std**2
        )
        three, wide, _ = exact_update(
            three, wide, np.array([[1.0, 0.0, 0.0]]), np.array([compass - three[0]]), compass_std**2
        )
        mean, covariance = three[:2], wide[:2, :2]
    beliefs = robot.beliefs()
    assert found.pose[0, 2] == pytest.approx(mean[0], abs=1e-12)
    assert beliefs["gyro_bias"][0] == pytest.approx(mean[1], abs=1e-12)
    assert beliefs["gyro_bias_variance"][0] == pytest.approx(covariance[1, 1], rel=1e-9)
    assert beliefs["gyro_bias"][0] == pytest.approx(0.05, abs=4.0 * math.sqrt(covariance[1, 1]))


def test_a_sighting_corrects_as_the_update_in_one_piece():
    mount = Mount(x=0.2, y=-0.1, heading=0.5)
    robot = Filter(
        by_landmarks(start_std=0.1, start_heading_std=0.05, gate=1.0), mounts={"fiducial": mount}, marks=MARKS
    )
    pose = np.array([0.05, -0.08, 0.03])
    reading = seen(pose, MARKS[1:2], (0.2, -0.1, 0.5))

    def expected(state):
        return np.array(seen(state, MARKS[1:2], (0.2, -0.1, 0.5))[:2])

    nudge = 1e-6
    slopes = np.stack([(expected(e * nudge) - expected(-e * nudge)) / (2.0 * nudge) for e in np.eye(3)], axis=1)
    residual = np.array(reading[:2]) - expected(np.zeros(3))
    covariance = np.diag([0.01, 0.01, 0.0025])
    step, covariance, spread = exact_update(np.zeros(3), covariance, slopes, residual, np.diag([0.0025, 0.0004]))
    mean, covariance = corrected_by_arc(np.zeros(3), step, covariance)
    found = robot.step(fiducial=reading)
    np.testing.assert_allclose(found.pose[0], mean, atol=1e-8)
    np.testing.assert_allclose(found.covariance[0], covariance, atol=1e-9)
    beliefs = robot.beliefs()
    np.testing.assert_allclose(beliefs["landmarks_innovation"][0, 0], residual, atol=1e-12)
    np.testing.assert_allclose(beliefs["landmarks_innovation_covariance"][0, 0], spread, atol=1e-8)
    assert beliefs["landmarks_match"][0, 0] == 1.0
    assert beliefs["landmarks_used"][0, 0] == 1.0
    assert np.isnan(beliefs["landmarks_nis"][0, 1:]).all()


def test_sightings_of_one_landmark_tell_nothing_of_a_turn_around_it():
    """What is known of that turn, v' P^-1 v, stays; with corrections that go straight it became 4.6 times as much."""
    x, y = MARKS[0][1:]
    robot = Filter(by_landmarks(wheel_variance=0.0, start_std=0.5, start_heading_std=0.35, gate=1.0), marks=MARKS[:1])
    rng = np.random.default_rng(5)
    pose, turned = np.array([0.4, -0.5, 0.3]), np.zeros(2)
    known = []
    for _ in range(60):
        reading = seen(pose, MARKS[:1])
        reading[:2] = reading[:2] + rng.normal(0.0, [0.05, 0.02])
        robot.step(turned, fiducial=reading)
        mean, covariance = robot.state["mean"][0], robot.state["covariance"][0, :3, :3]
        turn = np.append(ASIDE @ (mean[:2] - [x, y]), 1.0)
        known.append(turn @ np.linalg.solve(covariance, turn))
        turned = rng.normal(0.3, 0.3, 2)
        ways = turned * RADIUS
        moved = am.exponential(np.array([[ways.mean(), 0.0, (ways[1] - ways[0]) / TRACK]]), np.ones((1, 1)))
        pose = am.compose(pose[None], moved)[0]
    start = np.append(ASIDE @ [-x, -y], 1.0)
    first = start @ np.linalg.solve(np.diag([0.25, 0.25, 0.35**2]), start)
    np.testing.assert_allclose(known, first, rtol=1e-6)


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_a_landmark_exactly_behind_is_a_small_innovation(side):
    # The bearing expected is pi; the one read lies just across.
    robot = Filter(by_landmarks(start_heading_std=0.05, start_std=0.01), marks=((1, -5.0, 0.0),))
    found = robot.step(fiducial=seen((0.0, 0.0, 0.01 * side), ((1, -5.0, 0.0),)))
    innovation = robot.beliefs()["landmarks_innovation"][0, 0]
    assert innovation[1] == pytest.approx(-0.01 * side, abs=1e-12)
    assert 0.0 < found.pose[0, 2] * side < 0.01


@pytest.mark.long
def test_headings_may_go_through_half_a_turn_and_be_read_turns_away():
    estimator = by_landmarks(compass="compass", compass_std=0.02, start_heading_std=0.1)
    starts = [(0.0, 0.0, heading) for heading in (3.0, 3.0, -0.14)]
    shifts = np.array([[0.0], [2.0 * math.pi], [0.0]])
    robot = Filter([estimator] * 3, start=starts, marks=((1, 0.0, 0.0),))
    heading = np.array([3.0, 3.0, 3.0 - math.pi])
    turn = 0.05
    for k in range(12):
        read = heading[:, None] + shifts
        found = robot.step([-0.5 * TRACK * turn / RADIUS, 0.5 * TRACK * turn / RADIUS], compass=read)
        innovation = robot.beliefs()["compass_innovation"]
        assert (np.abs(innovation) < 0.2).all(), k
        heading = heading + turn
    assert np.abs(am.wrap_angle(found.pose[:, 2] - (heading - turn))).max() < 0.02
    assert (np.abs(found.pose[:, 2]) <= math.pi).all()
    # A turn more in the reading changes nothing but rounding.
    np.testing.assert_allclose(found.pose[1], found.pose[0], atol=1e-12)


def test_a_tenth_of_the_step_gives_the_same_belief():
    for turned in ([6.0, 6.0], [5.0, 6.5]):
        once, often = Filter(by_landmarks()), Filter(by_landmarks(), dt=DT / 10.0)
        once.step()
        often.step()
        for _ in range(10):
            whole = once.step(turned)
            for _ in range(10):
                parts = often.step(np.array(turned) / 10.0)
        np.testing.assert_allclose(parts.pose, whole.pose, atol=1e-9)
        np.testing.assert_allclose(parts.covariance, whole.covariance, rtol=1e-6, atol=1e-12)


def test_the_gate_refuses_what_it_should_and_says_so():
    # With one degree of freedom 99.9 % lie within 3.2905 standard deviations.
    for offset, used in ((3.28, 1.0), (3.30, 0.0)):
        robot = Filter(Ekf(wheel_variance=WHEELS, compass="compass", compass_std=0.04, start_heading_std=0.03))
        found = robot.step(compass=[offset * 0.05])
        beliefs = robot.beliefs()
        assert beliefs["compass_used"][0] == used
        assert beliefs["compass_nis"][0] == pytest.approx(offset**2, rel=1e-12)
        assert (found.pose[0, 2] != 0.0) == bool(used)
    # With two, 13.816.
    for offset, used in ((3.70, 1.0), (3.73, 0.0)):
        robot = Filter(Ekf(wheel_variance=WHEELS, gps="gps", gps_std=0.4, start_std=0.3))
        robot.step(gps=[0.0, offset * 0.5])
        assert robot.beliefs()["gps_used"][0] == used
    robot = Filter(Ekf(wheel_variance=WHEELS, gps="gps", gps_std=0.4, start_std=0.3, gate=1.0))
    robot.step(gps=[50.0, 0.0])
    assert robot.beliefs()["gps_used"][0] == 1.0


def test_without_identities_the_nearest_is_taken_and_each_once():
    estimator = by_landmarks(association="nearest", start_std=0.05, start_heading_std=0.02)
    marks = [(0, x, y) for _, x, y in MARKS]
    robot = Filter(estimator, marks=marks)
    pose = (0.03, -0.02, 0.01)
    found = robot.step(fiducial=seen(pose, [marks[2], marks[0], marks[0]]))
    beliefs = robot.beliefs()
    assert beliefs["landmarks_match"][0, :2].tolist() == [2.0, 0.0]
    assert beliefs["landmarks_used"][0, :2].tolist() == [1.0, 1.0]
    assert beliefs["landmarks_used"][0, 2] == 0.0  # landmark 0 is taken, and no other is near
    assert np.isnan(beliefs["landmarks_nis"][0, 3])
    assert np.abs(found.pose[0] - pose).max() < 0.02


def test_identities_that_the_robot_does_not_know_are_left_alone():
    robot = Filter(by_landmarks(start_std=0.1))
    before = robot.step()
    after = robot.step(fiducial=seen((0.0, 0.1, 0.0), ((9, 5.0, 0.0), (0, 5.0, 0.0))))
    np.testing.assert_array_equal(after.pose, before.pose)
    assert np.isnan(robot.beliefs()["landmarks_used"]).all()


@pytest.mark.parametrize(
    ("changes", "marks", "problem"),
    [
        ({"landmarks": "laser"}, MARKS, "'laser', which the robot does not have"),
        ({"landmarks": "gps"}, MARKS, "does not measure range, bearing and id"),
        ({"compass": "gyro", "compass_std": 0.1}, MARKS, "does not measure one heading"),
        ({"range_std": None}, MARKS, "state the standard deviation of the range .* 'range_std'"),
        ({"gyro": "gyro", "gyro_std": 0.1}, MARKS, "'gyro_bias_std'"),
        ({}, (), "knows none"),
        ({}, ((0, 1.0, 2.0),), "association = 'nearest'"),
        ({}, ((4, 1.0, 2.0), (4, 2.0, 2.0)), "have the id 4"),
        ({"association": "nearest"}, ((4, 1.0, 2.0), (5, 1.0, 2.0)), r"2 landmarks at \(1, 2\) m"),
        ({"encoder": "gyro"}, MARKS, "counts no joints"),
    ],
)
def test_what_cannot_be_fused_is_refused_at_the_start(changes, marks, problem):
    with pytest.raises(am.ComponentError, match=problem):
        Filter(by_landmarks(**changes), marks=marks)


def test_late_readings_are_refused_unless_an_age_is_allowed():
    given = {"wheel_variance": WHEELS, "compass": "compass", "compass_std": 0.1}
    with pytest.raises(am.ComponentError, match=r"'compass' was 0\.2 s old"):
        Filter(Ekf(**given)).step(compass=[0.0], age=0.2)
    Filter(Ekf(**given, age_max=0.2)).step(compass=[0.0], age=0.2)


def test_it_tells_what_is_fused_from_what():
    listed = by_landmarks(gyro="gyro", gyro_std=math.radians(0.5), gyro_bias_std=math.radians(2.0)).sources()
    assert listed == [
        ("sensor 'encoder'", "predicts x, y, heading", "0.0001 m² of travel per m"),
        ("sensor 'gyro'", "corrects heading, bias", "rate 0.5°/s, bias at first 2°/s"),
        ("sensor 'fiducial'", "corrects x, y, heading", "range 0.05 m, bearing 1.14592°"),
        ("gates", "pass", "99.9 % of good readings"),
    ]
    assert "no sensor" in Ekf(wheel_variance=WHEELS).sources()[1]


@pytest.mark.parametrize("prediction", ["encoder", "command"])
def test_it_keeps_the_contract(prediction):
    check_component(
        Ekf(
            prediction=prediction,
            wheel_variance=WHEELS,
            compass="compass",
            compass_std=0.02,
            gyro="gyro",
            gyro_std=0.01,
            gyro_bias_std=0.1,
            gyro_bias_walk=0.001,
            gps="gps",
            gps_std=0.5,
            gps_correlation=0.3,
            landmarks="marks",
            range_std=0.05,
            bearing_std=0.02,
            start_std=0.1,
            start_heading_std=0.1,
        ),
        sensors={"gps": am.sensors.Gps(), "marks": am.sensors.Fiducial(fov=6.0, range_max=20.0, range_max_id=20.0)},
    )


@pytest.mark.parametrize("prediction", ["encoder", "command"])
@pytest.mark.parametrize("model", one_in(2, ["car", "b21r", "youbot", "pioneer3dx"]))
def test_any_drive_predicts(prediction, model):
    drive = am.load_robot(model, name="rover").drive
    estimator = Ekf(prediction=prediction, wheel_variance=WHEELS, compass="compass", compass_std=0.02)
    check_component(estimator, drive=drive)
