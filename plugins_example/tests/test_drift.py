"""The drift against the statistics of a Gauss-Markov process."""

import amorsim_example as example
import numpy as np
import pytest
from example_world import robot, simulation

import amorsim as am

STD, TAU = 0.05, 4.0
N = 2000  # replicas
# A sample variance of N normal numbers has a relative standard deviation of sqrt(2 / N); five of them.
VARIANCE = 5.0 * np.sqrt(2.0 / N)


def errors(times: list[float], *, rate: float | None, dt: float) -> dict[float, np.ndarray]:
    """The compass's errors `(N,)` [rad] at some times, of a robot that stands."""
    chain = (am.NoiseElement(name="drift", noise=example.Drift(std=STD, time_constant=TAU)),)
    compass = am.MountedSensor(sensor=am.sensors.Compass(), noise=chain, rate=rate)
    sim = simulation(robot(sensors={"compass": compass}, estimators={}), replicas=N, dt=dt)
    found = {0.0: _error(sim)}
    for time in times:
        sim.run(time - sim.time)
        found[time] = _error(sim)
    return found


def _error(sim: am.Simulation) -> np.ndarray:
    reading = sim.readings["compass"]
    return (reading.measured - reading.true)[:, 0]


@pytest.mark.parametrize(("rate", "dt"), [(None, 0.1), (None, 1.0), (0.5, 0.1)], ids=["10 Hz", "1 Hz", "0.5 Hz"])
def test_variance_and_memory_do_not_depend_on_how_often_it_is_read(rate: float | None, dt: float) -> None:
    found = errors([2.0, 4.0, 30.0], rate=rate, dt=dt)
    assert (found[0.0] == 0.0).all()
    for time in (2.0, 4.0, 30.0):
        expected = STD**2 * (1.0 - np.exp(-2.0 * time / TAU))
        assert np.var(found[time]) == pytest.approx(expected, rel=VARIANCE)
        assert abs(np.mean(found[time])) < 5.0 * np.sqrt(expected / N)
    # What is left of the error at 2 s two seconds later; the covariance of a product of two normal numbers.
    early, late = found[2.0], found[4.0]
    expected = np.exp(-2.0 / TAU) * STD**2 * (1.0 - np.exp(-4.0 / TAU))
    spread = np.sqrt((np.var(early) * np.var(late) + expected**2) / N)
    assert np.mean(early * late) == pytest.approx(expected, abs=5.0 * spread)


def test_without_a_std_it_changes_nothing() -> None:
    chain = (am.NoiseElement(name="drift", noise=example.Drift(std=0.0)),)
    compass = am.MountedSensor(sensor=am.sensors.Compass(), noise=chain)
    sim = simulation(robot(sensors={"compass": compass}, estimators={}, pose=am.Pose(heading=1.0)))
    sim.run(5.0)
    reading = sim.readings["compass"]
    assert reading.measured[0, 0] == reading.true[0, 0] == 1.0


@pytest.mark.parametrize(("field", "value"), [("std", -0.1), ("time_constant", 0.0), ("std", float("nan"))])
def test_nonsense_is_refused(field: str, value: float) -> None:
    with pytest.raises(am.ParameterError, match=field):
        example.Drift(**({"std": 0.1} | {field: value}))
