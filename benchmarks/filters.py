"""Filters: Monte Carlo localization and the extended Kalman filter against what a user of NumPy would run."""

from __future__ import annotations

import importlib.util
import math
from collections.abc import Callable
from typing import Any

import attrs
import numpy as np
import numpy.typing as npt

import amorsim as am
from amorsim.sensors import Encoder, Fiducial, Laser
from benchmarks.contest import Clock
from benchmarks.results import Ratio, Row, ratio_of

__all__ = ["measure"]

Array = npt.NDArray[np.float64]
Step = Callable[[], Any]

SECTION = "filters"
PARTICLES, BEAMS = 2000, 60
REPLICAS, MARKS = 1000, 8
_STD, _RANDOM, _REACH, _FIELD = 0.2, 0.5, 8.0, 0.05
_TURNS = np.array([0.02, 0.025])  # [rad] of the wheels in a step


def measure(rounds: int, quick: bool, clock: Clock, say: Callable[[str], None]) -> list[Row]:
    """The rows: updates a second of each filter, side by side in each round."""
    clouds = {
        "amorsim": _ours_cloud(),
        "NumPy, a particle at a time": _loop(),
        "NumPy, all particles at once": _vector(),
    }
    if importlib.util.find_spec("particles") is not None:
        clouds["particles"] = _particles()
    rows = _contest(
        f"monte_carlo, {PARTICLES} particles, {BEAMS} beams",
        clouds,
        {
            "NumPy, a particle at a time": "as PythonRobotics does, with a likelihood field looked up for all beams",
            "particles": "a Feynman-Kac model in NumPy, with a table of log-likelihoods",
        },
        (rounds, 0.1 if quick else 0.5, clock, say),
    )
    replicas = REPLICAS // 10 if quick else REPLICAS
    sides = {"amorsim": _ours_ekf(replicas)}
    if importlib.util.find_spec("filterpy") is not None:
        sides["filterpy, looped"] = _filterpy(replicas)
    setting = f"ekf, {replicas} replicas, {MARKS} landmarks by range and bearing"
    return rows + _contest(setting, sides, {}, (rounds, 0.1 if quick else 0.5, clock, say))


def _contest(
    setting: str,
    sides: dict[str, Step],
    notes: dict[str, str],
    how: tuple[int, float, Clock, Callable[[str], None]],
) -> list[Row]:
    rounds, at_least, clock, say = how
    rates: dict[str, list[float]] = {name: [] for name in sides}
    for step in sides.values():
        step()  # whatever is not compiled yet is now
    for number in range(rounds):
        say(f"filters: {setting}, round {number + 1}")
        for name, step in sides.items():
            made, started = 0, clock()
            while clock() - started < at_least:
                step()
                made += 1
            rates[name].append(made / (clock() - started))
    ours = rates["amorsim"]
    return [
        Row(
            section=SECTION,
            setting=setting,
            side=name,
            unit="updates/s",
            rounds=tuple(found),
            ratio=None if name == "amorsim" else Ratio(spread=ratio_of(ours, found), counts=True),
            note=notes.get(name, ""),
        )
        for name, found in rates.items()
    ]


# ------------------------------------------------------------------------------------------------------- localization


def _office() -> am.Map:
    return am.load("find-yourself").map


def _robot(estimator: am.Estimator, **changes: Any) -> am.Robot:
    robot = am.load_robot("pioneer2dx")
    encoder = Encoder(counts_per_revolution=39400.0)
    return attrs.evolve(
        robot,
        controller=None,
        ground=(),
        estimators={"it": estimator},
        **changes
        | {
            "sensors": {"encoder": encoder, **changes.get("sensors", {})},
        },
    )


def _scan() -> tuple[Array, Array]:
    """Bearings and ranges of a scan of the office."""
    bearings = np.linspace(-math.pi / 2.0, math.pi / 2.0, BEAMS)
    return bearings, _office().cast_rays([[1.7, 8.2, 0.0]], bearings, _REACH)[0]


def _ours_cloud() -> Step:
    _, ranges = _scan()
    estimator = am.estimators.MonteCarlo(
        wheel_variance=1e-4,
        beams=BEAMS,
        particles_min=PARTICLES,
        particles_max=PARTICLES,
        update_distance=0.0,
        resample_below=1.0,
    )
    laser = Laser(beams=BEAMS, fov=math.pi, range_max=_REACH)
    robot = _robot(
        estimator,
        pose=am.Pose(x=1.7, y=8.2),
        initial_belief=am.InitialBelief(kind="gaussian", std=0.1, heading_std=0.05),
        knowledge=am.Knowledge(map=_office()),
        sensors={"laser": laser},
    )
    runner = am.EstimatorRunner(robot, "it")
    counts = np.zeros(2)
    time = 0.0

    def step() -> None:
        nonlocal time
        # To and fro, so that the scan goes on to fit.
        counts[:] += _TURNS / (2.0 * math.pi) * 39400.0 * (1.0 if round(time * 10.0) % 2 else -1.0)
        runner.update(time, {"encoder": counts, "laser": ranges})
        time += 0.1

    return step


def _field() -> tuple[Array, Array]:
    """A likelihood field of the office, and its lower left corner."""
    from scipy.ndimage import distance_transform_edt

    world = _office()
    cells = np.pad(world.to_array(resolution=_FIELD), 40)
    away = np.minimum(distance_transform_edt(cells == 0) * _FIELD, 2.0)
    density = np.exp(-0.5 * (away / _STD) ** 2) / (_STD * math.sqrt(2.0 * math.pi))
    return 0.5 * density + _RANDOM / _REACH, np.array(world.origin[:2]) - 40 * _FIELD


class _Cloud:
    """Particles as arrays, with the parts that both ways in NumPy share."""

    def __init__(self) -> None:
        self.field, self.corner = _field()
        self.logarithms = np.log(self.field)
        self.bearings, self.ranges = _scan()
        self.random = np.random.default_rng(1)
        self.particles = self.random.normal((1.7, 8.2, 0.0), (0.1, 0.1, 0.05), (PARTICLES, 3))
        self.weights = np.full(PARTICLES, 1.0 / PARTICLES)
        self.sign = 1.0

    def resample(self) -> None:
        total = np.cumsum(self.weights)
        comb = (np.arange(PARTICLES) + self.random.random()) / PARTICLES
        self.particles = self.particles[np.minimum(np.searchsorted(total, comb), PARTICLES - 1)]
        self.weights = np.full(PARTICLES, 1.0 / PARTICLES)


def _loop() -> Step:
    cloud = _Cloud()

    def step() -> None:
        cloud.sign = -cloud.sign
        for p in range(PARTICLES):
            left, right = cloud.sign * _TURNS * 0.0825 + cloud.random.normal(0.0, 0.001, 2)
            ahead, turn = 0.5 * (left + right), (right - left) / 0.33
            x, y, heading = cloud.particles[p]
            x, y, heading = x + ahead * math.cos(heading), y + ahead * math.sin(heading), heading + turn
            cloud.particles[p] = x, y, heading
            ends_x = x + cloud.ranges * np.cos(heading + cloud.bearings)
            ends_y = y + cloud.ranges * np.sin(heading + cloud.bearings)
            cols = np.clip((ends_x - cloud.corner[0]) / _FIELD, 0, cloud.field.shape[1] - 1).astype(int)
            rows = np.clip((ends_y - cloud.corner[1]) / _FIELD, 0, cloud.field.shape[0] - 1).astype(int)
            cloud.weights[p] *= np.prod(cloud.field[rows, cols])
        cloud.weights /= cloud.weights.sum()
        cloud.resample()

    return step


def _moved(cloud: _Cloud, poses: Array) -> Array:
    """All particles after the next step of the wheels."""
    cloud.sign = -cloud.sign
    wheels = cloud.sign * _TURNS * 0.0825 + cloud.random.normal(0.0, 0.001, (PARTICLES, 2))
    ahead, turn = wheels.mean(axis=1), (wheels[:, 1] - wheels[:, 0]) / 0.33
    x, y, heading = poses.T
    return np.column_stack((x + ahead * np.cos(heading), y + ahead * np.sin(heading), heading + turn))


def _likelihoods(cloud: _Cloud, poses: Array) -> Array:
    """The log-likelihoods of all particles, from a table of those of single beams."""
    x, y, heading = poses.T
    angles = heading[:, None] + cloud.bearings
    cols = (x[:, None] + cloud.ranges * np.cos(angles) - cloud.corner[0]) / _FIELD
    rows = (y[:, None] + cloud.ranges * np.sin(angles) - cloud.corner[1]) / _FIELD
    cols = np.clip(cols, 0, cloud.field.shape[1] - 1).astype(int)
    rows = np.clip(rows, 0, cloud.field.shape[0] - 1).astype(int)
    found: Array = cloud.logarithms[rows, cols].sum(axis=1)
    return found


def _vector() -> Step:
    cloud = _Cloud()

    def step() -> None:
        cloud.particles = _moved(cloud, cloud.particles)
        logs = np.log(cloud.weights) + _likelihoods(cloud, cloud.particles)
        cloud.weights = np.exp(logs - logs.max())
        cloud.weights /= cloud.weights.sum()
        cloud.resample()

    return step


def _particles() -> Step:
    import particles

    cloud = _Cloud()

    class Localization(particles.FeynmanKac):  # type: ignore[misc]
        def M0(self, N: int) -> Array:  # noqa: N802 - names of theirs
            return cloud.particles

        def M(self, t: int, xp: Array) -> Array:  # noqa: N802
            return _moved(cloud, xp)

        def logG(self, t: int, xp: Array, x: Array) -> Array:  # noqa: N802
            return _likelihoods(cloud, x)

    smc = particles.SMC(fk=Localization(T=10**9), N=PARTICLES, resampling="systematic", ESSrmin=1.0)
    next(smc)  # the first step does not resample, so it leaves that uncompiled
    return lambda: next(smc)


# ------------------------------------------------------------------------------------------------------ Kalman filters


def _marks() -> Array:
    angles = np.arange(MARKS) * 2.0 * math.pi / MARKS
    return 5.0 * np.stack((np.cos(angles), np.sin(angles)), axis=1)


def _sightings() -> Array:
    """Range, bearing and identity of each landmark from the origin."""
    marks = _marks()
    bearings = np.arctan2(marks[:, 1], marks[:, 0])
    return np.stack((np.hypot(*marks.T), bearings, np.arange(1.0, MARKS + 1.0)), axis=1)


def _ours_ekf(replicas: int) -> Step:
    estimator = am.estimators.Ekf(
        wheel_variance=1e-5, landmarks="fiducial", range_std=0.05, bearing_std=0.02, start_std=0.1
    )
    drive = am.load_robot("pioneer2dx").drive
    sensors = {"encoder": Encoder(counts_per_revolution=39400.0), "fiducial": Fiducial(slots=MARKS)}
    rows = replicas
    robot = am.RobotModel(
        rows=rows,
        dt=0.1,
        drive=am.stack([drive] * rows),
        shape=am.Shape.circle(0.2),
        sensors={
            name: am.SensorModel(
                name=name,
                sensor=am.stack([sensor] * rows),
                mount=am.stack([am.Mount()] * rows),
                size=sensor.size(drive),
                rate=None,
            )
            for name, sensor in sensors.items()
        },
        channels=drive.channels,
        landmarks=_marks(),
        landmark_ids=np.arange(1, MARKS + 1),
    )
    stacked: Any = am.stack([estimator] * rows)
    state = dict(stacked.start(am.Context(rows=rows, dt=0.1, robot=robot, pose=np.zeros((rows, 3)))))
    draws = am.Draws(np.zeros(rows, dtype=np.uint64), np.zeros((rows, 3), dtype=np.uint32))
    counts, elapsed = np.zeros((rows, 2)), np.full((rows, 1), 0.1)
    fresh, age, stamp = np.ones((rows, 1), dtype=bool), np.zeros((rows, 1)), np.zeros((rows, 1), dtype=np.int64)
    seen = np.tile(_sightings().reshape(1, -1), (rows, 1))
    command, sign = np.zeros((rows, 2)), 1.0

    def step() -> None:
        nonlocal sign, counts
        sign = -sign
        counts = counts + sign * _TURNS / (2.0 * math.pi) * 39400.0
        readings = {
            "encoder": am.Measurement(counts, stamp, age, fresh),
            "fiducial": am.Measurement(seen, stamp, age, fresh),
        }
        stacked.update(robot, readings, command, elapsed, state, draws)

    return step


def _filterpy(replicas: int) -> Step:
    from filterpy.kalman import ExtendedKalmanFilter

    filters = []
    for _ in range(replicas):
        one = ExtendedKalmanFilter(dim_x=3, dim_z=2)
        one.x, one.P = np.zeros(3), np.diag([0.01, 0.01, 1e-6])
        filters.append(one)
    marks, seen = _marks(), _sightings()
    noise = np.diag([0.05**2, 0.02**2])
    sign = 1.0

    def expected(x: Array, mark: Array) -> Array:
        dx, dy = mark - x[:2]
        return np.array([math.hypot(dx, dy), math.atan2(dy, dx) - x[2]])

    def slopes(x: Array, mark: Array) -> Array:
        dx, dy = mark - x[:2]
        square = dx * dx + dy * dy
        away = math.sqrt(square)
        return np.array([[-dx / away, -dy / away, 0.0], [dy / square, -dx / square, -1.0]])

    def residual(a: Array, b: Array) -> Array:
        off: Array = a - b
        off[1] = math.remainder(off[1], 2.0 * math.pi)
        return off

    def step() -> None:
        nonlocal sign
        sign = -sign
        left, right = sign * _TURNS * 0.0825
        ahead, turn = 0.5 * (left + right), (right - left) / 0.33
        for one in filters:
            c, s = math.cos(one.x[2]), math.sin(one.x[2])
            one.F = np.array([[1.0, 0.0, -ahead * s], [0.0, 1.0, ahead * c], [0.0, 0.0, 1.0]])
            one.x = one.x + np.array([ahead * c, ahead * s, turn])
            one.P = one.F @ one.P @ one.F.T + np.diag([1e-8, 1e-8, 4e-7])
            for mark, reading in zip(marks, seen, strict=True):
                one.update(reading[:2], slopes, expected, noise, args=(mark,), hx_args=(mark,), residual=residual)

    return step
