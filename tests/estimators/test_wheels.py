"""Encoders whose readings come late, or are lost for a while."""

from __future__ import annotations

import attrs
import numpy as np
import pytest

import amorsim as am
from amorsim.algorithms.consistency import chi_squared_band
from tests import building
from tests.estimators.test_bits import MAKERS, scenario

GPS, COMPASS, GYRO = 0.2, 0.05, 0.01


def ended(name, lost=(), begins=0, value=np.nan, jumps=(), blind=(), apart=()):
    """The last estimate and beliefs of an estimator that got no reading in some steps, and its pose with all readings.

    In `lost` the encoder's is not a number or `value`; in `blind` there is none of any other sensor. In `apart` the
    other sensors' readings come 0.01 s after the encoder's.
    """
    sim = am.Simulation(scenario(name), seed=5)
    runner = am.EstimatorRunner(sim.scenario.robots[0], "it", dt=sim.dt, seed=5)
    for step in range(12):
        if step:
            sim.step()
        frame = sim.frames()[0]
        readings = {sensor: reading.measured[0].copy() for sensor, (_, reading) in frame.readings.items()}
        if step < begins:
            del readings["encoder"]
        elif step in lost:
            readings["encoder"][-1] = value
        elif step in jumps:
            readings["encoder"][0] += 1e9
        if step in blind:
            readings = {"encoder": readings["encoder"]}
        time = frame.time[0]
        if step in apart:
            runner.update(time, {"encoder": readings.pop("encoder")}, frame.command[0])
            time += 0.01
        estimate = runner.update(time, readings, frame.command[0])
        assert np.isfinite(estimate.covariance).all()
        if "failed" in frame.beliefs.get("it", {}):
            assert not runner.beliefs["failed"]
    return estimate, runner.beliefs, frame.estimates["it"].pose[0]


def followed(name, **given):
    """The last pose of an estimator that got no reading of the encoder in some steps, and what it is with all."""
    estimate, _, wanted = ended(name, **given)
    return estimate.pose, wanted


@pytest.mark.parametrize("name", MAKERS)
def test_a_lost_reading_is_made_up_for_by_the_next(name):
    found, wanted = followed(name, lost=(4, 5))
    # A robot that turns while its encoder is silent: 0.1 m in one piece, and not in three.
    assert np.hypot(*(found - wanted)[:2]) < 0.03
    assert abs(found[2] - wanted[2]) < 0.03


@pytest.mark.parametrize("apart", [(), (5,)], ids=["together", "apart"])
@pytest.mark.parametrize("name", MAKERS)
def test_what_is_seen_while_the_reading_of_the_encoder_is_lost_changes_nothing(name, apart):
    """It is seen from further on, and would move the pose by what the next reading of the encoder moves it again."""
    (estimate, beliefs, _), (wanted, believed, _) = (
        ended(name, lost=(5,), blind=blind, apart=apart) for blind in ((3, 4), (3, 4, 5))
    )
    np.testing.assert_array_equal(estimate.pose, wanted.pose)
    np.testing.assert_array_equal(estimate.covariance, wanted.covariance)
    for key, belief in believed.items():
        np.testing.assert_array_equal(beliefs[key], belief, err_msg=key)


def test_a_fix_after_a_lost_reading_of_the_encoder_does_not_move_the_pose_twice():
    robot = building.robot(
        sensors={"encoder": building.encoder(), "gps": am.sensors.Gps()},
        estimators={"it": am.estimators.Ekf(wheel_variance=0.05, gps="gps", gps_std=0.02)},
    )
    runner = am.EstimatorRunner(robot, "it", dt=0.1)
    start = runner.update(0.0, {"encoder": [0, 0]}).pose
    stands = runner.update(0.1, {"encoder": [10_000, 10_000]}).pose
    place = start + 2.0 * (stands - start)
    runner.update(0.2, {"encoder": [np.inf, np.inf]})
    for time in (0.21, 0.22):
        np.testing.assert_array_equal(runner.update(time, {"gps": place[:2]}).pose, stands)
    found = runner.update(0.3, {"encoder": [20_000, 20_000]}).pose
    np.testing.assert_allclose(found, place, atol=1e-12)
    assert runner.update(0.31, {"gps": place[:2] + 0.02}).pose[0] > place[0] + 0.01


def test_fixes_before_the_first_reading_of_the_encoder_correct_the_pose():
    robot = building.robot(
        sensors={"encoder": building.encoder(), "gps": am.sensors.Gps()},
        estimators={"it": am.estimators.Ekf(wheel_variance=0.05, start_std=0.1, gps="gps", gps_std=0.02)},
    )
    runner = am.EstimatorRunner(robot, "it", dt=0.1)
    start = runner.update(0.0, {}).pose
    assert runner.update(0.1, {"gps": start[:2] + 0.1}).pose[0] > start[0] + 0.05


@pytest.mark.parametrize("value", [np.inf, -np.inf, 1e308])
@pytest.mark.parametrize("name", MAKERS)
def test_what_no_wheel_can_have_turned_is_a_lost_reading(name, value):
    found, wanted = followed(name, lost=(4,), value=value)
    assert np.hypot(*(found - wanted)[:2]) < 0.03
    assert abs(found[2] - wanted[2]) < 0.03


@pytest.mark.parametrize("name", MAKERS)
def test_a_log_need_not_begin_with_the_encoder(name):
    found, wanted = followed(name, begins=2)
    # What the wheels did before their first reading nobody knows: 0.08 m at most. Particles are drawn at other times.
    assert np.hypot(*(found - wanted)[:2]) < (0.3 if name == "monte_carlo" else 0.1)


@pytest.mark.parametrize("jumps", [(5,), range(5, 12)], ids=["once", "for good"])
@pytest.mark.parametrize("name", MAKERS)
def test_counts_that_jump_further_than_a_wheel_turns_begin_again(name, jumps):
    found, wanted = followed(name, jumps=jumps)
    # What the wheels did in the step of a jump nobody knows: 0.08 m in two steps at most.
    assert np.hypot(*(found - wanted)[:2]) < (0.3 if name == "monte_carlo" else 0.1)
    assert abs(found[2] - wanted[2]) < 0.1


def turning_robot(filter_, lost=0.0, **mounted):
    """A robot that turns as it drives; its encoder loses readings, and its filter knows the noise of all sensors."""

    def sensor(kind, std):
        return am.MountedSensor(sensor=kind(), noise=building.chain(am.noise.Gaussian(std=std)))

    known = {"gps": "gps", "gps_std": GPS, "compass": "compass", "compass_std": COMPASS}
    estimator = filter_(wheel_variance=1e-5, gyro="gyro", gyro_std=GYRO, gyro_bias_std=0.5, **known)
    chain = building.chain(am.noise.Dropout(probability=lost))
    return building.robot(
        sensors={
            "encoder": am.MountedSensor(sensor=building.encoder(), noise=chain, **mounted),
            "gps": sensor(am.sensors.Gps, GPS),
            "compass": sensor(am.sensors.Compass, COMPASS),
            "gyro": sensor(am.sensors.Gyro, GYRO),
        },
        estimators={"it": estimator},
        controller=lambda readings, estimate, clock: am.Twist(0.4, 0.6),
        ground=building.chain(am.noise.Diffusion(variance_per_length=1e-5)),
    )


def encoder_reads(sim):
    """Whether the encoder's reading of this step is there `(N,)`."""
    return np.isfinite(sim.frames()[0].readings["encoder"][1].measured).all(axis=1)


@pytest.mark.parametrize("filter_", [am.estimators.Ekf, am.estimators.Ukf])
def test_a_filter_is_as_sure_as_it_says_though_readings_of_the_encoder_are_lost(filter_):
    sim = am.Simulation(building.scenario(turning_robot(filter_, lost=0.3)), replicas=200)
    # What the wheels do before their first reading nobody knows; while one is lost, the estimate stands.
    chosen = encoder_reads(sim)
    sim.run(20.0)
    chosen &= encoder_reads(sim)
    frame = sim.frames()[0]
    error = (frame.true_pose - frame.estimates["it"].pose)[chosen]
    error[:, 2] = am.wrap_angle(error[:, 2])
    nees = am.analysis.nees(error, frame.estimates["it"].covariance[chosen])
    low, high = chi_squared_band(3, int(chosen.sum()), 0.999)
    assert low <= nees.mean() <= high


@pytest.mark.parametrize("filter_", [am.estimators.Ekf, am.estimators.Ukf])
def test_a_gyro_is_compared_with_wheels_that_are_read_in_the_same_steps(filter_):
    runner = am.EstimatorRunner(turning_robot(filter_), "it", dt=0.1)
    counts = 1000.0 * np.arange(40)[:, None] * (1.0, 1.02)
    for tick in range(40):
        runner.update(0.1 * tick, {"encoder": counts[tick]})
        runner.update(0.1 * tick + 0.05, {"gyro": [0.6]})
    assert runner.beliefs["gyro_bias"] == 0.0
    for tick in range(40, 60):
        runner.update(0.1 * tick, {"encoder": counts[39], "gyro": [0.2]})
    assert runner.beliefs["gyro_bias"] == pytest.approx(0.2, abs=0.01)


@pytest.mark.parametrize("filter_", [am.estimators.Ekf, am.estimators.Ukf])
def test_a_gyro_is_not_compared_with_a_turn_of_two_steps(filter_):
    runner = am.EstimatorRunner(turning_robot(filter_), "it", dt=0.1)
    compared = []
    for tick in range(8):
        counts = [np.nan] * 2 if tick == 4 else 1000.0 * tick * np.array((1.0, 1.02))
        runner.update(0.1 * tick, {"encoder": counts, "gyro": [0.1]})
        compared.append(bool(np.isfinite(runner.beliefs["gyro_nis"])))
    # Not at the start; not while a reading of the wheels is lost; nor with the next, which shows two steps.
    assert compared == [False, True, True, True, False, False, True, True]


@pytest.mark.parametrize("name", sorted(set(MAKERS) - {"dead_reckoning"}))
def test_a_late_encoder_is_refused_unless_an_age_is_allowed(name):
    def simulated(**fields):
        given = scenario(name)
        robot = given.robots[0]
        encoder = attrs.evolve(robot.sensors["encoder"], latency=0.2)
        robot = attrs.evolve(
            robot,
            sensors={**robot.sensors, "encoder": encoder},
            estimators={"it": attrs.evolve(robot.estimators["it"], **fields)},
        )
        am.Simulation(attrs.evolve(given, robots=[robot])).run(0.5)

    with pytest.raises(am.ComponentError, match=r"the reading of 'encoder' was 0\.2 s old when it arrived, and the "):
        simulated()
    simulated(age_max=0.2)


@pytest.mark.parametrize("shape", [(1, 1), (1, 3), (2,)])
def test_angles_of_other_joints_than_the_drives_are_refused(shape):
    """Of an encoder of somebody's own, before a kernel reads beyond them."""

    class Odd(am.sensors.Encoder):
        def angles(self, values):
            return np.zeros(shape)

    robot = scenario("dead_reckoning").robots[0]
    odd = Odd(counts_per_revolution=100.0)
    changed = attrs.evolve(robot, sensors=dict(robot.sensors) | {"encoder": odd})
    with pytest.raises(am.ComponentError, match=r"sensor 'encoder' \(Odd\): expected .* \(1, 2\) \[rad\], got one of"):
        am.Simulation(attrs.evolve(scenario("dead_reckoning"), robots=[changed]))


def rated(name, encoder, laser):
    """A scenario whose encoder and laser have rates [Hz]."""
    given = scenario(name)
    robot = given.robots[0]
    mounted = am.MountedSensor(sensor=building.encoder(), rate=encoder)
    sensors = {**robot.sensors, "encoder": mounted, "laser": attrs.evolve(robot.sensors["laser"], rate=laser)}
    return attrs.evolve(given, robots=[attrs.evolve(robot, sensors=sensors)])


@pytest.mark.parametrize("name", ["monte_carlo", "grid_mapping", "grid_slam"])
@pytest.mark.parametrize(("encoder", "laser"), [(2.0, None), (2.0, 4.0), (3.0, 2.0)])
def test_a_laser_that_reads_when_the_encoder_does_not_is_refused(name, encoder, laser):
    """Its scan would be laid where the robot was."""
    with pytest.raises(
        am.ComponentError, match=f"that one reads at {encoder:g} Hz and 'laser' at {laser or 10:g} Hz; "
    ):
        am.Simulation(rated(name, encoder, laser))


def fleet(name, rates):
    """A scenario of robots that differ in name and place, and whose encoders have these rates [Hz]."""
    given = rated(name, None, None)
    robot, robots = given.robots[0], []
    for i, (called, rate) in enumerate(rates.items()):
        sensors = {**robot.sensors, "encoder": attrs.evolve(robot.sensors["encoder"], rate=rate)}
        pose = attrs.evolve(robot.pose, y=robot.pose.y + 0.7 * i)
        robots.append(attrs.evolve(robot, name=called, pose=pose, sensors=sensors))
    return attrs.evolve(given, robots=robots)


@pytest.mark.parametrize("names", ["ab", "ba"])
@pytest.mark.parametrize("name", ["ekf", "scan_matching", "monte_carlo", "grid_mapping", "grid_slam"])
def test_an_encoder_that_is_too_slow_is_refused_whatever_robots_are_called(name, names):
    with pytest.raises(am.ComponentError, match=r"reads at 2 Hz"):
        am.Simulation(fleet(name, dict(zip(names, (None, 2.0), strict=True))))


@pytest.mark.parametrize("replica", [0, 1])
def test_an_encoder_that_is_slowed_in_one_replica_is_refused_in_the_next_episode(replica):
    sim = am.Simulation(rated("grid_mapping", 10.0, None), replicas=2)
    sim.set(sim.names[0], "sensors.encoder.rate", 2.0, replica=replica)
    with pytest.raises(am.ComponentError, match=rf"2 Hz and 'laser' at 10 Hz on robot '{sim.names[0]}'; give"):
        sim.reset()


@pytest.mark.parametrize("name", ["monte_carlo", "grid_mapping", "grid_slam"])
@pytest.mark.parametrize(("encoder", "laser"), [(2.0, 2.0), (3.0, 1.0), (None, 3.0), (10.0, None)])
def test_a_laser_that_reads_only_when_the_encoder_does_is_allowed(name, encoder, laser):
    sim = am.Simulation(rated(name, encoder, laser))
    for _ in range(20):
        sim.step()
        readings = sim.frames()[0].readings
        assert readings["encoder"][1].fresh[0, 0] or not readings["laser"][1].fresh[0, 0]
