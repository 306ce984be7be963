"""Each random model over 1e5 draws and more: mean, variance, distribution, autocorrelation, all in one table.

What is special to a model stands in a file of its own; that every model which is registered stands here, or draws
nothing, is tested too.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import attrs
import numpy as np
import pytest
from scipy.special import ndtr

import amorsim as am
from amorsim import noise
from amorsim.contracts import Aim
from amorsim.plugins.manager import make_registry
from tests import building
from tests.noise.sampling import ROWS, SIGMAS, K, N, Samples, assert_distributed, assert_moments, assert_uncorrelated

SAMPLES = 6
DT = 0.1


@attrs.frozen(kw_only=True)
class Case:
    """Errors `(samples, n)` of a model, and what is known of one of them; `rho` of two, so many samples apart."""

    errors: Callable[[], np.ndarray]
    std: float
    mean: float = 0.0
    kurtosis: float = 3.0
    cumulative: Callable[[Any], Any] | None = None
    is_state: bool = False
    rho: Callable[[int], float] = lambda _: 0.0


def reading(element: am.Noise, value: float = 2.0, **side: Any) -> Callable[[], np.ndarray]:
    """Errors of a constant value, sample after sample."""

    def errors() -> np.ndarray:
        samples = Samples(element, rows=ROWS)
        return np.array([(samples.take(value, DT, side) - value).reshape(-1) for _ in range(SAMPLES + 1)])[1:]

    return errors


def steps(element: am.Noise) -> Callable[[], np.ndarray]:
    """What comes new with each sample of an error that adds up."""

    def errors() -> np.ndarray:
        samples = Samples(element, rows=ROWS)
        found = np.array([samples.take(2.0 + 0.5 * i, DT) - (2.0 + 0.5 * i) for i in range(SAMPLES + 1)])
        return np.diff(found, axis=0).reshape(SAMPLES, -1)

    return errors


def ground(element: am.Noise, of: Callable[[np.ndarray], np.ndarray], rows: int = 100_000) -> Callable[[], np.ndarray]:
    """Something of the travels of a pair of wheels that roll 3 and 5 cm in each step."""

    def errors() -> np.ndarray:
        samples = Samples(element, rows=rows, k=2)
        return np.array([of(samples.ground([0.03, 0.05], DT)).reshape(-1) for _ in range(SAMPLES)])

    return errors


def bends(element: am.Noise) -> Callable[[], np.ndarray]:
    def errors() -> np.ndarray:
        samples, found = Samples(element, rows=ROWS), []
        for _ in range(SAMPLES):
            aim = samples.noise.aim(Aim(), np.full((ROWS, 1), DT), samples.state, samples.draws)
            found.append(aim.bearing.reshape(-1))
            samples.counter[:, 2] += 1
            samples.draws.rewind()
        return np.array(found)

    return errors


def delays(element: am.Noise) -> Callable[[], np.ndarray]:
    def errors() -> np.ndarray:
        samples, found = Samples(element, rows=N), []
        for _ in range(SAMPLES):
            found.append(samples.noise.delay(np.full((N, 1), DT), samples.state, samples.draws)[:, 0])
            samples.counter[:, 2] += 1
            samples.draws.rewind()
        return np.array(found)

    return errors


def normal(std: float) -> Callable[[Any], Any]:
    return lambda x: ndtr(x / std)


def white(errors: Callable[[], np.ndarray], std: float, **others: Any) -> Case:
    return Case(errors=errors, std=std, **({"cumulative": normal(std)} | others))


def share(probability: float) -> dict[str, Any]:
    """A value that is 1 with this probability, else 0."""
    variance = probability * (1.0 - probability)
    return {
        "mean": probability,
        "std": math.sqrt(variance),
        "kurtosis": (1.0 - 3.0 * variance) / variance,
        "is_state": True,
    }


def way(travel: np.ndarray) -> np.ndarray:
    return 0.5 * (travel[:, 0] + travel[:, 1]) - 0.04


def turn(travel: np.ndarray) -> np.ndarray:
    return (travel[:, 1] - travel[:, 0] - 0.02) / building.TRACK


def lost(element: am.Noise, **side: Any) -> Callable[[], np.ndarray]:
    """Which values are not what they were, 1 or 0."""
    errors = reading(element, **side)
    return lambda: (errors() != 0.0).astype(float)


_TURN = 0.02 / building.TRACK
_VELOCITY = noise.VelocityModel(a1=0.01, a3=0.3, a4=0.02, a5=0.1)
_ODOMETRY = noise.OdometryModel(a1=0.02, a2=0.4, a3=0.01)
_MIXED = {"hit": 0.6, "short": 0.0, "max": 0.0, "random": 0.4, "std": 0.1, "range_max": 5.0}
_BUMPS = noise.Bump(height=0.01, rate=20.0)
_LOST = (
    2.0
    * building.RADIUS
    * (math.acos(1.0 - 0.01 / building.RADIUS) - math.sqrt(1.0 - (1.0 - 0.01 / building.RADIUS) ** 2))
)

CASES: dict[str, Case] = {
    "gaussian": white(reading(noise.Gaussian(std=0.2, proportional=0.05)), 0.3),
    "gaussian_increment": white(steps(noise.Gaussian(std=0.2, proportional=0.1, per="increment")), 0.25),
    "angle_random_walk": white(reading(noise.AngleRandomWalk(density=0.1)), 0.1 / math.sqrt(DT)),
    "bias_random_walk": white(steps(noise.BiasRandomWalk(std=0.3)), 0.3 * math.sqrt(DT)),
    "bias_instability": white(
        reading(noise.BiasInstability(std=0.2, correlation_time=0.4)), 0.2, rho=lambda lag: math.exp(-lag * DT / 0.4)
    ),
    "outliers": Case(
        errors=reading(noise.Outliers(probability=0.2, std=1.5)), std=1.5 * math.sqrt(0.2), kurtosis=3.0 / 0.2
    ),
    # 2 becomes anything from 0 to 4.
    "noise_floor": Case(
        errors=reading(noise.NoiseFloor(level=4.0)),
        std=4.0 / math.sqrt(12.0),
        kurtosis=1.8,
        cumulative=lambda x: 0.5 + x / 4.0,
    ),
    "dropout": Case(errors=lost(noise.Dropout(probability=0.3, report="value", value=0.0)), **share(0.3)),
    "missed": Case(
        errors=lost(noise.Missed(probability=0.1, per_metre=0.2), slot=np.arange(K), range=1.0, empty=0.0),
        **share(0.3),
    ),
    "cross_talk": Case(errors=lost(noise.CrossTalk(probability=0.3), heard=1.0), **share(0.3)),
    # A two-state chain that has run for a long time: the first sample after 50 s, the others 0.1 s apart.
    "stuck": Case(
        errors=lambda: _frozen(),
        rho=lambda lag: math.exp(-(0.8 + 2.0) * lag * DT),
        **share(0.8 * 0.5 / (1.0 + 0.8 * 0.5)),
    ),
    # A hit about 2 m, or anything from 0 to 5: moments of the mixture, about its own mean.
    "beam_model": Case(
        errors=reading(noise.BeamModel(**_MIXED)),
        mean=0.4 * 0.5,
        std=math.sqrt(0.6 * 0.1**2 + 0.4 * (25.0 / 12.0 + 0.25) - 0.2**2),
        kurtosis=3.0,
        cumulative=lambda x: 0.6 * ndtr(x / 0.1) + 0.4 * np.clip((x + 2.0) / 5.0, 0.0, 1.0),
    ),
    "aim_gaussian": white(bends(noise.AimGaussian(std=0.05)), 0.05),
    "latency_jitter": Case(
        errors=delays(noise.LatencyJitter(spread=0.3)),
        std=0.3 / math.sqrt(3.0),
        kurtosis=1.8,
        cumulative=lambda x: 0.5 + x / 0.6,
    ),
    "latency_jitter_normal": white(delays(noise.LatencyJitter(spread=0.3, distribution="normal")), 0.3),
    "diffusion": white(
        ground(noise.Diffusion(variance_per_length=1e-4), lambda travel: travel[:, 0] - 0.03), math.sqrt(1e-4 * 0.03)
    ),
    "velocity_model": white(ground(_VELOCITY, way), math.sqrt(0.01 * 0.04**2)),
    "velocity_model_turn": white(ground(_VELOCITY, turn), math.sqrt(0.4 * 0.04**2 + 0.02 * _TURN**2)),
    "odometry_model": white(ground(_ODOMETRY, way), math.sqrt(0.01 * 0.04**2)),
    "odometry_model_turn": white(ground(_ODOMETRY, turn), math.sqrt(2.0 * (0.02 * (0.5 * _TURN) ** 2 + 0.4 * 0.04**2))),
    # Bumps under the right wheel: a Poisson distribution of mean 20 / m * 0.05 m = 1.
    "bump": Case(errors=ground(_BUMPS, lambda travel: (0.05 - travel[:, 1]) / _LOST), mean=1.0, std=1.0, kurtosis=4.0),
}
DRAW_NOTHING = {
    *("bias", "compass_deviation", "motion_distortion", "quantize", "saturate", "scale", "slip", "specular_loss"),
}


def _frozen() -> np.ndarray:
    samples = Samples(noise.Stuck(rate=0.8, duration=0.5), rows=ROWS)
    samples.take(0.0)
    samples.take(0.0, elapsed=50.0)
    found = []
    for _ in range(SAMPLES):
        found.append(samples.state["frozen"].astype(float).reshape(-1))
        samples.take(0.0, elapsed=DT)
    return np.array(found)


def test_every_model_is_in_the_table_or_draws_nothing() -> None:
    known = set(make_registry(entry_points=[]).names("noise"))
    drawn = {name for name in known if any(case == name or case.startswith(f"{name}_") for case in CASES)}
    assert known == drawn | DRAW_NOTHING
    for name in DRAW_NOTHING:
        assert "draws." not in (_source(name)), name


def _source(name: str) -> str:
    import inspect

    return inspect.getsource(make_registry(entry_points=[]).get("noise", name))


@pytest.fixture(scope="module", params=list(CASES))
def drawn(request: pytest.FixtureRequest) -> tuple[Case, np.ndarray]:
    case = CASES[request.param]
    errors = case.errors()
    assert errors.shape[1] >= 100_000
    return case, errors


def test_mean_and_variance(drawn: tuple[Case, np.ndarray]) -> None:
    case, errors = drawn
    assert_moments(errors[-1], case.std, case.mean, case.kurtosis)


def test_distribution(drawn: tuple[Case, np.ndarray]) -> None:
    case, errors = drawn
    if case.cumulative is not None:
        assert_distributed(errors[-1], case.cumulative)
    elif case.is_state:  # two values, of which the mean says all
        assert set(np.unique(errors[-1])) == {0.0, 1.0}
    else:
        pytest.skip("with a value that comes often, or of whole numbers: tested in the model's own file")


def test_autocorrelation(drawn: tuple[Case, np.ndarray]) -> None:
    """Between samples so many apart: what the model says, within five standard deviations of the estimate."""
    case, errors = drawn
    first = errors[0] - errors[0].mean()
    for lag in range(1, SAMPLES):
        later = errors[lag] - errors[lag].mean()
        found = float(np.mean(first * later) / math.sqrt(np.mean(first**2) * np.mean(later**2)))
        expected = case.rho(lag)
        # Of independent pairs of normal numbers, (1 - rho^2) / sqrt(n); 1 / sqrt(n) whatever they are, if rho is 0. A
        # pair of states has at most twice that.
        spread = (1.0 - expected**2) if case.cumulative is not None or not expected else 2.0
        assert abs(found - expected) < SIGMAS * spread / math.sqrt(errors.shape[1]), lag


def test_rows_and_values_are_uncorrelated(drawn: tuple[Case, np.ndarray]) -> None:
    _, errors = drawn
    half = errors.shape[1] // 2
    assert_uncorrelated(errors[-1][:half], errors[-1][half : 2 * half])
    assert_uncorrelated(errors[-1][:-1], errors[-1][1:])
    assert_uncorrelated(errors[-1][:-K], errors[-1][K:])


# --------------------------------------------------------------------------------------- in the engine, all at once


@pytest.mark.long
def test_errors_of_robots_sensors_elements_and_ticks_are_uncorrelated() -> None:
    """Two robots with two gyros each, each with two elements of one kind: 1e5 errors of each, all pairs of them.

    Elements are distinguished by their sizes: the error is the sum of one whose values are whole numbers, and of one
    far below them.
    """
    replicas, ticks = 4000, 25
    chain = (
        am.NoiseElement(name="coarse", noise=noise.Outliers(probability=0.5, std=1e6)),
        am.NoiseElement(name="round", noise=noise.Quantize(step=1e3)),
        am.NoiseElement(name="fine", noise=noise.Gaussian(std=1.0)),
    )
    robots = [
        building.robot(
            name=name,
            sensors={gyro: am.MountedSensor(sensor=am.sensors.Gyro(), noise=chain) for gyro in ("one", "two")},
            estimators={},
            pose=am.Pose(x=x, y=2.0),
        )
        for name, x in (("a", 1.5), ("b", 4.0))
    ]
    sim = am.Simulation(building.scenario(*robots), replicas=replicas)
    found = []
    for _ in range(ticks):
        sim.step()
        for gyro in ("one", "two"):
            error = sim.readings[gyro].measured.reshape(replicas, 2)
            coarse = 1e3 * np.round(error / 1e3)
            found.append(np.stack((coarse, error - coarse)))
    # (ticks, gyro, element, replica, robot) to one long series for each robot, gyro and element
    table = np.array(found).reshape(ticks, 2, 2, replicas, 2).transpose(4, 1, 2, 0, 3).reshape(8, ticks, replicas)
    series = list(table.reshape(8, -1))
    assert_uncorrelated(*series)
    for one in table:
        assert_uncorrelated(one[:-1], one[1:])
    # Each with the next sample of all others.
    for i in range(8):
        assert_uncorrelated(table[i, :-1], *(table[j, 1:] for j in range(8) if j != i))
