"""What holds for every noise model: nothing leaves every bit, draws depend on nothing else, rows stay separate."""

import math

import numpy as np
import pytest

import amorsim as am
from amorsim.noise import (
    AngleRandomWalk,
    BeamModel,
    BiasInstability,
    BiasRandomWalk,
    CompassDeviation,
    Dropout,
    NoiseFloor,
    OdometryModel,
    Outliers,
    Slip,
    SpecularLoss,
    Stuck,
    VelocityModel,
)
from amorsim.testing import check_component
from tests import building
from tests.noise.sampling import ROWS, Samples, assert_uncorrelated

# Each with no effect, and with one that draws have a part in or that distinguishes values.
NOTHING = {
    "dropout": Dropout(probability=0.0),
    "dropout_last": Dropout(probability=0.0, report="last"),
    "dropout_value": Dropout(probability=0.0, report="value", value=1.0),
    "outliers": Outliers(probability=0.0, std=1.0),
    "outliers_of_nothing": Outliers(probability=0.7, std=0.0),
    "noise_floor": NoiseFloor(level=0.0),
    "stuck": Stuck(rate=0.0, duration=1.0),
    "angle_random_walk": AngleRandomWalk(density=0.0),
    "bias_random_walk": BiasRandomWalk(std=0.0),
    "bias_instability": BiasInstability(std=0.0, correlation_time=1.0),
    "compass_deviation": CompassDeviation(),
    "beam_model": BeamModel(range_max=5.0),
    "specular_loss": SpecularLoss(critical=math.pi / 2.0),
}
GROUND = {
    "velocity_model": VelocityModel(),
    "velocity_model_interval": VelocityModel(interval=0.1),
    "odometry_model": OdometryModel(),
    "slip": Slip(at=0.1, duration=1.0, factor=1.0),
    "slip_of_no_time": Slip(at=0.1, duration=0.0, factor=0.0),
}
SOMETHING = {
    "dropout": Dropout(probability=0.3, report="value", value=-1.0),
    "noise_floor": NoiseFloor(level=20.0),
    "outliers": Outliers(probability=0.3, std=1.0),
    "angle_random_walk": AngleRandomWalk(density=0.1),
    "bias_random_walk": BiasRandomWalk(std=0.2),
    "bias_instability": BiasInstability(std=0.2, correlation_time=0.4),
    "stuck": Stuck(rate=3.0, duration=0.3),
}
WHEELS = {
    "velocity_model": VelocityModel(a1=0.1, a2=0.1, a3=0.1, a4=0.1, a5=0.1, a6=0.1),
    "odometry_model": OdometryModel(a1=0.1, a2=0.1, a3=0.1, a4=0.1, interval=0.2),
    "slip": Slip(at=0.15, duration=0.2, factor=0.5, joint="right_wheel"),
}


@pytest.mark.parametrize("name", NOTHING)
def test_a_model_of_nothing_leaves_every_bit(name):
    samples = Samples(NOTHING[name], rows=2)
    values = np.array([[0.0, -0.0, 1.0 / 3.0, -1e-300], [math.inf, 1e300, -2.5, 7.0]])
    for _ in range(4):
        assert samples.take(values, side={"incidence": math.pi / 2.0}).tobytes() == values.tobytes()


@pytest.mark.parametrize("name", GROUND)
def test_a_ground_of_nothing_leaves_every_bit(name):
    samples = Samples(GROUND[name], rows=3, k=2)
    values = np.array([[0.0, -0.0], [1.0 / 3.0, -1e-300], [-2.5, 7.0]])
    for _ in range(4):
        assert samples.ground(values, 0.1).tobytes() == values.tobytes()


@pytest.mark.parametrize("name", [*SOMETHING, *WHEELS])
def test_the_same_draws_are_taken_whatever_the_values_and_the_time(name):
    """How many numbers an element uses in a tick depends on nothing that it is given."""
    taken = set()
    is_ground = name in WHEELS
    for value in (0.0, 2.0, -3.0) if is_ground else (0.0, 2.0, math.inf):
        for elapsed in (0.01, 1.0):
            samples = Samples({**SOMETHING, **WHEELS}[name], rows=3, k=2)
            for _ in range(3):
                samples.ground(value, elapsed) if is_ground else samples.take(value, elapsed)
                samples.draws.rewind()
                passed = np.full((3, 1), elapsed)
                samples.noise.corrupt(np.full((3, 2), value), {}, passed, samples.state, samples.draws)
                taken.add(samples.draws._block)
                samples.draws.rewind()
    assert len(taken) == 1


@pytest.mark.parametrize("name", SOMETHING)
def test_errors_of_rows_values_ticks_and_elements_are_uncorrelated(name):
    def errors(called):
        samples = Samples(SOMETHING[name], rows=ROWS, name=called)
        series = [samples.take(10.0 + tick, elapsed=0.2) - (10.0 + tick) for tick in range(4)]
        # Of what accumulates or lasts, what is new is what it does in other rows, values and elements.
        return series[-1], series

    first, series = errors("one")
    second, _ = errors("two")
    assert_uncorrelated(first, second)
    assert_uncorrelated(*first.T)
    assert_uncorrelated(first[: ROWS // 2], first[ROWS // 2 :])
    assert_uncorrelated(first[:-1], first[1:])
    if name in ("dropout", "noise_floor", "outliers", "angle_random_walk"):
        assert_uncorrelated(*series[1:])


def test_elements_of_a_chain_switched_off_leave_the_draws_of_the_others():
    """The errors of two models together are the sum of what each does alone, for each has its own numbers."""

    def error(*noise):
        unit = am.MountedSensor(sensor=am.sensors.Gyro(), noise=building.chain(*noise))
        robot = building.robot(sensors={"encoder": building.encoder(), "gyro": unit})
        sim = am.Simulation(building.scenario(robot), replicas=3)
        found = []
        for _ in range(6):
            sim.step()
            reading = sim.readings["gyro"]
            found.append(reading.measured - reading.true)
        return np.array(found)

    white, walk = AngleRandomWalk(density=0.1), BiasInstability(std=0.3, correlation_time=2.0)
    far = Outliers(probability=0.5, std=2.0)
    alone = error(white) + error(walk) + error(far)
    np.testing.assert_allclose(error(white, walk, far), alone, rtol=1e-12, atol=1e-14)
    np.testing.assert_allclose(error(far, white, walk), alone, rtol=1e-12, atol=1e-14)
    assert np.abs(alone).min() > 0.0
    off = error(white, Outliers(probability=0.0, std=2.0), walk)
    np.testing.assert_allclose(off, error(white) + error(walk), rtol=1e-12, atol=1e-14)


def test_switching_wheel_noise_on_leaves_a_sensors_errors():
    def error(*ground):
        unit = am.MountedSensor(sensor=am.sensors.Gyro(), noise=building.chain(AngleRandomWalk(density=0.1)))
        robot = building.robot(sensors={"encoder": building.encoder(), "gyro": unit}, ground=building.chain(*ground))
        sim = am.Simulation(building.scenario(robot))
        sim.robot("rover").drive(forward=0.3, turn=0.2)
        sim.run(0.5)
        reading = sim.readings["gyro"]
        return reading.measured - reading.true, sim.true_pose

    quiet, pose = error()
    noisy, other = error(VelocityModel(a1=0.01, a3=0.1))
    assert np.abs(pose - other).max() > 1e-4
    np.testing.assert_allclose(noisy, quiet, rtol=1e-12)


@pytest.mark.parametrize("name", [*SOMETHING, "compass_deviation", "specular_loss"])
def test_a_model_in_play_keeps_its_contract(name):
    played = SOMETHING | {
        "compass_deviation": CompassDeviation(a=0.01, b=0.1, c=0.1, d=0.05, e=0.05),
        "specular_loss": SpecularLoss(critical=0.45),
    }
    changes_inf = name in ("dropout", "stuck")
    check_component(played[name], inf="changed" if changes_inf else "kept", side={"incidence": 0.45})


@pytest.mark.parametrize("name", WHEELS)
def test_a_wheel_model_in_play_keeps_its_contract(name):
    check_component(WHEELS[name], values_of="encoder", inf="absent")


def test_a_scenario_runs_again_from_a_snapshot_with_all_models():
    """In the middle of faults, drifts and slips, bit for bit; and replica 2 of 3 is replica 2 alone."""
    chain = building.chain(*SOMETHING.values())
    robot = building.robot(
        sensors={
            "encoder": building.encoder(),
            "gyro": am.MountedSensor(sensor=am.sensors.Gyro(), noise=chain),
            "laser": am.MountedSensor(
                sensor=am.sensors.Laser(beams=19),
                rate=4.0,
                noise=building.chain(
                    am.noise.MotionDistortion(sweep=0.05),
                    SpecularLoss(critical=1.0),
                    BeamModel(hit=0.7, short=0.1, max=0.1, random=0.1, std=0.02, range_max=8.0),
                ),
            ),
        },
        ground=building.chain(*WHEELS.values()),
        controller=building.Roam(),
    )
    scenario = building.scenario(robot)
    sim = am.Simulation(scenario, replicas=3)
    sim.run(0.7)
    middle = sim.snapshot()
    sim.run(0.7)
    end = [sim.digest(replica) for replica in range(3)]
    sim.restore(middle)
    sim.run(0.7)
    assert [sim.digest(replica) for replica in range(3)] == end
    alone = am.Simulation(scenario, replicas=[2])
    alone.run(1.4)
    assert alone.digest(2) == end[2] != end[1]
