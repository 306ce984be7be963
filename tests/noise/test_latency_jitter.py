"""Arrivals that jitter: their distribution, their order, and what a robot learns of them."""

import math

import numpy as np
import pytest
from scipy.special import ndtr

import amorsim as am
from amorsim.noise import LatencyJitter
from tests import building
from tests.noise.sampling import ROWS, Samples, assert_distributed, assert_moments, assert_uncorrelated


def delays(noise, count=4, rows=ROWS):
    samples = Samples(noise, rows=rows)
    found = []
    for _ in range(count):
        found.append(samples.noise.delay(np.full((rows, 1), 0.1), samples.state, samples.draws))
        samples.counter[:, 2] += 1
        samples.draws.rewind()
    return np.array(found)[:, :, 0]


def test_uniform_delays_are_uniform_and_independent():
    found = delays(LatencyJitter(spread=0.2))
    assert_distributed(found, lambda x: 0.5 + x / 0.4)
    assert_moments(found, 0.2 / math.sqrt(3.0), kurtosis=1.8)
    assert_uncorrelated(*found)
    assert np.abs(found).max() <= 0.2


def test_normal_delays_are_normal_and_independent():
    found = delays(LatencyJitter(spread=0.2, distribution="normal"))
    assert_distributed(found, lambda x: ndtr(x / 0.2))
    assert_moments(found, 0.2)
    assert_uncorrelated(*found)
    assert np.abs(found).max() <= 1.0


def arrivals(steps, *noise, latency=0.25, rate=None, dt=0.1, replicas=1, seed=3):
    """A gyro on a robot that turns by one more rad/s each step: the readings at every step, `(steps, replicas)`."""
    sensors = {
        "gyro": am.MountedSensor(sensor=am.sensors.Gyro(), latency=latency, rate=rate, noise=building.chain(*noise))
    }
    robot = building.robot(sensors=sensors, estimators={}, pose=am.Pose())
    sim = am.Simulation(building.scenario(robot, map=building.empty(), dt=dt, seed=seed), replicas=replicas)
    found = []
    for tick in range(1, steps + 1):
        for replica in range(replicas):
            sim.robot("rover", replica).drive(turn=float(tick))
        sim.step()
        reading = sim.readings["gyro"]
        found.append([np.array(part)[:, 0] for part in reading])
    true, measured, stamp, age, fresh = np.array(found).swapaxes(0, 1)
    return true, measured, stamp.astype(int), age, fresh.astype(bool)


@pytest.mark.parametrize("distribution", ["uniform", "normal"])
def test_no_jitter_is_the_latency_alone(distribution):
    plain = arrivals(12)
    jittered = arrivals(12, LatencyJitter(spread=0.0, distribution=distribution))
    for one, other in zip(plain, jittered, strict=True):
        assert one.tobytes() == other.tobytes()


def test_readings_keep_their_order_and_say_of_when_they_are():
    true, measured, stamp, age, fresh = arrivals(60, LatencyJitter(spread=0.4), latency=0.3, replicas=50)
    ticks = np.arange(1, 61)[:, None]
    assert (np.diff(stamp, axis=0) >= 0).all()
    assert (stamp <= ticks).all()
    assert age == pytest.approx((ticks - stamp) * 0.1)
    # The robot turns by the tick's number: the values are of the stamp.
    assert true == pytest.approx(stamp)
    assert (measured == true).all()
    moved = np.diff(stamp, axis=0) > 0
    assert (fresh[1:][moved]).all()
    assert not fresh[1:][~moved & (stamp[1:] > 0)].any()
    # Latency and jitter together span 0 to 0.7 s: seven steps at most, once the first can have come.
    assert (ticks - stamp)[7:].max() <= 7
    assert set(np.unique((ticks - stamp)[10:])) >= {0, 1, 2, 3}


@pytest.mark.long
def test_ages_are_distributed_as_the_newest_of_those_that_have_arrived():
    """As nothing overtakes, a sample has come when all samples up to it have.

    The chance that the reading held is of j steps ago or newer is the product of F(i dt) over all i >= j, with F the
    distribution of the latency: here uniform from 0.05 to 0.45 s.
    """
    replicas = 1500
    _, _, stamp, _, _ = arrivals(12, LatencyJitter(spread=0.2), latency=0.25, replicas=replicas)
    late = 12 - stamp[-1]
    for j in range(6):
        chance = math.prod(min(max((i * 0.1 - 0.05) / 0.4, 0.0), 1.0) for i in range(j, 12))
        bound = 5.0 * math.sqrt(chance * (1.0 - chance) / replicas)
        assert abs((late <= j).mean() - chance) <= bound, j


def test_readings_of_a_rate_jitter_too():
    _, _, stamp, _, _ = arrivals(40, LatencyJitter(spread=0.2), latency=0.2, rate=5.0, replicas=20)
    assert set(np.unique(stamp % 2)) == {0}
    assert (np.diff(stamp, axis=0) >= 0).all()


def test_a_jitter_leaves_the_draws_of_others_and_replicas_keep_their_bits():
    walk = am.noise.BiasRandomWalk(std=0.1)
    _, measured, stamp, _, _ = arrivals(30, walk, LatencyJitter(spread=0.3), latency=0.3, replicas=3)
    true, plain, _, _, _ = arrivals(30, walk, latency=0.0, replicas=3)
    error = plain - true
    for i in range(30):
        for replica in range(3):
            at = stamp[i, replica]
            if at > 0:
                assert measured[i, replica] - at == pytest.approx(error[at - 1, replica], abs=1e-12)


def test_a_snapshot_in_the_middle_goes_on_alike():
    sensors = building.all_sensors()
    jitter = building.chain(LatencyJitter(spread=0.3, distribution="normal"))
    sensors["laser"] = am.MountedSensor(sensor=am.sensors.Laser(beams=19), latency=0.2, rate=4.0, noise=jitter)
    robot = building.robot(sensors=sensors, controller=building.Roam())
    sim = am.Simulation(building.scenario(robot), replicas=3)
    sim.run(1.0)
    middle = sim.snapshot()
    sim.run(1.0)
    end = [sim.digest(replica) for replica in range(3)]
    sim.restore(middle)
    sim.run(1.0)
    assert [sim.digest(replica) for replica in range(3)] == end
    alone = am.Simulation(building.scenario(robot), replicas=[2])
    alone.run(2.0)
    assert alone.digest(2) == end[2]


def test_the_spread_is_fixed_once_a_simulation_is_made():
    sensors = {"gyro": am.MountedSensor(sensor=am.sensors.Gyro(), noise=(LatencyJitter(spread=0.1),))}
    sim = am.Simulation(building.scenario(building.robot(sensors=sensors, estimators={})))
    with pytest.raises(am.AmorsimError, match="'spread' of LatencyJitter is fixed once a simulation is made"):
        sim.set("rover", "sensors.gyro.noise.latencyjitter.spread", 0.2)
