"""The extended Kalman filter is as wrong as it says: errors over replicas against the covariance that it reports.

Over M replicas the mean of the normalised error squared (NEES) has the chi-squared distribution with 3 M degrees of
freedom, over M; that of n normalised innovations squared (NIS) of d numbers has it with d n, over n. Bands hold 99.9 %.
"""

from __future__ import annotations

import math

import attrs
import numpy as np
import pytest
from scipy.stats import chi2

import amorsim as am
from amorsim.scenario.initial_belief import InitialBelief
from amorsim.sensors import Compass, Gps, Gyro

TIMES = (20.0, 50.0, 90.0)  # [s]
FAR_OFF = (0.1, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0)
WHEELS = 1e-5  # [m]
GPS, COMPASS, GYRO, BIAS, WALK = 0.2, 0.05, 0.02, 0.03, 0.001
LANDMARKS = {"landmarks": "fiducial", "range_std": 0.05, "bearing_std": math.radians(1.0)}
FUSIONS = {
    "landmarks": am.estimators.Ekf(wheel_variance=WHEELS, **LANDMARKS),
    "nearest": am.estimators.Ekf(wheel_variance=WHEELS, association="nearest", **LANDMARKS),
    "command": am.estimators.Ekf(wheel_variance=WHEELS, prediction="command", **LANDMARKS),
    "gps, compass and gyro": am.estimators.Ekf(
        wheel_variance=WHEELS,
        gps="gps",
        gps_std=GPS,
        compass="compass",
        compass_std=COMPASS,
        gyro="gyro",
        gyro_std=GYRO,
        gyro_bias_std=BIAS,
        gyro_bias_walk=WALK,
    ),
}


@attrs.frozen(kw_only=True)
class DrawnBias(am.Noise):
    """A bias that each replica draws at its first sample."""

    std: float = am.parameter(ge=0, help="standard deviation")

    def start(self, context):
        return {"bias": np.zeros((context.rows, context.size))}

    def corrupt(self, values, side, elapsed, state, draws):
        drawn = draws.normal(values.shape[1]) * self.std
        state["bias"] = np.where(elapsed > 0.0, state["bias"], drawn)
        return values + state["bias"]


def band(freedom, count):
    """The mean of `count` chi-squared numbers lies between these with a probability of 99.9 %."""
    return chi2.ppf([0.0005, 0.9995], freedom * count) / count


def scenario(estimator):
    """The bundled scenario, with the sensors that an estimator corrects by and their noise as it assumes it."""
    found = am.load("landmarks")
    rover = found.robots[0]
    sensors = {name: rover.sensors[name] for name in ("encoder", "fiducial")}
    if estimator.gps:
        noise = {
            "gps": (Gps(), am.noise.Gaussian(std=GPS)),
            "compass": (Compass(), am.noise.Gaussian(std=COMPASS)),
            "gyro": (Gyro(), am.noise.Gaussian(std=GYRO), DrawnBias(std=BIAS), am.noise.BiasRandomWalk(std=WALK)),
        }
        sensors = {"encoder": sensors["encoder"]} | {
            name: am.MountedSensor(
                sensor=sensor,
                mount=am.Mount(x=0.1, y=-0.05),
                noise=tuple(am.NoiseElement(name=f"n{i}", noise=one) for i, one in enumerate(chain)),
            )
            for name, (sensor, *chain) in noise.items()
        }
    rover = attrs.evolve(rover, sensors=sensors, estimators={"ekf": estimator})
    return attrs.evolve(found, robots=[rover])


def with_noise(estimator, factor):
    """The estimator that assumes `factor` times the standard deviation of each measurement."""
    fields = ("range_std", "bearing_std", "gps_std", "compass_std", "gyro_std")
    stated = {name: getattr(estimator, name) for name in fields}
    return attrs.evolve(estimator, **{name: std * factor for name, std in stated.items() if std is not None})


def consistency(estimator, replicas, times):
    """At each time: the mean NEES, and by sensor the mean NIS, how many there are, and of how many numbers each is."""
    return consistency_of(scenario(estimator), replicas, times)


def consistency_of(given, replicas, times):
    """The same, of the first estimator of a scenario."""
    sim = am.Simulation(given, replicas=replicas)
    found = []
    for time in times:
        sim.run(time - sim.time)
        frame = sim.frames()[0]
        estimate, beliefs = frame.estimates["ekf"], frame.beliefs["ekf"]
        error = frame.true_pose - estimate.pose
        error[:, 2] = am.wrap_angle(error[:, 2])
        nees = np.einsum("ni,ni->n", error, np.linalg.solve(estimate.covariance, error[:, :, None])[:, :, 0])
        nis = {}
        for name, values in beliefs.items():
            if name.endswith("_nis"):
                values = values[np.isfinite(values)]
                nis[name] = values.mean(), len(values), 1 if name.startswith(("compass", "gyro")) else 2
        found.append((nees.mean(), nis))
    assert not sim.events
    return found


def check_consistency(estimator, replicas, times):
    low, high = band(3, replicas)
    for time, (nees, nis) in zip(times, consistency(estimator, replicas, times), strict=True):
        assert low <= nees <= high, time
        assert nis
        for name, (mean, count, freedom) in nis.items():
            assert count >= replicas
            low_nis, high_nis = band(freedom, count)
            assert low_nis <= mean <= high_nis, (name, time)


def test_the_band_is_the_published_one():
    np.testing.assert_allclose(band(3, 1000), [2.752, 3.261], atol=5e-4)


def test_the_bundled_scenario_gives_its_filter_the_noise_there_is():
    found = am.load("landmarks")
    assert next(iter(found.robots[0].estimators.values())) == FUSIONS["landmarks"]
    ranges, bearings = (element.noise for element in found.robots[0].sensors["fiducial"].noise)
    assert (ranges.std, bearings.std) == (LANDMARKS["range_std"], LANDMARKS["bearing_std"])
    assert found.robots[0].ground[0].noise.variance_per_length == WHEELS
    assert found.duration >= 60.0


@pytest.mark.parametrize("fusion", FUSIONS)
def test_errors_are_as_large_as_it_says(fusion):
    check_consistency(FUSIONS[fusion], 100, (12.0,))


@pytest.mark.parametrize(
    "replicas", [pytest.param(300, marks=pytest.mark.long), pytest.param(1000, marks=pytest.mark.nightly)]
)
@pytest.mark.parametrize("fusion", FUSIONS)
def test_errors_are_as_large_as_it_says_at_all_times(fusion, replicas):
    check_consistency(FUSIONS[fusion], replicas, TIMES)


@pytest.mark.long
@pytest.mark.parametrize(
    "estimator",
    [FUSIONS["landmarks"], am.estimators.Ukf(wheel_variance=WHEELS, **LANDMARKS)],
    ids=["ekf", "ukf"],
)
def test_a_start_that_is_far_off_does_not_make_it_too_sure(estimator):
    """Half a metre and 20° off, of which it knows; for five seconds it sees one landmark or two."""
    found = scenario(estimator)
    belief = InitialBelief(kind="gaussian", std=0.5, heading_std=math.radians(20.0))
    found = attrs.evolve(found, robots=[attrs.evolve(found.robots[0], initial_belief=belief)])
    for time, (nees, _) in zip(FAR_OFF, consistency_of(found, 400, FAR_OFF), strict=True):
        # A covariance has no room for a banana, so that the band is not for these.
        assert 2.0 < nees < 4.0, time


# A gyro's innovations show it in a thousand replicas only.
FEW = dict.fromkeys(FUSIONS, 250) | {"gps, compass and gyro": 1000}


@pytest.mark.parametrize(
    ("fusion", "replicas"),
    [pytest.param(fusion, FEW[fusion], marks=pytest.mark.long) for fusion in FUSIONS]
    + [pytest.param(fusion, 1000, marks=pytest.mark.nightly) for fusion in FUSIONS if FEW[fusion] < 1000],
)
def test_a_filter_that_trusts_its_sensors_wrongly_leaves_the_band_on_the_right_side(fusion, replicas):
    low, high = band(3, replicas)
    for factor in (0.5, 2.0):
        for nees, nis in consistency(with_noise(FUSIONS[fusion], factor), replicas, TIMES):
            assert nees > high if factor < 1.0 else nees < low, factor
            for name, (mean, count, freedom) in nis.items():
                low_nis, high_nis = band(freedom, count)
                assert mean > high_nis if factor < 1.0 else mean < low_nis, (name, factor)


def test_a_replica_alone_and_among_others_has_the_same_bits():
    for estimator in FUSIONS.values():
        given = scenario(estimator)
        many, one = am.Simulation(given, replicas=9), am.Simulation(given, replicas=[6])
        many.run(2.0)
        one.run(2.0)
        assert many.digest(6) == one.digest(6)
        every, alone = many.frames()[0].beliefs["ekf"], one.frames()[0].beliefs["ekf"]
        for name, array in alone.items():
            assert array[0].tobytes() == every[name][6].tobytes(), name
