"""What robots cost that differ from the shipped Pioneer in one thing: a sensor, an element of noise, an estimator.

All follow commands in the office, in turn, round after round. A row tells how many times as long as the plain Pioneer's
its step takes.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import attrs
import numpy as np
import numpy.typing as npt

import amorsim as am
from benchmarks import worlds
from benchmarks.contest import Clock
from benchmarks.ours import pioneer
from benchmarks.results import Row
from benchmarks.task import DT

__all__ = ["measure"]

SECTION = "compositions"
Array = npt.NDArray[np.float64]
_STEPS = 1000
_PLAIN = "as shipped, commands given"


@attrs.frozen(kw_only=True)
class Heading(am.Sensor):
    """A sensor as a plugin has it, in NumPy: the heading in the world."""

    unit = "rad"

    def size(self, drive: am.Drive) -> int:
        """One value."""
        return 1

    def sense(self, view: am.View, aim: am.Aim, state: Any, draws: Any) -> tuple[Array, Mapping[str, Array]]:
        """Headings `(N, 1)` [rad]."""
        return view.pose[:, 2:].copy(), {}


@attrs.frozen(kw_only=True)
class Command(am.Controller):
    """A slow curve, given without a thought."""

    def command(self, robot: Any, readings: Any, estimate: Any, clock: Any, state: Any, draws: Any) -> Array:
        """The same wheel rates `(N, 2)` [rad/s] for all."""
        return np.tile((1.5, 1.8), (robot.rows, 1))


def _by_python(readings: Any, _estimate: Any, _clock: Any, speed: float = 0.1) -> tuple[float, float]:
    """A user's controller: one robot, plain Python."""
    return speed, 0.05 if readings["laser"].measured.min() > 0.3 else -0.05


def measure(rounds: int, quick: bool, clock: Clock, say: Callable[[str], None]) -> list[Row]:
    """The rows, of one robot and of a thousand replicas of it."""
    rows: list[Row] = []
    for replicas, steps in ((1, _STEPS), (1000, 5)):
        sides = {name: _simulation(make, replicas) for name, make in _COMPOSITIONS.items()}
        found: dict[str, list[float]] = {name: [] for name in sides}
        for number in range(rounds):
            say(f"compositions: {replicas} rows, round {number + 1}")
            for name, simulation in sides.items():
                found[name].append(_microseconds(simulation, 3 if quick else steps, clock))
        plain = found.pop(_PLAIN)
        where = f"{replicas} row{'s' if replicas > 1 else ''}"
        rows.append(_row(f"{_PLAIN}, {where}", "us a step", plain))
        rows += [
            _row(f"{name}, {where}", "times as long", [a / b for a, b in zip(times, plain, strict=True)])
            for name, times in found.items()
        ]
    return rows


def _row(setting: str, unit: str, rounds: list[float]) -> Row:
    return Row(section=SECTION, setting=setting, side="amorsim", unit=unit, rounds=tuple(rounds))


def _microseconds(simulation: am.Simulation, steps: int, clock: Clock) -> float:
    started = clock()
    for _ in range(steps):
        simulation.step()
    return (clock() - started) / steps * 1e6


def _simulation(make: Callable[[am.Robot], am.Robot | tuple[am.Robot, am.Obstacle]], replicas: int) -> am.Simulation:
    world = worlds.office()
    plain = attrs.evolve(pioneer("rover", worlds.places(world, 1, 1.0)[0]), controller=Command())
    made = make(plain)
    robot, *obstacles = made if isinstance(made, tuple) else (made,)
    scenario = am.Scenario(map=world.map, robots=[robot], obstacles=obstacles, dt=DT, seed=11)
    simulation = am.Simulation(scenario, replicas=replicas)
    for _ in range(20):
        simulation.step()
    return simulation


def _laser(robot: am.Robot, **changes: Any) -> am.Robot:
    laser = attrs.evolve(robot.sensors["laser"], **changes)
    return attrs.evolve(robot, sensors=dict(robot.sensors) | {"laser": laser})


def _noisier(robot: am.Robot, element: am.Noise) -> am.Robot:
    return _laser(robot, noise=(*robot.sensors["laser"].noise, element))


def _with_post(robot: am.Robot) -> tuple[am.Robot, am.Obstacle]:
    assert robot.pose is not None
    far = worlds.places(worlds.office(), 50, 1.0)
    place = far[int(np.argmax(np.hypot(far[:, 0] - robot.pose.x, far[:, 1] - robot.pose.y)))]
    return robot, am.Obstacle(name="post", shape=am.Shape.circle(0.1), pose=am.Pose(x=place[0], y=place[1]))


def _estimators(robot: am.Robot) -> am.Robot:
    return attrs.evolve(robot, estimators=dict(robot.estimators) | {"second": am.estimators.DeadReckoning()})


def _typical(robot: am.Robot) -> am.Robot:
    model = am.load_robot("pioneer2dx-typical")
    return attrs.evolve(model, name=robot.name, controller=robot.controller, pose=robot.pose)


_COMPOSITIONS: Mapping[str, Callable[[am.Robot], Any]] = {
    _PLAIN: lambda robot: robot,
    "a user's controller in Python": lambda robot: attrs.evolve(robot, controller=_by_python),
    "a sensor of a plugin": lambda robot: attrs.evolve(robot, sensors=dict(robot.sensors) | {"heading": Heading()}),
    "two estimators": _estimators,
    "an obstacle, far away": _with_post,
    "laser at 5 Hz": lambda robot: _laser(robot, rate=5.0),
    "laser with latency": lambda robot: _laser(robot, latency=0.2),
    "dropout on the laser": lambda robot: _noisier(robot, am.noise.Dropout(probability=0.01)),
    "GPS": lambda robot: attrs.evolve(robot, sensors=dict(robot.sensors) | {"gps": am.sensors.Gps()}),
    "wheel slip": lambda robot: attrs.evolve(robot, ground=(am.noise.Slip(at=0.0, duration=1e9, factor=0.98),)),
    "pioneer2dx-typical": _typical,
}
