"""Makes the pictures of docs/explanation/errors: what each error model does, in runs of the simulator itself.

They are looked at and not compared, so make them again only where they should look different::

    python tools/make_error_pictures.py [NAME ...]
"""

from __future__ import annotations

import io
import math
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
from matplotlib.figure import Figure
from PIL import Image

import amorsim as am
from amorsim import noise

__all__ = ["make"]

PICTURES = Path(__file__).resolve().parents[1] / "docs" / "pictures"
COLOURS = 64
TRUE, MEASURED, OTHER = "#1b7f5c", "#d97706", "#2f6fde"

Array = npt.NDArray[np.float64]


# ------------------------------------------------------------------------------------------------ what is simulated


def _room() -> am.Map:
    corners = np.array([(0.0, 0.0), (6.0, 0.0), (6.0, 4.0), (0.0, 4.0)])
    walls = np.concatenate((corners, np.roll(corners, -1, axis=0)), axis=1)
    pillar = np.array([(3.9, 2.9, 4.3, 2.9), (4.3, 2.9, 4.3, 3.3), (4.3, 3.3, 3.9, 3.3), (3.9, 3.3, 3.9, 2.9)])
    return am.Map.from_segments(np.concatenate((walls, pillar)), resolution=0.001)


def _named(elements: Sequence[am.Noise]) -> tuple[am.NoiseElement, ...]:
    return tuple(am.NoiseElement(name=f"e{i}", noise=element) for i, element in enumerate(elements))


def _simulate(
    sensor: am.Sensor | None = None,
    *chain: am.Noise,
    ground: Sequence[am.Noise] = (),
    pose: tuple[float, float, float] = (1.0, 2.0, 0.0),
    field: am.Map | None = None,
    dt: float = 0.1,
    replicas: int = 1,
    forward: float = 0.0,
    turn: float = 0.0,
    zones: Sequence[am.Zone] = (),
    landmarks: Sequence[am.Landmark] = (),
    **mounted: float,
) -> am.Simulation:
    """A robot with one noisy sensor, under way with the given speed [m/s] and turning rate [rad/s]."""
    sensors: dict[str, Any] = {"encoder": am.sensors.Encoder(counts_per_revolution=39400.0)}
    if sensor is not None:
        sensors["sensor"] = am.MountedSensor(sensor=sensor, noise=_named(chain), **mounted)
    robot = am.Robot(
        name="rover",
        shape=am.Shape.circle(0.2),
        drive=am.drives.Differential(wheel_radius_left=0.0825, wheel_radius_right=0.0825, track=0.33, rate_max=1e3),
        sensors=sensors,
        estimators={"dead_reckoning": am.estimators.DeadReckoning()},
        controller=am.controllers.Manual(),
        ground=_named(ground),
        pose=am.Pose(x=pose[0], y=pose[1], heading=pose[2]),
    )
    sim = am.Simulation(
        am.Scenario(map=field or _room(), robots=[robot], zones=zones, landmarks=landmarks, dt=dt, seed=1),
        replicas=replicas,
    )
    for replica in sim.replicas:
        sim.robot("rover", replica).drive(forward=forward, turn=turn)
    return sim


def _series(sim: am.Simulation, duration: float) -> tuple[Array, Array, Array]:
    """Times [s], and what the sensor's first value was and measured, of the first replica."""
    rows = []
    for _ in range(sim.steps_of(duration) + 1):
        reading = sim.readings["sensor"]
        rows.append((sim.time, reading.true[0, 0], reading.measured[0, 0]))
        sim.step()
    return tuple(np.array(column) for column in zip(*rows, strict=True))  # type: ignore[return-value]


def _scan(sim: am.Simulation, duration: float = 0.0) -> tuple[Array, Array, Array]:
    """Where the robot is, and the ends of its true and measured beams in the world, `(beams, 2)`."""
    sim.run(duration)
    reading = sim.readings["sensor"]
    (pose,) = sim.true_pose
    laser = am.sensors.Laser(beams=reading.true.shape[1], fov=2.0 * math.pi, range_max=8.0)
    heading = pose[2] + laser.bearings()[0]
    way = np.stack((np.cos(heading), np.sin(heading)), axis=1)
    return pose, *(
        pose[:2] + way * np.where(np.isfinite(r), r, np.nan)[0, :, None] for r in (reading.true, reading.measured)
    )


# ------------------------------------------------------------------------------------------------- how it is drawn


def _figure(columns: int = 1) -> tuple[Figure, list[Any]]:
    figure = Figure(figsize=(8.0, 4.5), layout="constrained")
    axes = list(np.ravel(figure.subplots(1, columns)))
    for axis in axes:
        axis.spines[["top", "right"]].set_visible(False)
        axis.grid(color="#e5e7eb")
        axis.set_axisbelow(True)
    return figure, axes


def _approach(*chain: am.Noise, unit: str = "range [m]", duration: float = 8.0) -> Figure:
    """The range to a wall that the robot drives towards."""
    sim = _simulate(am.sensors.Laser(beams=1, fov=0.1), *chain, forward=0.3)
    time, true, measured = _series(sim, duration)
    figure, (axis,) = _figure()
    axis.plot(time, true, color=TRUE, linewidth=2.2, label="true")
    axis.plot(time, measured, ".", color=MEASURED, markersize=5, label="measured")
    axis.set(xlabel="time [s]", ylabel=unit)
    axis.legend(frameon=False)
    return figure


def _scan_figure(sensor_noise: Sequence[am.Noise], *, turn: float = 0.0, forward: float = 0.0) -> Figure:
    laser = am.sensors.Laser(beams=361, fov=2.0 * math.pi, range_max=8.0)
    sim = _simulate(laser, *sensor_noise, pose=(2.0, 1.5, 0.4), turn=turn, forward=forward)
    pose, true, measured = _scan(sim, 0.5)
    figure, (axis,) = _figure()
    axis.plot(*true.T, ".", color=TRUE, markersize=5, label="true")
    axis.plot(*measured.T, ".", color=MEASURED, markersize=3, label="measured")
    axis.plot(*pose[:2], "k^", label="laser")
    axis.set(xlabel="x [m]", ylabel="y [m]", aspect="equal")
    axis.legend(frameon=False, loc="center")
    return figure


def _drift(element: am.Noise, theory: Callable[[Array], Array], label: str) -> Figure:
    """A gyro at rest: its readings, and the Allan deviation of many against the formula."""
    dt, count, replicas = 0.1, 2000, 40
    sim = _simulate(am.sensors.Gyro(), element, dt=dt, replicas=replicas)
    values = []
    for _ in range(count):
        sim.step()
        values.append(sim.readings["sensor"].measured[:, 0])
    rates = np.degrees(np.array(values))
    figure, (left, right) = _figure(2)
    time = dt * np.arange(1, count + 1)
    for i in range(4):
        left.plot(time, rates[:, i], linewidth=0.8)
    left.set(xlabel="time [s]", ylabel="rate measured at rest [°/s]")
    spans = np.unique(np.geomspace(1, count // 4, 20).astype(int))
    found = []
    for m in spans:
        means = rates[: count // m * m].reshape(-1, m, replicas).mean(axis=1)
        found.append(math.sqrt(0.5 * (np.diff(means, axis=0) ** 2).mean()))
    right.loglog(dt * spans, found, "o", color=MEASURED, markersize=4, label=f"{replicas} replicas")
    right.loglog(dt * spans, np.degrees(theory(dt * spans)), color=OTHER, label=label)
    right.set(xlabel="averaging time [s]", ylabel="Allan deviation [°/s]")
    right.legend(frameon=False)
    return figure


def _ends(element: am.Noise, *, forward: float, turns: tuple[float, ...]) -> Figure:
    """Where 800 replicas are after 4 s, each of some arcs."""
    figure, (axis,) = _figure()
    empty = am.Map.from_segments(np.empty((0, 4)), resolution=0.5, extent=(-50.0, -50.0, 50.0, 50.0))
    for turn, colour in zip(turns, (MEASURED, OTHER, TRUE), strict=True):
        sim = _simulate(None, ground=[element], pose=(0, 0, 0), field=empty, replicas=800, forward=forward, turn=turn)
        path = [sim.estimated_pose[0, :2]]
        for _ in range(40):
            sim.step()
            path.append(sim.estimated_pose[0, :2])
        axis.plot(*sim.true_pose[:, :2].T, ".", color=colour, markersize=2)
        axis.plot(*np.array(path).T, color="k", linewidth=1.0)
    axis.set(xlabel="x [m]", ylabel="y [m]", aspect="equal")
    axis.set_title("dead reckoning (line), true ends of 800 replicas (dots)", fontsize=10)
    return figure


# -------------------------------------------------------------------------------------------------- the pictures


def _gauss_markov(std: float, correlation_time: float) -> Callable[[Array], Array]:
    def theory(time: Array) -> Array:
        ratio = time / correlation_time
        part = 3.0 - 4.0 * np.exp(-ratio) + np.exp(-2.0 * ratio)
        return std * np.sqrt(2.0 / ratio * (1.0 - part / (2.0 * ratio)))

    return theory


def _compass() -> Figure:
    chain = noise.CompassDeviation(a=0.03, b=0.17, c=-0.1, d=0.06, e=0.02)
    _, true, measured = _series(_simulate(am.sensors.Compass(), chain, turn=0.5), 4.0 * math.pi)
    figure, (axis,) = _figure()
    order = np.argsort(true)
    axis.plot(np.degrees(true[order]), np.degrees(measured - true)[order], ".-", color=MEASURED)
    axis.set(xlabel="true heading [°]", ylabel="measured less true [°]", xticks=range(-180, 181, 60))
    return figure


def _beams() -> Figure:
    parts = {"hit": 0.7, "short": 0.12, "max": 0.06, "random": 0.12}
    element = noise.BeamModel(**parts, std=0.08, short_rate=0.6, range_max=8.0)
    sim = _simulate(am.sensors.Laser(beams=1, fov=0.1), element, replicas=4000, pose=(1.0, 2.0, 0.0))
    values = []
    for _ in range(10):
        values.append(sim.readings["sensor"].measured[:, 0])
        sim.step()
    drawn = np.concatenate(values)
    figure, (axis,) = _figure()
    z = float(sim.readings["sensor"].true[0, 0])
    axis.hist(
        drawn[np.isfinite(drawn)],
        bins=160,
        range=(0, 8),
        weights=np.full(np.isfinite(drawn).sum(), 20 / drawn.size),
        color=MEASURED,
        alpha=0.6,
        label="40,000 ranges of the simulator, per metre",
    )
    x = np.linspace(0.0, 8.0, 2000)
    bell = np.exp(-0.5 * ((x - z) / 0.08) ** 2) / (0.08 * math.sqrt(2.0 * math.pi))
    short = np.where(x < z, 0.6 * np.exp(-0.6 * x) / -math.expm1(-0.6 * z), 0.0)
    axis.plot(x, 0.7 * bell + 0.12 * short + 0.12 / 8.0, color=OTHER, label="the model's density")
    axis.set(xlabel="range [m]", ylabel="density [1/m]", ylim=(0.01, 6), yscale="log")
    axis.set_title(f"no return: {np.isinf(drawn).mean():.1%}", fontsize=10)
    axis.legend(frameon=False)
    return figure


def _specular() -> Figure:
    sonar = am.sensors.Sonar(half_angle=math.radians(12.0))
    sim = _simulate(sonar, noise.SpecularLoss(critical=math.radians(25.0)), pose=(4.5, 1.2, -1.2), turn=0.2)
    time, true, measured = _series(sim, 2.4 / 0.2)
    heading = np.degrees(-1.2 + 0.2 * time)
    figure, (axis,) = _figure()
    axis.plot(heading, true, color=TRUE, linewidth=2.2, label="true")
    axis.plot(heading, np.where(np.isfinite(measured), measured, np.nan), ".", color=MEASURED, label="measured")
    axis.set(xlabel="where the sonar looks [°]", ylabel="range [m]", ylim=(0, None))
    axis.legend(frameon=False)
    return figure


def _slips() -> Figure:
    figure, (axis,) = _figure()
    event = noise.Slip(at=2.0, duration=1.0, factor=0.6, joint="left_wheel")
    sim = _simulate(None, ground=[event], pose=(1.0, 1.0, 0.0), forward=0.5)
    path = []
    for _ in range(60):
        path.append((*sim.true_pose[0, :2], *sim.estimated_pose[0, :2]))
        sim.step()
    rows = np.array(path)
    axis.plot(rows[:, 0], rows[:, 1], color=TRUE, linewidth=2.2, label="true")
    axis.plot(rows[:, 2], rows[:, 3], "--", color=OTHER, label="estimated")
    axis.set(xlabel="x [m]", ylabel="y [m]", aspect="equal")
    axis.legend(frameon=False)
    return figure


def _cross_talk() -> Figure:
    """What the left one of two that face each other reads while the other drives up, for three phases of that."""
    figure, (axis,) = _figure()
    for late, colour in ((-0.002, OTHER), (0.0, MEASURED), (0.002, "#a21caf")):
        robots = []
        for name, x, heading, phase in (("left", 1.0, 0.0, 0.0), ("right", 5.0, math.pi, late)):
            unit = am.MountedSensor(
                sensor=am.sensors.Sonar(medium="ultrasound", phase=phase),
                mount=am.Mount(x=0.2),
                noise=(noise.CrossTalk(), noise.Gaussian(std=0.01)),
            )
            robots.append(
                am.Robot(
                    name=name,
                    shape=am.Shape.circle(0.2),
                    drive=am.drives.Differential(
                        wheel_radius_left=0.0825, wheel_radius_right=0.0825, track=0.33, rate_max=1e3
                    ),
                    sensors={"sonar": unit},
                    controller=am.controllers.Manual(),
                    pose=am.Pose(x=x, y=2.0, heading=heading),
                )
            )
        sim = am.Simulation(am.Scenario(map=_room(), robots=robots, seed=1))
        sim.robot("right").drive(forward=0.3)
        rows = []
        for _ in range(100):
            reading = sim.robot("left").readings["sonar"]
            rows.append((sim.time, reading.true[0], reading.measured[0]))
            sim.step()
        time, true, measured = np.array(rows).T
        axis.plot(time, measured, ".", color=colour, markersize=4, label=f"measured, the other {1e3 * late:+.0f} ms")
    axis.plot(time, true, color=TRUE, linewidth=2.2, label="true", zorder=1)
    axis.set(xlabel="time [s]", ylabel="range [m]", ylim=(0.0, None))
    axis.legend(frameon=False)
    return figure


def _rough() -> Figure:
    empty = am.Map.from_segments(np.empty((0, 4)), resolution=0.5, extent=(-50.0, -50.0, 50.0, 50.0))
    bump = noise.Bump(height=0.01, rate=0.5)
    sim = _simulate(None, ground=[bump], pose=(0, 0, 0), field=empty, replicas=40, forward=0.5)
    ways = [sim.true_pose[:, :2]]
    for _ in range(160):
        sim.step()
        ways.append(sim.true_pose[:, :2])
    figure, (axis,) = _figure()
    axis.plot(*np.array(ways).transpose(2, 0, 1), color=TRUE, linewidth=0.7)
    axis.plot((0.0, 8.0), (0.0, 0.0), "--", color=OTHER, linewidth=2.0, label="estimated, by all")
    axis.set(xlabel="x [m]", ylabel="y [m]")
    axis.legend(frameon=False, loc="upper left")
    return figure


def _zones() -> Figure:
    ice = am.Zone(
        name="ice",
        shape=am.Shape.circle(0.6),
        pose=am.Pose(x=2.3, y=1.7),
        ground=(noise.Scale(factor=0.9),),
    )
    sill = am.Zone(
        name="sill",
        shape=am.Shape.rectangle(0.04, 2.0),
        pose=am.Pose(x=4.0, y=2.8, heading=0.2),
        ground=(noise.Bump(height=0.03),),
    )
    sim = _simulate(None, pose=(1.0, 1.2, 0.0), forward=0.5, zones=(ice, sill))
    rows = []
    for _ in range(90):
        rows.append((*sim.true_pose[0, :2], *sim.estimated_pose[0, :2]))
        sim.step()
    path = np.array(rows)
    figure, (axis,) = _figure()
    for zone in (ice, sill):
        axis.fill(*zone.outline.T, facecolor="#f3d9a4", edgecolor="#c98a1b", hatch="//", linewidth=0.8, alpha=0.6)
        axis.text(*(zone.outline.max(axis=0) - (0.0, 0.02)), zone.name, fontsize=9, color="#8a5a00")
    axis.plot(path[:, 0], path[:, 1], color=TRUE, linewidth=2.2, label="true")
    axis.plot(path[:, 2], path[:, 3], "--", color=OTHER, label="estimated")
    axis.set(xlabel="x [m]", ylabel="y [m]", aspect="equal", ylim=(0.8, 4.0))
    axis.legend(frameon=False, loc="upper left")
    return figure


def _ages() -> Figure:
    figure, (axis,) = _figure()
    dt, latency = 0.02, 0.12
    for chain, colour, label in (
        ((), TRUE, "latency 0.12 s"),
        ((noise.LatencyJitter(spread=0.08),), MEASURED, "and a jitter of ± 0.08 s"),
    ):
        sim = _simulate(am.sensors.Gyro(), *chain, dt=dt, rate=10.0, latency=latency)
        rows = []
        for _ in range(100):
            rows.append((sim.time, sim.readings["sensor"].age[0, 0]))
            sim.step()
        axis.step(*np.array(rows).T, where="post", color=colour, label=label)
    axis.set(xlabel="time [s]", ylabel="age of the reading that the robot has [s]", ylim=(0.0, 0.3))
    axis.legend(frameon=False, loc="upper right", ncols=2)
    return figure


DEG = math.pi / 180.0


def _missed() -> Figure:
    """A finder that drives towards a wall with marks on it: what it finds of those that are in sight."""
    places = [(5.95, 2.2), (5.2, 0.3), (3.0, 3.9), (1.8, 0.6)]
    marks = [am.Landmark(id=i, x=x, y=y) for i, (x, y) in enumerate(places, start=1)]
    sim = _simulate(
        am.sensors.Fiducial(slots=6, range_max_id=8.0),
        noise.Missed(probability=0.02, per_metre=0.12),
        forward=0.2,
        dt=0.2,
        landmarks=marks,
    )
    times, true, found = [], [], []
    for _ in range(100):
        sim.step()
        reading = sim.robot("rover").readings["sensor"]
        times.append(sim.time)
        true.append(reading.true.reshape(-1, 3)[:, 0])
        found.append(reading.measured.reshape(-1, 3)[:, 0])
    figure = Figure(figsize=(8.0, 4.4), layout="constrained")
    axis: Any = figure.subplots()
    seen, estimates = np.array(true), np.array(found)
    axis.plot(times, np.where(np.isfinite(seen), seen, np.nan), "o", mfc="none", mec=TRUE, mew=0.8, ms=5.0)
    axis.plot(times, np.where(np.isfinite(estimates), estimates, np.nan), ".", color=MEASURED, ms=3.5)
    axis.plot([], [], "o", mfc="none", mec=TRUE, label="in sight")
    axis.plot([], [], ".", color=MEASURED, label="found")
    axis.set(xlabel="time [s]", ylabel="range [m]")
    axis.spines[["top", "right"]].set_visible(False)
    axis.legend(frameon=False, fontsize=9)
    return figure


DRAWN: dict[str, Callable[[], Figure]] = {
    "missed": _missed,
    "gaussian": lambda: _approach(noise.Gaussian(std=0.05, proportional=0.02)),
    "bias": lambda: _approach(noise.Bias(value=0.3)),
    "scale": lambda: _approach(noise.Scale(factor=1.1)),
    "quantize": lambda: _approach(noise.Quantize(step=0.25)),
    "saturate": lambda: _approach(noise.Saturate(minimum=3.2, maximum=4.3)),
    "noise-floor": lambda: _approach(noise.NoiseFloor(level=3.2)),
    "dropout": lambda: _approach(noise.Gaussian(std=0.01), noise.Dropout(probability=0.3, report="last")),
    "outliers": lambda: _approach(noise.Gaussian(std=0.02), noise.Outliers(probability=0.1, std=0.7)),
    "stuck": lambda: _approach(noise.Stuck(rate=0.5, duration=1.0)),
    "aim-gaussian": lambda: _scan_figure([noise.AimGaussian(std=2.0 * DEG)]),
    "motion-distortion": lambda: _scan_figure([noise.MotionDistortion(sweep=0.1)], turn=2.5),
    "angle-random-walk": lambda: _drift(
        noise.AngleRandomWalk(density=0.1 * DEG), lambda t: 0.1 * DEG / np.sqrt(t), "N / √t"
    ),
    "bias-random-walk": lambda: _drift(
        noise.BiasRandomWalk(std=0.02 * DEG), lambda t: 0.02 * DEG * np.sqrt(t / 3.0), "K √(t / 3)"
    ),
    "bias-instability": lambda: _drift(
        noise.BiasInstability(std=0.03 * DEG, correlation_time=5.0), _gauss_markov(0.03 * DEG, 5.0), "closed form"
    ),
    "compass-deviation": _compass,
    "beam-model": _beams,
    "specular-loss": _specular,
    "diffusion": lambda: _ends(noise.Diffusion(variance_per_length=3e-4), forward=0.5, turns=(-0.5, 0.0, 0.5)),
    "velocity-model": lambda: _ends(
        noise.VelocityModel(a1=0.05, a3=0.6, a4=0.05, interval=0.1), forward=0.5, turns=(-0.5, 0.0, 0.5)
    ),
    "odometry-model": lambda: _ends(
        noise.OdometryModel(a1=0.05, a2=0.6, a3=0.05, interval=0.1), forward=0.5, turns=(-0.5, 0.0, 0.5)
    ),
    "slip": _slips,
    "bump": _rough,
    "zones": _zones,
    "latency-jitter": _ages,
    "cross-talk": _cross_talk,
}


def make(folder: Path, names: Sequence[str] = ()) -> None:
    """Write all pictures, or those of some names, into `folder`, as ``error-<name>.png``."""
    for name in names or DRAWN:
        raw = io.BytesIO()
        DRAWN[name]().savefig(raw, format="png", dpi=100)
        picture = Image.open(raw).convert("RGB")
        small = picture.quantize(COLOURS, method=Image.Quantize.MAXCOVERAGE, dither=Image.Dither.NONE)
        small.save(folder / f"error-{name}.png", optimize=True)


if __name__ == "__main__":
    make(PICTURES, sys.argv[1:])
