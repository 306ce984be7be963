"""The effect of each error of a sensor on its readings: the same drive with each alone, and with all together."""

from __future__ import annotations

import math

import attrs
import numpy as np

from amorsim.array_types import Array, Bools
from amorsim.controllers.manual import Manual
from amorsim.core.errors import AmorsimError
from amorsim.core.poses import wrap_angle
from amorsim.core.unknown_names import no_such
from amorsim.scenario.spec import MountedSensor, Robot, Scenario
from amorsim.simulation.simulation import Simulation
from amorsim.studies.robot_under_test import chosen_robot

__all__ = ["ReadingAttribution", "ReadingCase", "attribute_readings"]


LARGEST = 40_000_000  # numbers of the readings that are held at once, 8 bytes each
STEPS_MOST = 2000  # whose readings are looked at


@attrs.frozen(kw_only=True, eq=False)
class ReadingCase:
    """The readings with one error of the sensor alone, or with all of them.

    Attributes
    ----------
    name
        Path of the error, such as ``"sensors.laser.noise.gaussian"`` or ``"errors.sensors.laser.mount.heading"``.
    error
        Root mean square change of a value, over all values, steps and replicas, in the sensor's unit.
    share
        Share of the mean square error of all together, 1 for all of it; negative if the error compensates others.
    changed
        Fraction of all values that lost their return by the error, or gained one.
    by_step
        `(T,)` the root mean square at each step.
    """

    name: str
    error: float
    share: float
    changed: float
    by_step: Array


@attrs.frozen(kw_only=True, eq=False)
class ReadingAttribution:
    """All cases over one recorded drive; `time` [s] `(T,)` is that of the steps that were looked at."""

    robot: str
    sensor: str
    unit: str
    time: Array
    cases: tuple[ReadingCase, ...]
    together: ReadingCase

    @property
    def interaction(self) -> float:
        """1 less the sum of the single shares: the part by which errors amplify or reduce each other."""
        return 1.0 - sum(case.share for case in self.cases)


def attribute_readings(
    scenario: Scenario, sensor: str, *, robot: str | None = None, replicas: int = 20
) -> ReadingAttribution:
    """Repeat the commands of one drive with each error of a sensor alone, and with all together.

    An error is an entry of the robot's `errors` that touches the sensor, or an element of its chain. Everything else
    is the same in all cases, so the robot goes the same way and sees the same. Draws depend only on names, so each
    error draws the same alone and together with others. The error of a value is its difference from the sensor's
    report at that step without errors (a compass's, the short way round); latency and rate are not errors, jitter of
    latency is one. If only one of the two has a return, the value counts in `changed` alone.

    A share is the part of the error of all together that one error makes: mean of e_i e over mean of e e.

    Parameters
    ----------
    sensor
        Its name.
    robot
        Its name; without it, the first.
    replicas
        Number of replicas, for random errors.

    Raises
    ------
    AmorsimError
        If there is no such sensor, it has no errors, its values are of several quantities, or there is too much to
        hold.
    """
    chosen = chosen_robot(scenario, robot)
    if replicas < 1:
        raise AmorsimError(f"replicas: expected a whole number > 0, got {replicas!r}")
    unit = _unit(chosen, sensor)
    names = _names(chosen, sensor)
    if not names:
        raise AmorsimError(
            f"robot {chosen.name!r}, sensor {sensor!r}: has nothing to explain: no errors of its geometry, no noise"
        )
    commands = _commands(scenario, chosen)
    every = math.ceil(len(commands) / STEPS_MOST)
    size = unit.sensor.size(chosen.drive)
    if (len(commands) // every) * replicas * size > LARGEST:
        raise AmorsimError(
            f"robot {chosen.name!r}, sensor {sensor!r}: {len(commands) // every} readings of {size} values in "
            f"{replicas} replicas are more than can be held; take fewer replicas, or a shorter duration"
        )

    def play(kept: set[str]) -> Array:
        player = attrs.evolve(_with_only(chosen, sensor, kept), controller=Manual(), on_collision="continue")
        robots = [player if other is chosen else other for other in scenario.robots]
        return _play(
            attrs.evolve(scenario, robots=robots, resolved=None), player.name, sensor, commands, replicas, every
        )

    reference = play(set())
    is_angle = unit.sensor.unit == "rad"
    whole = _difference(play(set(names)), reference, is_angle)
    cases = [_case("all together", whole, whole)]
    cases += [_case(name, _difference(play({name}), reference, is_angle), whole) for name in names]
    return ReadingAttribution(
        robot=chosen.name,
        sensor=sensor,
        unit=unit.sensor.unit,
        time=np.arange(1.0, len(reference) + 1.0) * (scenario.dt * every),
        cases=tuple(cases[1:]),
        together=cases[0],
    )


def _unit(robot: Robot, sensor: str) -> MountedSensor:
    if sensor not in robot.sensors:
        raise AmorsimError(no_such("sensor", sensor, robot.sensors, whose=f"robot {robot.name!r}"))
    unit = robot.sensors[sensor]
    columns = unit.sensor.columns()
    if columns:
        raise AmorsimError(
            f"robot {robot.name!r}, sensor {sensor!r}: its values are of several quantities ({', '.join(columns)}), "
            "whose errors have no sum"
        )
    return unit


def _names(robot: Robot, sensor: str) -> list[str]:
    prefix = f"sensors.{sensor}."
    names = [f"errors.{path}" for path in robot.errors if path.startswith(prefix)]
    return names + [f"{prefix}noise.{element.name}" for element in robot.sensors[sensor].noise]


def _with_only(robot: Robot, sensor: str, kept: set[str]) -> Robot:
    """The robot with these errors of the sensor alone."""
    prefix = f"sensors.{sensor}."
    unit = robot.sensors[sensor]
    chain = tuple(element for element in unit.noise if f"{prefix}noise.{element.name}" in kept)
    errors = {p: e for p, e in robot.errors.items() if not p.startswith(prefix) or f"errors.{p}" in kept}
    return attrs.evolve(robot, errors=errors, sensors={**robot.sensors, sensor: attrs.evolve(unit, noise=chain)})


def _commands(scenario: Scenario, robot: Robot) -> Array:
    """The controller's commands in the unchanged scenario, step by step `(T, c)`, devices included."""
    simulation = Simulation(scenario)
    group, row = simulation._fleet.robot_row(robot.name, 0)
    commands = []
    for _ in range(simulation.steps_of(scenario.duration)):
        simulation.step()
        commands.append(group.command[row].copy())
    return np.array(commands)


def _play(scenario: Scenario, name: str, sensor: str, commands: Array, replicas: int, every: int) -> Array:
    """The sensor's measured values `(T, R, k)` under these commands, at every `every`-th step."""
    simulation = Simulation(scenario, replicas=replicas)
    found = [simulation._fleet.robot_row(name, index) for index in range(replicas)]
    group, rows = found[0][0], [row for _, row in found]
    kept = []
    for step, command in enumerate(commands, start=1):
        group.driver.state["command"][rows] = command
        simulation.step()
        if step % every == 0:
            kept.append(group.sensors[sensor].reading.measured[rows])
    return np.array(kept)


def _difference(measured: Array, reference: Array, is_angle: bool) -> Array:
    """The errors of readings; nan where neither returned, inf where only one did."""
    both = np.isfinite(measured) & np.isfinite(reference)
    only = np.isfinite(measured) != np.isfinite(reference)
    error = np.where(both, measured, 0.0) - np.where(both, reference, 0.0)
    if is_angle:
        error = wrap_angle(error)
    return np.where(both, error, np.where(only, np.inf, np.nan))


def _case(name: str, error: Array, whole: Array) -> ReadingCase:
    fine, both = np.isfinite(error), np.isfinite(error) & np.isfinite(whole)
    along = float(np.sum(np.where(both, error, 0.0) * np.where(both, whole, 0.0)))
    square = float(np.sum(np.where(both, whole, 0.0) ** 2))
    return ReadingCase(
        name=name,
        error=_root_mean_square(error, fine),
        share=along / square if square > 0.0 else 0.0,
        changed=float(np.isinf(error).mean()),
        by_step=np.array([_root_mean_square(e, f) for e, f in zip(error, fine, strict=True)]),
    )


def _root_mean_square(error: Array, which: Bools) -> float:
    count = int(which.sum())
    return math.sqrt(float(np.sum(np.where(which, error, 0.0) ** 2)) / count) if count else 0.0
