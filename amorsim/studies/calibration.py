"""A robot's devices on a test bench: the systematic errors of a gyro, a compass and a range sensor.

Each experiment is run several times, as replicas with draws of their own. Every run gives one estimate, and the
interval is that of a mean over the runs. It stays valid if the readings within a run are correlated (a bias that
wanders, a walk); intervals from single readings would then be too narrow.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any, ClassVar

import attrs
import numpy as np

from amorsim.algorithms.intervals import Interval, mean_interval
from amorsim.algorithms.least_squares import linear_fit
from amorsim.array_types import Array, Bools, Ints
from amorsim.contracts import Draws, Drive, Joint, State
from amorsim.controllers.manual import Manual
from amorsim.core.errors import AmorsimError, did_you_mean
from amorsim.core.poses import wrap_angle
from amorsim.scenario.spec import Pose, Robot, Scenario
from amorsim.sensors.compass import Compass
from amorsim.sensors.gyro import Gyro
from amorsim.simulation.simulation import Simulation
from amorsim.studies.robot_under_test import alone, chosen_robot, empty_world, with_known_place, with_settled_errors

__all__ = ["RangeCalibration", "calibrate_compass", "calibrate_gyro", "calibrate_range"]


_STILL = 10.0  # [s] that a gyro stands still, and turns at each rate
_RATES = (0.5, -0.5, 1.0, -1.0)  # [rad/s]
_HEADINGS = 72  # at which a compass reads: every 5 degrees
_READINGS = 200  # of a range sensor, at each distance
_DISTANCES = (0.25, 0.5, 0.75)  # of a range sensor's longest range


@attrs.frozen(kw_only=True)
class _TurnTable(Drive):
    """A turn table: turns the robot about its base point, exactly as commanded."""

    joints: ClassVar[tuple[Joint, ...]] = (Joint(name="table", rolls=False),)
    channels: ClassVar[tuple[str, ...]] = ("table",)

    def advance(
        self, joints: Array, rates: Array, command: Array, dt: float, state: State, draws: Draws
    ) -> tuple[Array, Array]:
        """The table's angle `(N, 1)` [rad] and rate [rad/s] a step later."""
        return joints + command * dt, command.copy()

    def twist(self, before: Array, after: Array) -> Array:
        """A turn in place."""
        out = np.zeros((len(before), 3))
        out[:, 2:] = after - before
        return out

    def command_for(self, twist: Array, joints: Array) -> Array:
        """The rate of turn."""
        return np.ascontiguousarray(twist[:, 2:])

    def rolling_radius(self) -> Array:
        """No joint rolls."""
        return np.empty((1, 0))


# ------------------------------------------------------------------------------------------------------- the bench


def _device(scenario: Scenario, robot: str | None, sensor: str | None, fits: Callable[[Any], bool], what: str) -> str:
    """Name of the sensor to test: the named one, or the first that fits.

    Raises
    ------
    AmorsimError
        If there is none.
    """
    chosen = chosen_robot(scenario, robot)
    fitting = [name for name, unit in chosen.sensors.items() if fits(unit.sensor)]
    if sensor is None and fitting:
        return fitting[0]
    if sensor in fitting:
        return str(sensor)
    known = ", ".join(fitting) or "none"
    if sensor is None or sensor in chosen.sensors:
        given = "" if sensor is None else f", and {sensor!r} is none"
        raise AmorsimError(f"robot {chosen.name!r}: expected {what}{given}; it has: {known}")
    raise AmorsimError(
        f"robot {chosen.name!r} has no sensor {sensor!r}; of that kind it has: {known}.{did_you_mean(sensor, fitting)}"
    )


def _on_bench(scenario: Scenario, robot: str | None, sensor: str) -> Robot:
    """The robot with this one sensor, on the turn table; its errors those of replica 0, its drive's left out."""
    settled = with_settled_errors(with_known_place(chosen_robot(scenario, robot)), scenario.seed)
    errors = {path: error for path, error in settled.errors.items() if path.split(".")[:2] == ["sensors", sensor]}
    return attrs.evolve(
        settled,
        drive=_TurnTable(),
        ground=(),
        sensors={sensor: settled.sensors[sensor]},
        estimators={},
        controller=Manual(),
        errors=errors,
        pose=Pose(),
        start=None,
    )


def _watch(
    simulation: Simulation, sensor: str, steps: int, rate: Callable[[float], float], element: int = 0
) -> tuple[Array, Array, Ints]:
    """What a sensor measured while it was turned at `rate` (rad/s), a function of the time [s].

    Returns one element of the readings that the runs held after each step `(T, R)`; the true poses of all ticks
    `(T + 1, R, 3)`; and the ticks `(T, R)` that the readings are of, or -1 where no new one came in. So each reading
    counts once, when it arrives; runs may get theirs at different times. The one of the start is left out.
    """
    group = simulation._fleet.groups[0]
    poses, readings, stamps = [simulation.true_pose], [], []
    for _ in range(steps):
        group.driver.state["command"][:] = rate(simulation.time)
        simulation.step()
        poses.append(simulation.true_pose)
        reading = group.readings[sensor]
        readings.append(reading.measured[:, element].copy())  # a view would keep all elements
        stamps.append(np.where(reading.fresh & (reading.stamp > 0), reading.stamp, -1)[:, 0])
    return np.array(readings), np.array(poses), np.array(stamps, dtype=np.int64)


def _wait(simulation: Simulation, sensor: str) -> float:
    """The time [s] until a reading has certainly arrived, and that step."""
    unit = simulation.scenario.robots[0].sensors[sensor]
    return unit.latency + max(simulation.dt, 1.0 / unit.rate if unit.rate else 0.0)


def _check_readings(sensor: str, values: Array | Ints, least: int) -> None:
    """Raise an `AmorsimError` unless so many of the values that a run has readings of are different."""
    if len(np.unique(values)) < least:
        raise AmorsimError(f"sensor {sensor!r}: too few readings came in; its rate is too low, or its latency too long")


def _check_runs(runs: int) -> None:
    if runs < 2:
        raise AmorsimError(f"runs: expected 2 at least, for the intervals come from how runs scatter, got {runs!r}")


# ------------------------------------------------------------------------------------------------- the experiments


def calibrate_gyro(
    scenario: Scenario, *, robot: str | None = None, sensor: str | None = None, runs: int = 10
) -> tuple[str, Mapping[str, Interval]]:
    """The gyro's name, its ``bias`` [rad/s] and its ``scale`` (measured = scale * true + bias).

    It stands still for 10 s, and then turns for 10 s each at 0.5, -0.5, 1 and -1 rad/s on a turn table.

    Raises
    ------
    AmorsimError
        If the robot has no gyro, or there are too few runs or readings.
    """
    _check_runs(runs)
    name = _device(scenario, robot, sensor, lambda device: isinstance(device, Gyro), "a gyro")
    prepared = alone(scenario, _on_bench(scenario, robot, name), empty_world(10.0))
    simulation = Simulation(prepared, replicas=runs)
    rates = (0.0, *_RATES)

    def rate(time: float) -> float:
        return rates[min(int(time / _STILL + 1e-9), len(rates) - 1)]

    steps = simulation.steps_of(_STILL * len(rates) + _wait(simulation, name))
    readings, poses, stamps = _watch(simulation, name, steps, rate)
    found = []
    for run in range(runs):
        there = np.flatnonzero(stamps[:, run] >= 0)
        ticks = stamps[there, run]
        turned = wrap_angle(poses[ticks, run, 2] - poses[ticks - 1, run, 2]) / simulation.dt
        _check_readings(name, np.round(turned, 9), 2)
        design = np.stack((np.ones(len(turned)), turned), axis=1)
        found.append(linear_fit(design, readings[there, run]))
    bias, scale = np.transpose(found)
    return name, {"bias": mean_interval(bias), "scale": mean_interval(scale)}


def calibrate_compass(
    scenario: Scenario, *, robot: str | None = None, sensor: str | None = None, runs: int = 10
) -> tuple[str, Mapping[str, Interval]]:
    """The compass' name, and the coefficients of its deviation [rad]: ``a`` to ``e``.

    Measured less true heading is a + b sin h + c cos h + d sin 2h + e cos 2h, where h is the heading of the
    compass. It reads at every 5 degrees of a turn in place. If the true mount is rotated from the nominal one, the
    angle shows as part of `a`, like a misaligned lubber line.

    Raises
    ------
    AmorsimError
        If the robot has no compass, or there are too few runs or readings.
    """
    _check_runs(runs)
    name = _device(scenario, robot, sensor, lambda device: isinstance(device, Compass), "a compass")
    prepared = alone(scenario, _on_bench(scenario, robot, name), empty_world(10.0))
    simulation = Simulation(prepared, replicas=runs)
    dt = simulation.dt
    # Stands at each heading until a reading of it has come in.
    stand = simulation.steps_of(_wait(simulation, name)) + 1
    turn = 2.0 * math.pi / _HEADINGS / dt

    def rate(time: float) -> float:
        return turn if round(time / dt) % (stand + 1) == 0 else 0.0

    readings, poses, stamps = _watch(simulation, name, _HEADINGS * (stand + 1), rate)
    mount = prepared.robots[0].sensors[name].mount.heading
    found = []
    for run in range(runs):
        there = np.flatnonzero(stamps[:, run] >= 0)
        h = poses[stamps[there, run], run, 2] + mount
        _check_readings(name, np.round(wrap_angle(h), 6), 8)
        design = np.stack((np.ones(len(h)), np.sin(h), np.cos(h), np.sin(2.0 * h), np.cos(2.0 * h)), axis=1)
        found.append(linear_fit(design, wrap_angle(readings[there, run] - h)))
    return name, dict(zip("abcde", (mean_interval(row) for row in np.transpose(found)), strict=True))


@attrs.frozen(kw_only=True)
class RangeCalibration:
    """Bias and spread of a range sensor at one distance from a wall [m]; `returned` is the share with a return."""

    distance: float
    bias: Interval
    sigma: Interval
    returned: float


def calibrate_range(
    scenario: Scenario,
    *,
    robot: str | None = None,
    sensor: str | None = None,
    element: int | None = None,
    runs: int = 10,
) -> tuple[str, int, list[RangeCalibration]]:
    """The range sensor's name, the number of the tested element, and its calibration at three distances.

    The element looks squarely at a wall, from a quarter, a half and three quarters of its longest range, 200 readings
    each. The distance is the reading of a perfect device at the nominal mount; sigma is the standard deviation of
    single readings about their own mean, including rounding.

    Parameters
    ----------
    element
        Which beam or transducer; without it, the one that looks most nearly straight ahead of the mount.

    Raises
    ------
    AmorsimError
        If the robot has no range sensor, the sensor has no such element, or there are too few runs or readings.
    """
    _check_runs(runs)
    name = _device(scenario, robot, sensor, _is_range_sensor, "a range sensor")
    bench = _on_bench(scenario, robot, name)
    unit = bench.sensors[name]
    device: Any = unit.sensor
    bearings = np.ravel(device.bearings())
    if element is None:
        element = int(np.argmin(np.abs(wrap_angle(bearings))))
    if not 0 <= element < len(bearings):
        raise AmorsimError(f"sensor {name!r}: expected an element from 0 to {len(bearings) - 1}, got {element!r}")
    # Turned so that the element looks along the world's x axis, where the wall stands across.
    pose = Pose(heading=float(-(unit.mount.heading + bearings[element])))
    perfect = attrs.evolve(bench, errors={}, sensors={name: attrs.evolve(unit, noise=())})

    def before_wall(specified: Robot, far: float) -> Scenario:
        world = empty_world(4.0 * far + 10.0, [(far, -4.0 * far, far, 4.0 * far)])
        return attrs.evolve(alone(scenario, specified, world), robots=[attrs.evolve(specified, pose=pose, start=None)])

    def distance(far: float) -> float:
        return float(Simulation(before_wall(perfect, far)).readings[name].true[0, element])

    reach = float(np.max(np.hypot(*bench.shape.outline.T)))
    # How far ahead of the robot's base point the element sits, as it sees a wall that is surely ahead of the body.
    ahead = reach + 0.4 * device.range_max
    offset = ahead - distance(ahead)
    if not math.isfinite(offset):
        raise AmorsimError(f"sensor {name!r} does not see a wall squarely ahead of element {element}")
    found = []
    for number, share in enumerate(_DISTANCES):
        far = max(offset + share * device.range_max, reach + 0.01)
        # Draws of its own at each distance.
        replicas = range(number * runs, (number + 1) * runs)
        simulation = Simulation(before_wall(bench, far), replicas=replicas)
        steps = math.ceil(_READINGS * _wait(simulation, name) / simulation.dt + 1.0)
        readings, _, stamps = _watch(simulation, name, steps, lambda _: 0.0, element)
        for run in range(runs):
            _check_readings(name, stamps[stamps[:, run] >= 0, run], 2)
        found.append(_spread(distance(far), readings, stamps >= 0, name))
    return name, element, found


def _is_range_sensor(device: Any) -> bool:
    return getattr(device, "range_max", None) is not None and device.bearings() is not None


def _spread(true: float, readings: Array, is_new: Bools, name: str) -> RangeCalibration:
    """Bias and standard deviation of the new readings `(T, R)` of one distance."""
    returned = is_new & np.isfinite(readings)
    counts = returned.sum(axis=0)
    if not math.isfinite(true) or (counts < 2).any():
        raise AmorsimError(f"sensor {name!r} hardly ever sees a wall squarely ahead of it; it cannot be calibrated")
    # Relative to the shortest, so that equal readings have exactly no spread.
    shortest = np.where(returned, readings, np.inf).min(axis=0)
    values = np.where(returned, readings, shortest) - shortest
    means = values.sum(axis=0) / counts
    squares = np.where(returned, values - means, 0.0) ** 2
    variance = mean_interval(squares.sum(axis=0) / (counts - 1))
    return RangeCalibration(
        distance=true,
        bias=mean_interval(shortest - true + means),
        sigma=Interval(*(math.sqrt(max(end, 0.0)) for end in variance[:3])),
        returned=float(returned.sum() / is_new.sum()),
    )
