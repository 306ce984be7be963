"""An estimator runs without the simulator, and gives the same bits."""

import attrs
import numpy as np
import pytest

import amorsim as am
from tests.estimators.test_ekf_consistency import FUSIONS, scenario


def rover(**changes):
    return attrs.evolve(am.load("landmarks").robots[0], **changes)


def updates(sim, estimator, seed=1, replica=0):
    """What a runner says in each step that is fed with what a simulated robot received, and what the robot said."""
    robot = sim.scenario.robots[0]
    runner = am.EstimatorRunner(robot, estimator, dt=sim.dt, seed=seed, replica=replica)
    for step in range(40):
        if step:
            sim.step()
        frame = sim.frames()[0]
        readings = {name: reading for name, (_, reading) in frame.readings.items() if reading.fresh[0, 0]}
        estimate = runner.update(
            100.0 + frame.time[0],
            {name: reading.measured[0] for name, reading in readings.items()},
            frame.command[0],
            {name: reading.age[0, 0] for name, reading in readings.items()},
        )
        yield estimate, runner.beliefs, frame


@pytest.mark.parametrize("fusion", FUSIONS)
def test_it_gives_the_bits_of_the_simulation(fusion):
    sim = am.Simulation(scenario(FUSIONS[fusion]))
    for estimate, beliefs, frame in updates(sim, "ekf"):
        assert estimate.pose.tobytes() == frame.estimates["ekf"].pose[0].tobytes()
        assert estimate.covariance.tobytes() == frame.estimates["ekf"].covariance[0].tobytes()
        for name, array in frame.beliefs["ekf"].items():
            assert beliefs[name].tobytes() == array[0].tobytes(), name
    assert frame.true_pose[0, 0] > 3.5


def test_sensors_with_rates_and_latencies_and_random_numbers_too():
    @attrs.frozen(kw_only=True)
    class Listener(am.Estimator):
        """All that an estimator is given, as beliefs."""

        def start(self, context):
            return {"all": np.zeros((context.rows, 8))}

        def update(self, robot, readings, command, elapsed, state, draws):
            reading = readings["compass"]
            stamp, fresh = reading.stamp.astype(float), reading.fresh.astype(float)
            parts = (elapsed, command, reading.measured, reading.age, stamp, fresh, draws.normal(1))
            state["all"] = np.concatenate(parts, axis=1)
            return am.Estimate(np.zeros((robot.rows, 3)), np.zeros((robot.rows, 3, 3)))

        def beliefs(self, state):
            return {"all": state["all"].copy()}

    given = am.load("landmarks")
    robot = given.robots[0]
    compass = attrs.evolve(robot.sensors["compass"], rate=4.0, latency=0.2)
    robot = attrs.evolve(robot, sensors={**robot.sensors, "compass": compass}, estimators={"listener": Listener()})
    sim = am.Simulation(attrs.evolve(given, robots=[robot]), seed=7, replicas=[3])
    ages = set()
    for step, (_, beliefs, frame) in enumerate(updates(sim, "listener", seed=7, replica=3)):
        if step >= 3:  # until the first sample arrives, the simulation holds one of its own
            np.testing.assert_array_equal(beliefs["all"], frame.beliefs["listener"]["all"][0])
            ages.add(float(beliefs["all"][4]))
    assert len(ages) > 2


def test_updates_may_come_at_any_times():
    robot = rover(estimators={"wheels": am.estimators.DeadReckoning(wheel_variance=1e-5)})
    counts = robot.sensors["encoder"].sensor.counts_per_revolution
    turned = counts / (2.0 * np.pi) / robot.drive.wheel_radius_left  # counts in a metre
    runner = am.EstimatorRunner(robot, robot.estimators["wheels"])
    for time in (5.0, 5.013, 5.4, 7.0):
        estimate = runner.update(time, {"encoder": [turned * (time - 5.0)] * 2})
    np.testing.assert_allclose(estimate.pose, [2.8 + 2.0, 3.0, 0.0], atol=1e-9)


@pytest.mark.parametrize(
    ("update", "problem"),
    [
        ((1.0, {}), "expected a time after 1 s"),
        ((0.5, {}), "sort the log"),
        ((np.nan, {}), "expected a time in seconds, got nan"),
        ((1.1, {"encodr": [0.0, 0.0]}), "no sensor 'encodr'.*'encoder'"),
        ((1.1, {"encoder": [0.0]}), "expected 2 numbers as a reading of 'encoder', got 1"),
        ((1.1, {"encoder": "no"}), "expected 2 numbers"),
        ((1.1, {"encoder": ["1", "2"]}), r"expected 2 numbers as a reading of 'encoder', got \['1', '2'\]"),
        ((1.1, {"encoder": [None, 1.0]}), r"expected 2 numbers as a reading of 'encoder', got \[None, 1.0\]"),
        ((1.1, {"encoder": [10**400, 1]}), "expected 2 numbers as a reading of 'encoder', got"),
        ((1.1, {"encoder": [1.0 + 2.0j, 0.0]}), "expected 2 numbers as a reading of 'encoder', got"),
        ((1.1, None), "expected readings by sensor, such as {'encoder': .*}, got None"),
        ((1.1, ["encoder"]), "expected readings by sensor"),
        ((1.1, {}, None, 0.2), "expected ages by sensor, .*, got 0.2"),
        ((1.1, {}, None, {"compass": 0.1}), "an age of 'compass', but no reading of it"),
        ((1.1, {}, [1.0]), "expected 2 numbers as the command, got 1"),
        ((1.1, {"compass": [0.0]}, None, {"compass": -1.0}), "an age >= 0 s of 'compass'"),
    ],
)
def test_bad_logs_are_refused(update, problem):
    runner = am.EstimatorRunner(rover(), "wheels")
    runner.update(1.0, {"encoder": [0.0, 0.0]})
    with pytest.raises(am.AmorsimError, match=problem):
        runner.update(*update)


@pytest.mark.parametrize("wrong", [{"encoder": [0.0]}, {"encoder": [0.0, 0.0], "compass": [0.0, 1.0]}])
def test_after_an_entry_that_was_refused_it_takes_the_right_one(wrong):
    runner, other = (am.EstimatorRunner(rover(), "wheels") for _ in range(2))
    for one in (runner, other):
        one.update(1.0, {"encoder": [0.0, 0.0]})
    right = {"encoder": [500.0, 400.0]}
    for entry in ((1.5, wrong), (1.5, right, [1.0]), (1.5, right, None, {"encoder": -1.0})):
        with pytest.raises(am.AmorsimError):
            runner.update(*entry)
    estimate, wanted = runner.update(1.2, right), other.update(1.2, right)
    assert estimate.pose.tobytes() == wanted.pose.tobytes()
    assert estimate.covariance.tobytes() == wanted.covariance.tobytes()


def test_what_cannot_be_run_is_refused():
    with pytest.raises(am.AmorsimError, match=r"has no estimator 'ekff'.*'ekf'"):
        am.EstimatorRunner(rover(), "ekff")
    with pytest.raises(am.AmorsimError, match="give the robot one"):
        am.EstimatorRunner(rover(pose=None), "ekf")
    with pytest.raises(am.AmorsimError, match="dt: expected"):
        am.EstimatorRunner(rover(), "ekf", dt=0.0)


def test_a_drive_that_answers_wrongly_is_said():
    @attrs.frozen(kw_only=True)
    class Flat(am.drives.Differential):
        def twist(self, before, after):
            return np.zeros((len(before), 2))

    given = attrs.asdict(rover().drive, recurse=False)
    with pytest.raises(am.ComponentError, match=r"drive \(Flat\) of robot 'rover' .* \(1, 3\) from twist\(\), got"):
        am.EstimatorRunner(rover(drive=Flat(**given)), "ekf")
